//! One level: a symmetric operator in rows of blocks, and its Gauss–Seidel sweeps.
//!
//! A forward sweep from zero leaves the residual −U·x, for the blocks U above the diagonal: the first half of a cycle reads every
//! block once, and so does the backward sweep that ends it. One is the adjoint of the other, and either converges for any
//! symmetric positive matrix: so the cycle is symmetric and positive, whatever the coarser levels are the Galerkin operators of.

use super::super::empty;
use super::super::pattern::Pattern;
use super::interpolation::Parts;
use crate::systems::kernels::block::{self, Block};
use crate::systems::kernels::simd::wide;
use crate::systems::parallel;
use glam::Vec4;

/// The numbers of a level. Rows and columns of prescribed axes are zero.
#[derive(Debug, Default)]
pub struct Level {
    /// Where the blocks stand.
    pub pattern: Pattern,
    /// Blocks on the diagonal \[N/mm\].
    pub diagonal: Vec<Block>,
    /// Blocks below it.
    pub lower: Vec<Block>,
    /// Blocks above it: the transposes.
    pub upper: Vec<Block>,
    /// Inverses of those on the diagonal \[mm/N\].
    pub inverse: Vec<Block>,
    /// Free axes (1) of every row.
    pub free: Vec<Vec4>,
    /// Right-hand side, where it is not the solver's \[N\].
    pub r: Vec<Vec4>,
    /// Answer \[mm\].
    pub x: Vec<Vec4>,
}

/// Parts of its trace by which a block is raised that is not positive, the least that will do.
const RAISES: [f32; 4] = [1e-6, 1e-4, 1e-2, 1.0];

impl Level {
    /// Zeroes prescribed rows and columns, makes the diagonal invertible and inverts it, mirrors the rest.
    pub fn finish(&mut self) {
        let Self { pattern, diagonal, lower, upper, inverse, free, .. } = self;
        let n = diagonal.len();
        parallel::for_rows(diagonal, |row, diagonal| {
            let own = block::mask(diagonal, free[row], free[row]);
            let trace = own[0].x + own[1].y + own[2].z;
            let unit = block::mask(&[Vec4::X, Vec4::Y, Vec4::Z], free[row], free[row]);
            let mut raised = RAISES.iter().map(|part| block::sum(&own, &unit, part * trace));
            *diagonal = if block::invert(&own, free[row]).is_some() {
                own
            } else {
                raised.find(|raised| block::invert(raised, free[row]).is_some()).unwrap_or(block::ZERO)
            };
        });
        empty(inverse, n);
        inverse.resize(n, block::ZERO);
        parallel::for_rows(inverse, |row, inverse| {
            *inverse = block::invert(&diagonal[row], free[row]).unwrap_or(block::ZERO);
        });
        if free.iter().any(|free| *free != FREE) {
            for row in 0..n {
                for k in pattern.row_start[row] as usize..pattern.row_start[row + 1] as usize {
                    lower[k] = block::mask(&lower[k], free[row], free[pattern.column[k] as usize]);
                }
            }
        }
        pattern.mirror(lower, upper);
        for vector in [&mut self.r, &mut self.x] {
            empty(vector, n);
            vector.resize(n, Vec4::ZERO);
        }
    }

    /// x = (D + L)⁻¹·r.
    #[inline(always)]
    pub fn forward(&self, x: &mut [Vec4], mut r: impl FnMut(usize, Vec4) -> Vec4) {
        let pattern = &self.pattern;
        wide(|| {
            for row in 0..x.len() {
                let mut y = r(row, x[row]);
                let blocks = pattern.row_start[row] as usize..pattern.row_start[row + 1] as usize;
                for (l, &column) in self.lower[blocks.clone()].iter().zip(&pattern.column[blocks]) {
                    y -= block::apply(l, x[column as usize]);
                }
                x[row] = block::apply(&self.inverse[row], y);
            }
        });
    }

    /// `coarse` = Pᵀ·(r − A·x) after [`Level::forward`].
    pub fn restrict(&self, x: &[Vec4], parts: &[Parts], coarse: &mut [Vec4]) {
        let pattern = &self.pattern;
        coarse.fill(Vec4::ZERO);
        wide(|| {
            for (row, parts) in parts.iter().enumerate() {
                let mut y = Vec4::ZERO;
                let blocks = pattern.column_start[row] as usize..pattern.column_start[row + 1] as usize;
                for (u, &[column, _]) in self.upper[blocks.clone()].iter().zip(&pattern.below[blocks]) {
                    y -= block::apply(u, x[column as usize]);
                }
                for (node, weight) in parts.node.into_iter().zip(parts.weight) {
                    coarse[node as usize] += y * weight;
                }
            }
        });
    }

    /// x = (D + U)⁻¹·(r − L·x), calling `each(row, x)`.
    #[inline(always)]
    pub fn backward(&self, x: &mut [Vec4], r: impl Fn(usize) -> Vec4, mut each: impl FnMut(usize, Vec4)) {
        let pattern = &self.pattern;
        wide(|| {
            for row in (0..x.len()).rev() {
                let mut y = r(row);
                let blocks = pattern.row_start[row] as usize..pattern.row_start[row + 1] as usize;
                for (l, &column) in self.lower[blocks.clone()].iter().zip(&pattern.column[blocks]) {
                    y -= block::apply(l, x[column as usize]);
                }
                let blocks = pattern.column_start[row] as usize..pattern.column_start[row + 1] as usize;
                for (u, &[column, _]) in self.upper[blocks.clone()].iter().zip(&pattern.below[blocks]) {
                    y -= block::apply(u, x[column as usize]);
                }
                x[row] = block::apply(&self.inverse[row], y);
                each(row, x[row]);
            }
        });
    }
}

/// No axis prescribed.
pub const FREE: Vec4 = Vec4::new(1.0, 1.0, 1.0, 0.0);

/// x += P·coarse.
pub fn prolong(x: &mut [Vec4], parts: &[Parts], coarse: &[Vec4]) {
    parallel::for_rows(x, |row, x| {
        let Parts { node: [a, b, c], weight: [u, v, w] } = parts[row];
        *x += coarse[a as usize] * u + coarse[b as usize] * v + coarse[c as usize] * w;
    });
}

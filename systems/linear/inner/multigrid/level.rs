//! One level: a symmetric operator in rows of blocks, and its Gauss–Seidel sweeps.
//!
//! A forward sweep from zero leaves the residual −U·x, for the blocks U above the diagonal: the first half of a cycle reads every
//! block once, and so does the backward sweep that ends it. One is the adjoint of the other, and either converges for any
//! symmetric positive matrix: so the cycle is symmetric and positive, whatever the coarser levels are the Galerkin operators of.

use super::super::empty;
use super::super::matrix::dot;
use super::super::pattern::Pattern;
use super::numbering::Numbering;
use crate::systems::kernels::block::{self, Block};
use crate::systems::kernels::lanes::Lanes;
use crate::systems::kernels::simd::Kernel;
use crate::systems::parallel;
use glam::Vec4;

/// No axis prescribed.
pub const FREE: Vec4 = Vec4::new(1.0, 1.0, 1.0, 0.0);

/// The numbers of a level. Rows and columns of prescribed axes are zero.
#[derive(Debug, Default)]
pub struct Level {
    /// The order of the rows.
    pub numbering: Numbering,
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
}

/// Vectors of a level.
#[derive(Debug, Default)]
pub struct Vectors {
    /// Right-hand side, where it is not the solver's \[N\].
    pub r: Vec<Vec4>,
    /// Answer \[mm\].
    pub x: Vec<Vec4>,
    /// What the forward sweep leaves of the right-hand side \[N\].
    pub left: Vec<Vec4>,
}

/// Parts of its trace by which a block is raised that is not positive, the least that will do.
const RAISES: [f32; 4] = [1e-6, 1e-4, 1e-2, 1.0];

impl Level {
    /// Zeroes prescribed rows and columns, makes the diagonal invertible and inverts it, mirrors the rest.
    pub fn finish(&mut self) {
        let Self { pattern, diagonal, lower, upper, inverse, free, .. } = self;
        parallel::for_rows(diagonal, |row, diagonal| {
            let own = block::mask(diagonal, free[row], free[row]);
            let trace = own[0].x + own[1].y + own[2].z;
            let unit = block::mask(&[Vec4::X, Vec4::Y, Vec4::Z], free[row], free[row]);
            let mut raised = RAISES.iter().map(|part| block::sum(&own, &unit, part * trace));
            let is_positive = |block: &Block| block::invert(block, free[row]).is_some();
            // All of the cycle takes the raised block for the operator's: its levels are still those of one operator.
            *diagonal = if is_positive(&own) { own } else { raised.find(is_positive).unwrap_or(block::ZERO) };
        });
        empty(inverse, diagonal.len());
        inverse.resize(diagonal.len(), block::ZERO);
        parallel::for_rows(inverse, |row, inverse| {
            *inverse = block::invert(&diagonal[row], free[row]).unwrap_or(block::ZERO);
        });
        if free.iter().any(|free| *free != FREE) {
            for row in 0..diagonal.len() {
                for k in pattern.before(row) {
                    lower[k] = block::mask(&lower[k], free[row], free[pattern.column[k] as usize]);
                }
            }
        }
        pattern.mirror(lower, upper);
    }

    /// x = (D + L)⁻¹·r; returns x·D·x.
    pub fn forward(&self, x: &mut [Vec4], partials: &mut Vec<f64>, r: impl Fn(usize) -> Vec4 + Sync) -> f64 {
        let (first, second) = x.split_at_mut(self.numbering.first as usize);
        let size = self.numbering.size();
        let of_first =
            parallel::sum_pieces(first, size, partials, &Forward { level: self, offset: 0, other: &[], r: &r });
        let offset = first.len();
        of_first + parallel::sum_pieces(second, size, partials, &Forward { level: self, offset, other: first, r: &r })
    }

    /// `y` less what the columns before a row bring to it: those before the piece that begins at `start` are of the other colour.
    #[inline(always)]
    fn subtract_before(&self, mut y: Vec4, row: usize, start: usize, other: &[Vec4], x: &[Vec4]) -> Vec4 {
        let blocks = self.pattern.before(row);
        for (l, &column) in self.lower[blocks.clone()].iter().zip(&self.pattern.column[blocks]) {
            let column = column as usize;
            y -= block::apply(l, if column < start { other[column] } else { x[column - start] });
        }
        y
    }

    /// `left` = r − A·x after [`Level::forward`].
    pub fn subtract(&self, x: &[Vec4], left: &mut [Vec4]) {
        parallel::for_chunks(left, &Subtract { level: self, x });
    }

    /// x = (D + U)⁻¹·(r − L·x).
    pub fn backward(&self, x: &mut [Vec4], r: impl Fn(usize) -> Vec4 + Sync) {
        let (first, second) = x.split_at_mut(self.numbering.first as usize);
        let size = self.numbering.size();
        parallel::for_pieces(second, size, &Backward { level: self, offset: first.len(), other: first, r: &r });
        let second = &*second;
        parallel::for_pieces(first, size, &Backward { level: self, offset: 0, other: second, r: &r });
    }
}

/// A forward sweep over a chunk.
struct Forward<'a, R> {
    level: &'a Level,
    /// First row of the colour.
    offset: usize,
    /// The colour before this one.
    other: &'a [Vec4],
    r: &'a R,
}

impl<R: Fn(usize) -> Vec4 + Sync> Kernel<Vec4, f64> for Forward<'_, R> {
    #[inline(always)]
    fn run<L: Lanes>(&self, _: L, first: usize, x: &mut [Vec4]) -> f64 {
        let Self { level, offset, other, r } = self;
        let start = offset + first;
        let mut product = 0.0;
        for i in 0..x.len() {
            let row = start + i;
            let y = level.subtract_before(r(row), row, start, other, x);
            x[i] = block::apply(&level.inverse[row], y);
            product += dot(x[i], y);
        }
        product
    }
}

/// What a forward sweep leaves.
struct Subtract<'a> {
    level: &'a Level,
    x: &'a [Vec4],
}

impl Kernel<Vec4> for Subtract<'_> {
    #[inline(always)]
    fn run<L: Lanes>(&self, _: L, first: usize, left: &mut [Vec4]) {
        let Level { pattern, upper, .. } = self.level;
        for (i, left) in left.iter_mut().enumerate() {
            let blocks = pattern.after(first + i);
            let mut y = Vec4::ZERO;
            for (u, &[column, _]) in upper[blocks.clone()].iter().zip(&pattern.below[blocks]) {
                y -= block::apply(u, self.x[column as usize]);
            }
            *left = y;
        }
    }
}

/// A backward sweep over a chunk.
struct Backward<'a, R> {
    level: &'a Level,
    /// First row of the colour.
    offset: usize,
    /// The other colour.
    other: &'a [Vec4],
    r: &'a R,
}

impl<R: Fn(usize) -> Vec4 + Sync> Kernel<Vec4> for Backward<'_, R> {
    #[inline(always)]
    fn run<L: Lanes>(&self, _: L, first: usize, x: &mut [Vec4]) {
        let Self { level, offset, other, r } = self;
        let Level { pattern, upper, inverse, numbering, .. } = level;
        let start = offset + first;
        for i in (0..x.len()).rev() {
            let row = start + i;
            let mut y = level.subtract_before(r(row), row, start, other, x);
            let blocks = pattern.after(row);
            let end = start + x.len();
            for (u, &[column, _]) in upper[blocks.clone()].iter().zip(&pattern.below[blocks]) {
                let column = column as usize;
                let value = if column < end { x[column - start] } else { other[column - numbering.first as usize] };
                y -= block::apply(u, value);
            }
            x[i] = block::apply(&inverse[row], y);
        }
    }
}

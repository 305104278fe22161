//! Incomplete Cholesky factor without fill, by 3×3 blocks: M = L·D·Lᵀ, L with the pattern of A (Meijerink, van der Vorst 1977).
//!
//! A body torn, folded and partly slack has stiff and soft directions side by side, and changes from step to step: the factor is
//! made anew for every solve, which costs as much as a few iterations and saves three out of four of them. Both sweeps are
//! serial by nature; rows stand in an order in which neighbours are far apart (see [`super::order`]), so that the processor
//! works on several at a time.

use super::cg::{Precondition, Vectors};
use super::edits::Edits;
use super::matrix::{Matrix, dot};
use super::order::Order;
use super::partition::Partition;
use super::pattern::Pattern;
use crate::storage::Topology;
use crate::systems::kernels::block::{self, Block};
use crate::systems::kernels::simd::wide;
use glam::DVec2;

/// The factor.
#[derive(Debug, Default)]
pub struct Incomplete {
    /// Where the blocks stand.
    pattern: Pattern,
    /// Blocks of L.
    lower: Vec<Block>,
    /// Diagonal blocks of A, then the inverses of those of D.
    inverse: Vec<Block>,
    /// Blocks of L·D in the row at hand.
    row: Vec<Block>,
}

/// A pivot is to be at least this part of the body's own diagonal block, as quadratic forms: below, the fill that is left out
/// has used it up. (A direction that is soft in the block itself may be as soft in the pivot.)
const LEAST_PART: f32 = 0.1;

/// Parts of its own block by which a pivot that has been used up is raised, the least that will do.
const REPAIRS: [f32; 3] = [0.1, 0.3, 1.0];

impl Incomplete {
    /// Finds the pattern anew.
    pub fn rebuild(&mut self, partition: &Partition, order: &Order, corners: &[[u32; 3]], topology: &Topology) {
        self.pattern.rebuild(partition, (&order.vertex, &order.row), corners, topology);
    }

    /// Brings the pattern up to date after edits.
    pub fn follow(
        &mut self,
        partition: &Partition,
        order: &Order,
        corners: &[[u32; 3]],
        topology: &Topology,
        edits: &Edits,
    ) {
        self.pattern.follow(partition, (&order.vertex, &order.row), corners, topology, edits);
    }

    /// Factors the operator with its diagonal raised by a fraction `shift` of itself (Manteuffel 1980).
    pub fn factor(&mut self, partition: &Partition, matrix: &Matrix, shift: f32) {
        self.pattern.gather(partition, matrix, |row| row, &mut self.inverse, &mut self.lower);
        wide(|| self.eliminate(matrix, shift));
    }

    #[inline(always)]
    fn eliminate(&mut self, matrix: &Matrix, shift: f32) {
        for i in 0..self.inverse.len() {
            let (start, end) = (self.pattern.row_start[i] as usize, self.pattern.row_start[i + 1] as usize);
            let free = matrix.own[i][3];
            let own = block::mask(&self.inverse[i], free, free).map(|column| column * (1.0 + shift));
            let mut diagonal = own;
            self.row.clear();
            for k in start..end {
                let column = self.pattern.column[k] as usize;
                let mut w = block::mask(&self.lower[k], free, matrix.own[column][3]);
                let mut other = self.pattern.row_start[column] as usize;
                let other_end = self.pattern.row_start[column + 1] as usize;
                // Both rows ascend.
                for j in start..k {
                    while other < other_end && self.pattern.column[other] < self.pattern.column[j] {
                        other += 1;
                    }
                    if other < other_end && self.pattern.column[other] == self.pattern.column[j] {
                        block::subtract_product_transposed(&mut w, &self.row[j - start], &self.lower[other]);
                    }
                }
                let l = block::product(&w, &self.inverse[column]);
                block::subtract_product_transposed(&mut diagonal, &w, &l);
                self.lower[k] = l;
                self.row.push(w);
            }
            let is_sound = |d: &Block| block::is_positive(&block::sum(d, &own, -LEAST_PART), free);
            if !is_sound(&diagonal) {
                let mut repaired = REPAIRS.iter().map(|&part| block::sum(&diagonal, &own, part));
                diagonal = repaired.find(is_sound).unwrap_or(own);
            }
            self.inverse[i] = block::invert(&diagonal, free).unwrap_or_else(|| block::invert_alone(&own, free));
        }
    }
}

impl Precondition for Incomplete {
    fn descend(&mut self, alpha: f32, vectors: &mut Vectors) -> DVec2 {
        let Vectors { xr, p, q, z, .. } = vectors;
        let mut sums = DVec2::ZERO;
        wide(|| {
            for (i, [x, r]) in xr.iter_mut().enumerate() {
                *x += p[i] * alpha;
                *r -= q[i] * alpha;
                let mut y = *r;
                let row = self.pattern.row_start[i] as usize..self.pattern.row_start[i + 1] as usize;
                for (l, &j) in self.lower[row.clone()].iter().zip(&self.pattern.column[row]) {
                    y -= block::apply(l, z[j as usize]);
                }
                z[i] = y;
                // D⁻¹·y, from which the way up subtracts; A·p has been used up.
                q[i] = block::apply(&self.inverse[i], y);
                sums += DVec2::new(dot(*r, *r), dot(y, q[i]));
            }
        });
        sums
    }

    fn ascend(&mut self, beta: f32, vectors: &mut Vectors) {
        let Vectors { p, q: all, .. } = vectors;
        wide(|| {
            // Lᵀ by the rows of L: a row that is done is subtracted from those above it.
            for i in (0..p.len()).rev() {
                let z = all[i];
                let row = self.pattern.row_start[i] as usize..self.pattern.row_start[i + 1] as usize;
                for (l, &j) in self.lower[row.clone()].iter().zip(&self.pattern.column[row]) {
                    all[j as usize] -= block::apply_transposed(l, z);
                }
                p[i] = z + p[i] * beta;
            }
        });
    }
}

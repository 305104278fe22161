//! Incomplete Cholesky factor with the fill of level one, by 3×3 blocks: M = L·D·Lᵀ, L with the pattern of A and what eliminating
//! one row of A puts between its later neighbours (Meijerink, van der Vorst 1977; levels: Watts 1981).
//!
//! A body torn, folded and partly slack has stiff and soft directions side by side, and changes from step to step: the factor is
//! made anew for every solve, which costs as much as a few iterations and saves three out of four of them. Both sweeps are
//! serial by nature; rows stand in an order in which neighbours are far apart (see [`super::order`]), so that the processor
//! works on several at a time. They take the blocks of a row two by two.

use super::cg::{Precondition, Vectors};
use super::edits::Edits;
use super::empty;
use super::matrix::Matrix;
use super::order::Order;
use super::partition::Partition;
use super::pattern::Pattern;
use crate::storage::Topology;
use crate::systems::kernels::block::{self, Block};
use crate::systems::kernels::block_pair::{self, BlockPair};
use crate::systems::kernels::lanes::{Doubles, Lanes, Singles};
use crate::systems::kernels::simd::{Pass, pass, wide};
use glam::DVec2;

/// The factor.
#[derive(Debug)]
pub struct Incomplete {
    /// Where the blocks stand.
    pattern: Pattern,
    /// Blocks of L, two by two.
    lower: Vec<BlockPair>,
    /// Diagonal blocks of A, then the inverses of those of D.
    inverse: Vec<Block>,
    /// Blocks of L·D in the row at hand.
    row: Vec<Block>,
}

impl Default for Incomplete {
    fn default() -> Self {
        Self { pattern: Pattern::filled(), lower: Vec::new(), inverse: Vec::new(), row: Vec::new() }
    }
}

/// A pivot is to be at least this part of the body's own diagonal block, as quadratic forms: below, the fill that is left out
/// has used it up. (A direction that is soft in the block itself may be as soft in the pivot.)
const LEAST_PART: f32 = 0.1;

/// The least step of conjugate gradients with a sound factor: on the torn capsule they are longer than 1e-6. Where soft directions are but
/// rounding of stiff ones, L may grow without bound though no pivot tells, and steps are 1e-9 to 1e-19.
const LEAST_STEP: f64 = 1e-8;

/// Parts of its own block by which a pivot that has been used up is raised, the least that will do.
const REPAIRS: [f32; 3] = [0.1, 0.3, 1.0];

/// Rows of more blocks take more room when one comes: vertices have some six neighbours, of which half come before.
const LONGEST_ROW: usize = 64;

impl Incomplete {
    /// Finds the pattern anew; the order has the neighbours of the vertices.
    pub fn rebuild(&mut self, partition: &Partition, order: &Order, corners: &[[u32; 3]]) {
        self.pattern.rebuild(partition, (&order.vertex, &order.row), corners, |v| order.adjacency.of(v));
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
        let stays = |row: usize| !edits.is_touched[row];
        self.pattern.follow(partition, (&order.vertex, &order.row), corners, topology, edits, stays);
    }

    /// Factors the operator with its diagonal raised by a fraction `shift` of itself (Manteuffel 1980).
    pub fn factor(&mut self, partition: &Partition, matrix: &Matrix, shift: f32) {
        let Self { pattern, lower, inverse, .. } = self;
        empty(lower, pattern.column.len() / 2);
        lower.resize(pattern.column.len() / 2, block_pair::ZERO);
        pattern.gather(partition, matrix, |row| row, inverse, |k, block| block_pair::add(lower, k, block));
        wide(|| self.eliminate(matrix, shift));
    }

    #[inline(always)]
    fn eliminate(&mut self, matrix: &Matrix, shift: f32) {
        self.row.clear();
        self.row.reserve(LONGEST_ROW);
        for i in 0..self.inverse.len() {
            let (start, end) = (self.pattern.row_start[i] as usize, self.pattern.row_start[i + 1] as usize);
            let free = matrix.own[i][3];
            let own = block::mask(&self.inverse[i], free, free).map(|column| column * (1.0 + shift));
            let mut diagonal = own;
            self.row.clear();
            for k in start..end {
                let column = self.pattern.column[k] as usize;
                if column == i {
                    // There for the length to be even.
                    break;
                }
                let mut w = block::mask(&block_pair::get(&self.lower, k), free, matrix.own[column][3]);
                let mut other = self.pattern.row_start[column] as usize;
                let other_end = self.pattern.row_start[column + 1] as usize;
                // Both rows ascend.
                for j in start..k {
                    while other < other_end && self.pattern.column[other] < self.pattern.column[j] {
                        other += 1;
                    }
                    if other < other_end && self.pattern.column[other] == self.pattern.column[j] {
                        let other = block_pair::get(&self.lower, other);
                        block::subtract_product_transposed(&mut w, &self.row[j - start], &other);
                    }
                }
                let l = block::product(&w, &self.inverse[column]);
                block::subtract_product_transposed(&mut diagonal, &w, &l);
                block_pair::set(&mut self.lower, k, &l);
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

impl Incomplete {
    /// The blocks of a row and their columns.
    #[inline(always)]
    fn row(&self, i: usize) -> impl Iterator<Item = (&BlockPair, &[u32; 2])> {
        let blocks = self.pattern.before(i);
        let (columns, _) = self.pattern.column[blocks.clone()].as_chunks();
        self.lower[blocks.start / 2..blocks.end / 2].iter().zip(columns)
    }
}

impl Precondition for Incomplete {
    const LEAST_STEP: f64 = LEAST_STEP;

    fn descend(&mut self, alpha: f32, vectors: &mut Vectors) -> DVec2 {
        pass(Descent { factor: self, alpha, vectors })
    }

    fn ascend(&mut self, beta: f32, vectors: &mut Vectors) {
        pass(Ascent { factor: self, beta, vectors });
    }
}

/// The way down.
struct Descent<'a> {
    factor: &'a Incomplete,
    alpha: f32,
    vectors: &'a mut Vectors,
}

impl Pass for Descent<'_> {
    type Output = DVec2;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> DVec2 {
        let Self { factor, alpha, vectors: Vectors { xr, p, q, z, .. } } = self;
        let (mut rr, mut rz) = (Doubles::splat(lanes, 0.0), Doubles::splat(lanes, 0.0));
        for (i, [x, r]) in xr.iter_mut().enumerate() {
            *x += p[i] * alpha;
            *r -= q[i] * alpha;
            let mut sum = Singles::splat(lanes, 0.0);
            for (pair, &[j, k]) in factor.row(i) {
                sum = sum + block_pair::apply(lanes, pair, z[j as usize], z[k as usize]);
            }
            let [even, odd] = sum.to_array();
            let y = *r - (even + odd);
            z[i] = y;
            // D⁻¹·y, from which the way up subtracts; A·p has been used up.
            q[i] = block::apply(&factor.inverse[i], y);
            rr = rr + Doubles::widened(lanes, *r * *r);
            rz = rz + Doubles::widened(lanes, y * q[i]);
        }
        let total = |sums: Doubles<L>| sums.to_array().iter().sum();
        DVec2::new(total(rr), total(rz))
    }
}

/// The way up.
struct Ascent<'a> {
    factor: &'a Incomplete,
    beta: f32,
    vectors: &'a mut Vectors,
}

impl Pass for Ascent<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let Self { factor, beta, vectors: Vectors { p, q: all, .. } } = self;
        // Lᵀ by the rows of L: a row that is done is subtracted from those above it.
        for i in (0..p.len()).rev() {
            let z = all[i];
            for (pair, &[j, k]) in factor.row(i) {
                let [to_j, to_k] = block_pair::apply_transposed(lanes, pair, z);
                all[j as usize] -= to_j;
                all[k as usize] -= to_k;
            }
            p[i] = z + p[i] * beta;
        }
    }
}

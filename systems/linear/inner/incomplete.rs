//! Incomplete Cholesky factor with the fill of level one, by 3×3 blocks, in a plane by 2×2: M = L·D·Lᵀ, L with the pattern of A and
//! what eliminating one row of A puts between its later neighbours (Meijerink, van der Vorst 1977; levels: Watts 1981).
//!
//! A body torn, folded and partly slack has stiff and soft directions side by side, and changes from step to step: the factor is
//! made anew for every solve, which costs as much as a few iterations and saves three out of four of them. Both sweeps are
//! serial by nature; rows stand in an order in which neighbours are far apart (see [`super::order`]), so that the processor
//! works on several at a time. They take the blocks of a row two by two.

use super::adjacency::Adjacency;
use super::cg::{Precondition, Vectors};
use super::edits::Edits;
use super::empty;
use super::matrix::{Matrix, OfPacks};
use super::order::Order;
use super::partition::Partition;
use super::pattern::Pattern;
use crate::storage::Topology;
use crate::systems::kernels::block::Block;
use crate::systems::kernels::factor_block::FactorBlock;
use crate::systems::kernels::flat_block::FlatBlock;
use crate::systems::kernels::lanes::{Doubles, Lanes, Singles};
use crate::systems::kernels::simd::{Pass, pass, wide};
use glam::DVec2;

/// The factor.
#[derive(Debug)]
pub struct Incomplete {
    /// Where the blocks stand.
    pattern: Pattern,
    /// Its numbers for a body in space, or for one in a plane.
    solid: Numbers<Block>,
    flat: Numbers<FlatBlock>,
    is_flat: bool,
}

/// The numbers of a factor.
#[derive(Debug)]
struct Numbers<B: FactorBlock> {
    /// Blocks of L, two by two.
    lower: Vec<B::Pair>,
    /// Diagonal blocks of A, then the inverses of those of D.
    inverse: Vec<B>,
    /// Blocks of L·D in the row at hand.
    row: Vec<B>,
}

impl<B: FactorBlock> Default for Numbers<B> {
    fn default() -> Self {
        Self { lower: Vec::new(), inverse: Vec::new(), row: Vec::new() }
    }
}

impl Default for Incomplete {
    fn default() -> Self {
        Self { pattern: Pattern::filled(), solid: Numbers::default(), flat: Numbers::default(), is_flat: false }
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
    /// Finds the pattern anew.
    pub fn rebuild(&mut self, partition: &Partition, order: &Order, corners: &[[u32; 3]], adjacency: &Adjacency) {
        self.pattern.rebuild(partition, (&order.vertex, &order.row), corners, |v| adjacency.of(v));
    }

    /// The lists of its pattern that only edits use.
    pub fn spare_lists(&mut self) -> [&mut Vec<u32>; 2] {
        self.pattern.spare_lists()
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
        self.is_flat = matrix.is_flat;
        if self.is_flat {
            self.flat.factor(&self.pattern, partition, matrix, shift);
        } else {
            self.solid.factor(&self.pattern, partition, matrix, shift);
        }
    }
}

impl<B: FactorBlock> Numbers<B> {
    /// The blocks of a row and their columns.
    #[inline(always)]
    fn row<'a>(&'a self, pattern: &'a Pattern, i: usize) -> impl Iterator<Item = (&'a B::Pair, &'a [u32; 2])> {
        let blocks = pattern.before(i);
        let (columns, _) = pattern.column[blocks.clone()].as_chunks();
        self.lower[blocks.start / 2..blocks.end / 2].iter().zip(columns)
    }
}

impl<B: OfPacks> Numbers<B> {
    fn factor(&mut self, pattern: &Pattern, partition: &Partition, matrix: &Matrix, shift: f32) {
        let Self { lower, inverse, .. } = self;
        empty(lower, pattern.column.len() / 2);
        lower.resize(pattern.column.len() / 2, B::NO_PAIR);
        pattern.gather(partition, matrix, |row| row, inverse, |k, block| B::add_to(lower, k, block));
        wide(|| self.eliminate(pattern, matrix, shift));
    }

    #[inline(always)]
    fn eliminate(&mut self, pattern: &Pattern, matrix: &Matrix, shift: f32) {
        self.row.clear();
        self.row.reserve(LONGEST_ROW);
        for i in 0..self.inverse.len() {
            let (start, end) = (pattern.row_start[i] as usize, pattern.row_start[i + 1] as usize);
            let free = matrix.own.free(i);
            let own = self.inverse[i].masked(free, free).scaled(1.0 + shift);
            let mut diagonal = own;
            self.row.clear();
            for k in start..end {
                let column = pattern.column[k] as usize;
                if column == i {
                    // There for the length to be even.
                    break;
                }
                let mut w = B::get(&self.lower, k).masked(free, matrix.own.free(column));
                let mut other = pattern.row_start[column] as usize;
                let other_end = pattern.row_start[column + 1] as usize;
                // Both rows ascend.
                for j in start..k {
                    while other < other_end && pattern.column[other] < pattern.column[j] {
                        other += 1;
                    }
                    if other < other_end && pattern.column[other] == pattern.column[j] {
                        w.subtract_product_transposed(&self.row[j - start], &B::get(&self.lower, other));
                    }
                }
                let l = w.product(&self.inverse[column]);
                diagonal.subtract_product_transposed(&w, &l);
                B::set(&mut self.lower, k, &l);
                self.row.push(w);
            }
            let is_sound = |d: &B| d.plus(&own, -LEAST_PART).is_positive(free);
            if !is_sound(&diagonal) {
                let mut repaired = REPAIRS.iter().map(|&part| diagonal.plus(&own, part));
                diagonal = repaired.find(is_sound).unwrap_or(own);
            }
            self.inverse[i] = diagonal.inverted(free).unwrap_or_else(|| own.inverted_alone(free));
        }
    }
}

impl Precondition for Incomplete {
    const LEAST_STEP: f64 = LEAST_STEP;

    fn descend(&mut self, alpha: f32, vectors: &mut Vectors) -> DVec2 {
        let Self { pattern, solid, flat, is_flat } = self;
        if *is_flat {
            pass(Descent { pattern, factor: flat, alpha, vectors })
        } else {
            pass(Descent { pattern, factor: solid, alpha, vectors })
        }
    }

    fn ascend(&mut self, beta: f32, vectors: &mut Vectors) {
        let Self { pattern, solid, flat, is_flat } = self;
        if *is_flat {
            pass(Ascent { pattern, factor: flat, beta, vectors });
        } else {
            pass(Ascent { pattern, factor: solid, beta, vectors });
        }
    }
}

/// The way down.
struct Descent<'a, B: FactorBlock> {
    pattern: &'a Pattern,
    factor: &'a Numbers<B>,
    alpha: f32,
    vectors: &'a mut Vectors,
}

impl<B: FactorBlock> Pass for Descent<'_, B> {
    type Output = DVec2;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> DVec2 {
        let Self { pattern, factor, alpha, vectors: Vectors { xr, p, q, z, .. } } = self;
        let (mut rr, mut rz) = (Doubles::splat(lanes, 0.0), Doubles::splat(lanes, 0.0));
        for (i, [x, r]) in xr.iter_mut().enumerate() {
            *x += p[i] * alpha;
            *r -= q[i] * alpha;
            let mut sum = Singles::splat(lanes, 0.0);
            for (pair, &[j, k]) in factor.row(pattern, i) {
                sum = sum + B::times_pair(lanes, pair, z[j as usize], z[k as usize]);
            }
            let y = *r - B::total(sum);
            z[i] = y;
            // D⁻¹·y, from which the way up subtracts; A·p has been used up.
            q[i] = B::only_axes(factor.inverse[i].times(y));
            rr = rr + Doubles::widened(lanes, *r * *r);
            rz = rz + Doubles::widened(lanes, y * q[i]);
        }
        let total = |sums: Doubles<L>| sums.to_array().iter().sum();
        DVec2::new(total(rr), total(rz))
    }
}

/// The way up.
struct Ascent<'a, B: FactorBlock> {
    pattern: &'a Pattern,
    factor: &'a Numbers<B>,
    beta: f32,
    vectors: &'a mut Vectors,
}

impl<B: FactorBlock> Pass for Ascent<'_, B> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let Self { pattern, factor, beta, vectors: Vectors { p, q: all, .. } } = self;
        // Lᵀ by the rows of L: a row that is done is subtracted from those above it.
        for i in (0..p.len()).rev() {
            let z = B::only_axes(all[i]);
            for (pair, &[j, k]) in factor.row(pattern, i) {
                let [to_j, to_k] = B::times_pair_transposed(lanes, pair, z);
                all[j as usize] -= to_j;
                all[k as usize] -= to_k;
            }
            p[i] = z + p[i] * beta;
        }
    }
}

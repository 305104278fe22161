//! Blocks of a factor in rows: 3×3 blocks, or 2×2 ones for a body in a plane, by themselves and two by two.

use super::block::{self, Block};
use super::block_pair::{self, BlockPair};
use super::flat_block::Coefficient;
use super::lanes::{Lanes, Singles};
use glam::Vec4;

/// A block of a factor.
pub trait FactorBlock: Coefficient {
    /// Two blocks of one row side by side.
    type Pair: Copy + Send + Sync;

    /// The zero block.
    const ZERO: Self;
    /// Two zero blocks.
    const NO_PAIR: Self::Pair;

    /// The block of this kind from a block in space: all of it, or the part along x and y.
    fn of(block: &Block) -> Self;
    /// The transpose.
    fn transposed(&self) -> Self;
    /// self += b.
    fn add(&mut self, b: &Self);
    /// a + b·factor.
    fn plus(&self, b: &Self, factor: f32) -> Self;
    /// a·factor.
    fn scaled(&self, factor: f32) -> Self;
    /// The largest number on the diagonal.
    fn largest(&self) -> f32;
    /// The product a·b.
    fn product(&self, b: &Self) -> Self;
    /// self −= a·bᵀ.
    fn subtract_product_transposed(&mut self, a: &Self, b: &Self);
    /// The rows and columns that are free (1), zeros elsewhere.
    fn masked(&self, rows: Vec4, columns: Vec4) -> Self;
    /// As [`block::is_positive`].
    fn is_positive(&self, free: Vec4) -> bool;
    /// As [`block::invert`].
    fn inverted(&self, free: Vec4) -> Option<Self>;
    /// As [`block::invert_alone`].
    fn inverted_alone(&self, free: Vec4) -> Self;

    /// The `k`-th block in a list of pairs.
    fn get(pairs: &[Self::Pair], k: usize) -> Self;
    /// Puts a block in the `k`-th place of a list of pairs.
    fn set(pairs: &mut [Self::Pair], k: usize, block: &Self);
    /// Adds a block to the one in the `k`-th place of a list of pairs.
    fn add_to(pairs: &mut [Self::Pair], k: usize, block: &Self);
    /// Partial products of blocks a and b, from which [`total`](Self::total) makes the sum a·u + b·v.
    fn times_pair<L: Lanes>(lanes: L, pair: &Self::Pair, u: Vec4, v: Vec4) -> Singles<L>;
    /// The sum of products.
    fn total<L: Lanes>(sum: Singles<L>) -> Vec4;
    /// The products aᵀ·u and bᵀ·u of blocks a and b; entries that are not an axis of them hold anything. That of `u` is zero in space.
    fn times_pair_transposed<L: Lanes>(lanes: L, pair: &Self::Pair, u: Vec4) -> [Vec4; 2];
}

impl FactorBlock for Block {
    type Pair = BlockPair;

    const ZERO: Self = block::ZERO;
    const NO_PAIR: BlockPair = block_pair::ZERO;

    #[inline(always)]
    fn of(block: &Block) -> Self {
        *block
    }

    #[inline(always)]
    fn transposed(&self) -> Self {
        block::transpose(self)
    }

    #[inline(always)]
    fn add(&mut self, b: &Self) {
        block::add(self, b);
    }

    #[inline(always)]
    fn plus(&self, b: &Self, factor: f32) -> Self {
        block::sum(self, b, factor)
    }

    #[inline(always)]
    fn largest(&self) -> f32 {
        self[0].x.max(self[1].y).max(self[2].z)
    }

    #[inline(always)]
    fn scaled(&self, factor: f32) -> Self {
        self.map(|column| column * factor)
    }

    #[inline(always)]
    fn product(&self, b: &Self) -> Self {
        block::product(self, b)
    }

    #[inline(always)]
    fn subtract_product_transposed(&mut self, a: &Self, b: &Self) {
        block::subtract_product_transposed(self, a, b);
    }

    #[inline(always)]
    fn masked(&self, rows: Vec4, columns: Vec4) -> Self {
        block::mask(self, rows, columns)
    }

    #[inline(always)]
    fn is_positive(&self, free: Vec4) -> bool {
        block::is_positive(self, free)
    }

    #[inline(always)]
    fn inverted(&self, free: Vec4) -> Option<Self> {
        block::invert(self, free)
    }

    #[inline(always)]
    fn inverted_alone(&self, free: Vec4) -> Self {
        block::invert_alone(self, free)
    }

    #[inline(always)]
    fn get(pairs: &[BlockPair], k: usize) -> Self {
        block_pair::get(pairs, k)
    }

    #[inline(always)]
    fn set(pairs: &mut [BlockPair], k: usize, block: &Self) {
        block_pair::set(pairs, k, block);
    }

    #[inline(always)]
    fn add_to(pairs: &mut [BlockPair], k: usize, block: &Self) {
        block_pair::add(pairs, k, block);
    }

    #[inline(always)]
    fn times_pair<L: Lanes>(lanes: L, pair: &BlockPair, u: Vec4, v: Vec4) -> Singles<L> {
        block_pair::apply(lanes, pair, u, v)
    }

    #[inline(always)]
    fn total<L: Lanes>(sum: Singles<L>) -> Vec4 {
        let [even, odd] = sum.to_array();
        even + odd
    }

    #[inline(always)]
    fn times_pair_transposed<L: Lanes>(lanes: L, pair: &BlockPair, u: Vec4) -> [Vec4; 2] {
        block_pair::apply_transposed(lanes, pair, u)
    }
}

//! Two 3×3 blocks of one row side by side: the operand that a wide processor multiplies at once.

use super::block::Block;
use super::lanes::{Lanes, Singles};
use glam::Vec4;

/// The columns of both, each of four numbers of which the last is zero.
pub type BlockPair = [[Vec4; 2]; 3];

/// Two zero blocks.
pub const ZERO: BlockPair = [[Vec4::ZERO; 2]; 3];

/// The `k`-th block in a list of pairs.
#[inline(always)]
pub fn get(pairs: &[BlockPair], k: usize) -> Block {
    pairs[k / 2].map(|column| column[k % 2])
}

/// Puts a block in the `k`-th place of a list of pairs.
#[inline(always)]
pub fn set(pairs: &mut [BlockPair], k: usize, block: &Block) {
    for (column, value) in pairs[k / 2].iter_mut().zip(block) {
        column[k % 2] = *value;
    }
}

/// Adds a block to the one in the `k`-th place of a list of pairs.
#[inline(always)]
pub fn add(pairs: &mut [BlockPair], k: usize, block: &Block) {
    for (column, value) in pairs[k / 2].iter_mut().zip(block) {
        column[k % 2] += *value;
    }
}

/// The products a·u and b·v of blocks a and b.
#[inline(always)]
pub fn apply<L: Lanes>(lanes: L, [x, y, z]: &BlockPair, u: Vec4, v: Vec4) -> Singles<L> {
    let [ux, uy, uz] = Singles::new(lanes, [u, v]).spread();
    Singles::new(lanes, *x) * ux + Singles::new(lanes, *y) * uy + Singles::new(lanes, *z) * uz
}

/// The products aᵀ·u and bᵀ·u of blocks a and b; the last number of `u` is zero.
#[inline(always)]
pub fn apply_transposed<L: Lanes>(lanes: L, [x, y, z]: &BlockPair, u: Vec4) -> [Vec4; 2] {
    let u = Singles::new(lanes, [u, u]);
    Singles::sums([Singles::new(lanes, *x) * u, Singles::new(lanes, *y) * u, Singles::new(lanes, *z) * u]).to_array()
}

#[cfg(test)]
mod tests {
    use super::super::block;
    use super::super::simd::{Pass, force_portable, pass};
    use super::*;

    /// Both products.
    struct Products<'a>(&'a BlockPair, [Vec4; 2]);

    impl Pass for Products<'_> {
        type Output = [[Vec4; 2]; 2];

        #[inline(always)]
        fn run<L: Lanes>(self, lanes: L) -> [[Vec4; 2]; 2] {
            let Self(pair, [u, v]) = self;
            [apply(lanes, pair, u, v).to_array(), apply_transposed(lanes, pair, u)]
        }
    }

    #[test]
    fn a_pair_multiplies_as_its_blocks_do() {
        let number = |i: usize| (0.7 * i as f32).sin();
        let block = |first: usize| {
            [0, 3, 6].map(|i| Vec4::new(number(first + i), number(first + i + 1), number(first + i + 2), 0.0))
        };
        let (a, b, [u, v, _]) = (block(1), block(10), block(20));
        let mut pairs = [ZERO];
        set(&mut pairs, 0, &a);
        add(&mut pairs, 1, &b);
        assert_eq!([get(&pairs, 0), get(&pairs, 1)], [a, b]);
        let was = force_portable(true);
        let portable = pass(Products(&pairs[0], [u, v]));
        force_portable(false);
        let wide = pass(Products(&pairs[0], [u, v]));
        force_portable(was);
        assert_eq!(portable, wide);
        assert_eq!(portable[0], [block::apply(&a, u), block::apply(&b, v)]);
        // Three numbers below one each, added in another order.
        let difference = |x: Vec4, y: Vec4| (x - y).abs().max_element();
        assert!(difference(portable[1][0], block::apply_transposed(&a, u)) < 4.0 * f32::EPSILON);
        assert!(difference(portable[1][1], block::apply_transposed(&b, u)) < 4.0 * f32::EPSILON);
    }
}

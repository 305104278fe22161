//! 2×2 blocks in single precision for a body in a plane: what a third of the memory of a [`super::block`] holds, and the product that
//! sweeps over either kind are made of.

use super::block::{self, Block};
use glam::{Vec4, Vec4Swizzles};

/// What a sweep over rows multiplies by.
pub trait Coefficient: Copy + Send + Sync {
    /// The product with a vector; what is not an axis of it holds anything.
    fn times(&self, v: Vec4) -> Vec4;
    /// A sum of such products, zero in what is not an axis.
    fn only_axes(sum: Vec4) -> Vec4;
}

impl Coefficient for Block {
    #[inline(always)]
    fn times(&self, v: Vec4) -> Vec4 {
        block::apply(self, v)
    }

    #[inline(always)]
    fn only_axes(sum: Vec4) -> Vec4 {
        sum
    }
}

/// A 2×2 block, column after column.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FlatBlock(Vec4);

impl FlatBlock {
    /// The part of a block along x and y.
    #[inline(always)]
    pub fn of(block: &Block) -> Self {
        Self(Vec4::new(block[0].x, block[0].y, block[1].x, block[1].y))
    }

    /// The transpose.
    #[inline(always)]
    pub fn transpose(self) -> Self {
        Self(self.0.xzyw())
    }
}

impl Coefficient for FlatBlock {
    #[inline(always)]
    fn times(&self, v: Vec4) -> Vec4 {
        let products = self.0 * v.xxyy();
        products + products.zwzw()
    }

    #[inline(always)]
    fn only_axes(sum: Vec4) -> Vec4 {
        Vec4::new(sum.x, sum.y, 0.0, 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flat_block_is_its_part_of_a_block() {
        let block = [Vec4::new(2.0, -1.0, 0.0, 0.0), Vec4::new(0.5, 3.0, 0.0, 0.0), Vec4::ZERO];
        let flat = FlatBlock::of(&block);
        // The numbers are exact in single precision.
        let v = Vec4::new(0.25, -4.0, 0.0, 0.0);
        assert_eq!(FlatBlock::only_axes(flat.times(v)), block.times(v));
        assert_eq!(FlatBlock::of(&block::transpose(&block)), flat.transpose());
    }
}

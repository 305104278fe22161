//! 2×2 blocks in single precision for a body in a plane, in a third of the memory of a [`super::block`], and the product that
//! sweeps over either kind are made of.

use super::block::{self, Block, LEAST_PIVOT};
use super::factor_block::FactorBlock;
use super::lanes::{Lanes, Singles};
use glam::{DVec2, Vec4, Vec4Swizzles};

/// Coefficient that a sweep over rows multiplies by.
pub trait Coefficient: Copy + Send + Sync {
    /// The product with a vector; entries that are not an axis of it hold anything.
    fn times(&self, v: Vec4) -> Vec4;
    /// A sum of such products, zero in entries that are not an axis.
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
    /// With these entries, column after column.
    #[inline(always)]
    pub const fn new(entries: Vec4) -> Self {
        Self(entries)
    }

    /// The 3×3 block in space, with zeros along z.
    #[inline(always)]
    pub fn in_space(self) -> Block {
        [self.0.xy().extend(0.0).extend(0.0), self.0.zw().extend(0.0).extend(0.0), Vec4::ZERO]
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

impl FactorBlock for FlatBlock {
    type Pair = [Self; 2];

    const ZERO: Self = Self(Vec4::ZERO);
    const NO_PAIR: [Self; 2] = [Self::ZERO; 2];

    #[inline(always)]
    fn of(block: &Block) -> Self {
        Self(Vec4::new(block[0].x, block[0].y, block[1].x, block[1].y))
    }

    #[inline(always)]
    fn transposed(&self) -> Self {
        Self(self.0.xzyw())
    }

    #[inline(always)]
    fn add(&mut self, b: &Self) {
        self.0 += b.0;
    }

    #[inline(always)]
    fn plus(&self, b: &Self, factor: f32) -> Self {
        Self(self.0 + b.0 * factor)
    }

    #[inline(always)]
    fn largest(&self) -> f32 {
        self.0.x.max(self.0.w)
    }

    #[inline(always)]
    fn scaled(&self, factor: f32) -> Self {
        Self(self.0 * factor)
    }

    #[inline(always)]
    fn product(&self, b: &Self) -> Self {
        Self(self.0.xyxy() * b.0.xxzz() + self.0.zwzw() * b.0.yyww())
    }

    #[inline(always)]
    fn subtract_product_transposed(&mut self, a: &Self, b: &Self) {
        self.0 -= a.0.xyxy() * b.0.xxyy() + a.0.zwzw() * b.0.zzww();
    }

    #[inline(always)]
    fn masked(&self, rows: Vec4, columns: Vec4) -> Self {
        Self(self.0 * (rows.xyxy() * columns.xxyy()))
    }

    #[inline(always)]
    fn is_positive(&self, free: Vec4) -> bool {
        let fixed = DVec2::ONE - free.xy().as_dvec2();
        let [xx, yx, _, yy] = self.0.to_array().map(f64::from);
        let (xx, yy) = (xx + fixed.x, yy + fixed.y);
        xx > 0.0 && xx * yy - yx * yx > 0.0
    }

    #[inline(always)]
    fn inverted(&self, free: Vec4) -> Option<Self> {
        let free = free.xy().as_dvec2();
        let fixed = DVec2::ONE - free;
        let [xx, yx, _, yy] = self.0.to_array().map(f64::from);
        let d1 = xx + fixed.x;
        let l = yx / d1;
        let d2 = yy + fixed.y - l * yx;
        let is_positive = d1 > 0.0 && d2 > yy * LEAST_PIVOT;
        if !(is_positive && (d1 + d2).is_finite()) {
            return None;
        }
        // L⁻ᵀ·D⁻¹·L⁻¹.
        let (e1, e2) = (1.0 / d1, 1.0 / d2);
        let x = DVec2::new(e1 + l * l * e2, -l * e2) * free * free.x;
        let y = DVec2::new(-l * e2, e2) * free * free.y;
        Some(Self(x.extend(y.x).extend(y.y).as_vec4()))
    }

    #[inline(always)]
    fn inverted_alone(&self, free: Vec4) -> Self {
        let [xx, yx, xy, yy] = self.0.to_array();
        let in_space = [Vec4::new(xx, yx, 0.0, 0.0), Vec4::new(xy, yy, 0.0, 0.0), Vec4::ZERO];
        Self::of(&block::invert_alone(&in_space, Self::only_axes(free)))
    }

    #[inline(always)]
    fn get(pairs: &[[Self; 2]], k: usize) -> Self {
        pairs[k / 2][k % 2]
    }

    #[inline(always)]
    fn set(pairs: &mut [[Self; 2]], k: usize, block: &Self) {
        pairs[k / 2][k % 2] = *block;
    }

    #[inline(always)]
    fn add_to(pairs: &mut [[Self; 2]], k: usize, block: &Self) {
        pairs[k / 2][k % 2].0 += block.0;
    }

    #[inline(always)]
    fn times_pair<L: Lanes>(lanes: L, [a, b]: &[Self; 2], u: Vec4, v: Vec4) -> Singles<L> {
        Singles::new(lanes, [a.0, b.0]) * Singles::new(lanes, [u.xxyy(), v.xxyy()])
    }

    #[inline(always)]
    fn total<L: Lanes>(sum: Singles<L>) -> Vec4 {
        let [even, odd] = sum.to_array();
        let products = even + odd;
        Self::only_axes(products + products.zwzw())
    }

    #[inline(always)]
    fn times_pair_transposed<L: Lanes>(lanes: L, [a, b]: &[Self; 2], u: Vec4) -> [Vec4; 2] {
        let products = Singles::new(lanes, [a.0, b.0]) * Singles::new(lanes, [u.xyxy(); 2]);
        products.to_array().map(|products| products.xzxz() + products.ywyw())
    }
}

#[cfg(test)]
mod tests {
    use super::super::simd::{Pass, force_portable, pass};
    use super::*;

    #[test]
    fn a_flat_block_is_its_part_of_a_block() {
        let block = [Vec4::new(2.0, -1.0, 0.0, 0.0), Vec4::new(0.5, 3.0, 0.0, 0.0), Vec4::ZERO];
        let flat = FlatBlock::of(&block);
        // The numbers are exact in single precision.
        let v = Vec4::new(0.25, -4.0, 0.0, 0.0);
        assert_eq!(FlatBlock::only_axes(flat.times(v)), block.times(v));
        assert_eq!(FlatBlock::of(&block::transpose(&block)), flat.transposed());
    }

    /// Blocks of a body in a plane, which have zeros along z, and the same ones as flat blocks: to the bit, as a zero added rounds nothing.
    #[test]
    fn a_factor_in_a_plane_is_that_in_space() {
        let number = |i: usize| (0.7 * i as f32).sin();
        let column = |i: usize| Vec4::new(number(i), number(i + 1), 0.0, 0.0);
        let general = |i: usize| [column(i), column(i + 2), Vec4::ZERO];
        let (a, b) = (general(1), general(5));
        let symmetric = |yy: f32| [Vec4::new(2.0, -0.9, 0.0, 0.0), Vec4::new(-0.9, yy, 0.0, 0.0), Vec4::ZERO];
        let flat = FlatBlock::of;
        assert_eq!(flat(&a).product(&flat(&b)), flat(&a.product(&b)));
        assert_eq!(flat(&a).plus(&flat(&b), 0.3), flat(&a.plus(&b, 0.3)));
        assert_eq!(flat(&a).scaled(1.7), flat(&a.scaled(1.7)));
        let (mut c, mut of_c) = (general(9), flat(&general(9)));
        c.subtract_product_transposed(&a, &b);
        of_c.subtract_product_transposed(&flat(&a), &flat(&b));
        assert_eq!(of_c, flat(&c));
        c.add(&a);
        of_c.add(&flat(&a));
        assert_eq!(of_c, flat(&c));
        for free in [Vec4::new(1.0, 1.0, 0.0, 0.0), Vec4::new(0.0, 1.0, 0.0, 0.0), Vec4::new(1.0, 0.0, 0.0, 0.0)] {
            assert_eq!(flat(&a).masked(free, Vec4::X), flat(&a.masked(free, Vec4::X)));
            for yy in [1.0, 0.405, 0.404, -1.0] {
                let own = symmetric(yy).masked(free, free);
                assert_eq!(flat(&own).is_positive(free), own.is_positive(free));
                assert_eq!(flat(&own).inverted(free), own.inverted(free).as_ref().map(flat));
                assert_eq!(flat(&own).inverted_alone(free), flat(&own.inverted_alone(free)));
            }
        }
        assert!(flat(&[Vec4::NAN; 3]).inverted(Vec4::ONE).is_none());
    }

    /// Products of a pair with one vector each, summed, and of its transposes with the first.
    struct Products<B: FactorBlock>(B::Pair, [Vec4; 2]);

    impl<B: FactorBlock> Pass for Products<B> {
        type Output = [Vec4; 3];

        #[inline(always)]
        fn run<L: Lanes>(self, lanes: L) -> [Vec4; 3] {
            let Self(pair, [u, v]) = self;
            let [a, b] = B::times_pair_transposed(lanes, &pair, u);
            [B::total(B::times_pair(lanes, &pair, u, v)), B::only_axes(a), B::only_axes(b)]
        }
    }

    fn products<B: FactorBlock>(a: &B, b: &B, vectors: [Vec4; 2]) -> [Vec4; 3] {
        let mut pairs = [B::NO_PAIR];
        B::set(&mut pairs, 0, a);
        B::add_to(&mut pairs, 1, b);
        assert_eq!(B::get(&pairs, 1).times(vectors[1]), b.times(vectors[1]));
        let was = force_portable(true);
        let portable = pass(Products::<B>(pairs[0], vectors));
        force_portable(false);
        let wide = pass(Products::<B>(pairs[0], vectors));
        force_portable(was);
        assert_eq!(portable, wide);
        wide
    }

    #[test]
    fn a_flat_pair_multiplies_as_its_blocks_do() {
        let column = |i: usize| Vec4::new((0.7 * i as f32).sin(), (0.9 * i as f32).cos(), 0.0, 0.0);
        let (a, b) = ([column(1), column(2), Vec4::ZERO], [column(3), column(4), Vec4::ZERO]);
        let vectors = [column(5), column(6)];
        let in_space = products(&a, &b, vectors);
        for (flat, space) in products(&FlatBlock::of(&a), &FlatBlock::of(&b), vectors).into_iter().zip(in_space) {
            // Four products below one each, added in another order.
            assert!((flat - space).abs().max_element() <= 4.0 * f32::EPSILON, "{flat} {space}");
        }
    }
}

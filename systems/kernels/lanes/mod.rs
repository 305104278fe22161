//! Numbers side by side, one lane per triangle: eight in single precision, four in double.
//!
//! Kernels are written once, over [`Lanes`]; the wide processor's are registers of 256 bits, the plain one's are halves of
//! that or plain numbers. Every operation rounds each lane by itself, so that both give the same bits.
//!
//! Code that is generic over lanes is marked `#[inline(always)]` down to the last function and calls no closure. A function that is not
//! inlined into the wide one cannot take the wide instructions in, and calls each of them instead.

#[cfg(target_arch = "x86_64")]
mod wide;

use crate::math::number::{Number, Real};
use glam::{Mat4, Vec4, Vec4Swizzles};
use std::ops::{Add, Div, Mul, Sub};

/// Lanes in single precision.
pub const SINGLES: usize = 8;

/// Lanes in double precision.
pub const DOUBLES: usize = 4;

/// An instruction set.
pub trait Lanes: Copy {
    /// Eight numbers in single precision.
    type Singles: Copy;
    /// Four numbers in double precision.
    type Doubles: Copy;

    /// Whether four numbers in double precision take one instruction: else to bring them side by side is work for nothing.
    const HAS_DOUBLES: bool;

    /// Takes eight numbers.
    fn singles(self, x: [Vec4; 2]) -> Self::Singles;
    /// Gives eight numbers.
    fn single_array(self, x: Self::Singles) -> [Vec4; 2];
    /// a + b.
    fn add_singles(self, a: Self::Singles, b: Self::Singles) -> Self::Singles;
    /// a − b.
    fn sub_singles(self, a: Self::Singles, b: Self::Singles) -> Self::Singles;
    /// a·b.
    fn mul_singles(self, a: Self::Singles, b: Self::Singles) -> Self::Singles;
    /// The first three components of eight vectors.
    fn components(self, rows: [Vec4; 8]) -> [Self::Singles; 3];
    /// The eight vectors with these components and a last one of zero.
    fn rows(self, components: [Self::Singles; 3]) -> [Vec4; 8];
    /// The first, second and third number of either half, all over it.
    fn spread(self, x: Self::Singles) -> [Self::Singles; 3];
    /// The sums of either half of three, side by side, and a zero.
    fn sums(self, x: [Self::Singles; 3]) -> Self::Singles;

    /// Takes four numbers.
    fn doubles(self, x: [f64; 4]) -> Self::Doubles;
    /// Takes four numbers in single precision.
    fn widened(self, x: Vec4) -> Self::Doubles;
    /// Gives four numbers.
    fn double_array(self, x: Self::Doubles) -> [f64; 4];
    /// a + b.
    fn add_doubles(self, a: Self::Doubles, b: Self::Doubles) -> Self::Doubles;
    /// a − b.
    fn sub_doubles(self, a: Self::Doubles, b: Self::Doubles) -> Self::Doubles;
    /// a·b.
    fn mul_doubles(self, a: Self::Doubles, b: Self::Doubles) -> Self::Doubles;
    /// a/b.
    fn div_doubles(self, a: Self::Doubles, b: Self::Doubles) -> Self::Doubles;
    /// √a.
    fn sqrt_doubles(self, a: Self::Doubles) -> Self::Doubles;
    /// a where it is larger, else b.
    fn max_doubles(self, a: Self::Doubles, b: Self::Doubles) -> Self::Doubles;
    /// Whether a is larger than b in every lane.
    fn are_larger(self, a: Self::Doubles, b: Self::Doubles) -> bool;
    /// The columns of four rows.
    fn transpose_doubles(self, rows: [Self::Doubles; 4]) -> [Self::Doubles; 4];
}

/// Instructions that every processor has.
#[derive(Clone, Copy, Debug)]
pub struct Portable;

#[inline(always)]
fn columns(a: Vec4, b: Vec4, c: Vec4, d: Vec4) -> [Vec4; 4] {
    let t = Mat4::from_cols(a, b, c, d).transpose();
    [t.x_axis, t.y_axis, t.z_axis, t.w_axis]
}

impl Lanes for Portable {
    type Singles = [Vec4; 2];
    type Doubles = [f64; 4];

    const HAS_DOUBLES: bool = false;

    #[inline(always)]
    fn singles(self, x: [Vec4; 2]) -> [Vec4; 2] {
        x
    }
    #[inline(always)]
    fn single_array(self, x: [Vec4; 2]) -> [Vec4; 2] {
        x
    }
    #[inline(always)]
    fn add_singles(self, a: [Vec4; 2], b: [Vec4; 2]) -> [Vec4; 2] {
        [a[0] + b[0], a[1] + b[1]]
    }
    #[inline(always)]
    fn sub_singles(self, a: [Vec4; 2], b: [Vec4; 2]) -> [Vec4; 2] {
        [a[0] - b[0], a[1] - b[1]]
    }
    #[inline(always)]
    fn mul_singles(self, a: [Vec4; 2], b: [Vec4; 2]) -> [Vec4; 2] {
        [a[0] * b[0], a[1] * b[1]]
    }
    #[inline(always)]
    fn components(self, rows: [Vec4; 8]) -> [[Vec4; 2]; 3] {
        let [x, y, z, _] = columns(rows[0], rows[1], rows[2], rows[3]);
        let [x_high, y_high, z_high, _] = columns(rows[4], rows[5], rows[6], rows[7]);
        [[x, x_high], [y, y_high], [z, z_high]]
    }
    #[inline(always)]
    fn rows(self, [x, y, z]: [[Vec4; 2]; 3]) -> [Vec4; 8] {
        let [a, b, c, d] = columns(x[0], y[0], z[0], Vec4::ZERO);
        let [e, f, g, h] = columns(x[1], y[1], z[1], Vec4::ZERO);
        [a, b, c, d, e, f, g, h]
    }
    #[inline(always)]
    fn spread(self, [low, high]: [Vec4; 2]) -> [[Vec4; 2]; 3] {
        [[low.xxxx(), high.xxxx()], [low.yyyy(), high.yyyy()], [low.zzzz(), high.zzzz()]]
    }
    #[inline(always)]
    fn sums(self, [a, b, c]: [[Vec4; 2]; 3]) -> [Vec4; 2] {
        let [x, y, z, w] = columns(a[0], b[0], c[0], Vec4::ZERO);
        let [x_high, y_high, z_high, w_high] = columns(a[1], b[1], c[1], Vec4::ZERO);
        [(x + z) + (y + w), (x_high + z_high) + (y_high + w_high)]
    }

    #[inline(always)]
    fn doubles(self, x: [f64; 4]) -> [f64; 4] {
        x
    }
    #[inline(always)]
    fn widened(self, x: Vec4) -> [f64; 4] {
        x.to_array().map(f64::from)
    }
    #[inline(always)]
    fn double_array(self, x: [f64; 4]) -> [f64; 4] {
        x
    }
    #[inline(always)]
    fn add_doubles(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        [a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]]
    }
    #[inline(always)]
    fn sub_doubles(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        [a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3]]
    }
    #[inline(always)]
    fn mul_doubles(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        [a[0] * b[0], a[1] * b[1], a[2] * b[2], a[3] * b[3]]
    }
    #[inline(always)]
    fn div_doubles(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        [a[0] / b[0], a[1] / b[1], a[2] / b[2], a[3] / b[3]]
    }
    #[inline(always)]
    fn sqrt_doubles(self, a: [f64; 4]) -> [f64; 4] {
        [a[0].sqrt(), a[1].sqrt(), a[2].sqrt(), a[3].sqrt()]
    }
    #[inline(always)]
    fn max_doubles(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        let mut larger = b;
        for (larger, a) in larger.iter_mut().zip(a) {
            *larger = if a > *larger { a } else { *larger };
        }
        larger
    }
    #[inline(always)]
    fn are_larger(self, a: [f64; 4], b: [f64; 4]) -> bool {
        (a[0] > b[0]) & (a[1] > b[1]) & (a[2] > b[2]) & (a[3] > b[3])
    }
    #[inline(always)]
    fn transpose_doubles(self, [a, b, c, d]: [[f64; 4]; 4]) -> [[f64; 4]; 4] {
        [[a[0], b[0], c[0], d[0]], [a[1], b[1], c[1], d[1]], [a[2], b[2], c[2], d[2]], [a[3], b[3], c[3], d[3]]]
    }
}

/// Eight numbers in single precision, with their arithmetic.
#[derive(Clone, Copy)]
pub struct Singles<L: Lanes>(pub L, pub L::Singles);

/// Four numbers in double precision, with their arithmetic.
#[derive(Clone, Copy)]
pub struct Doubles<L: Lanes>(pub L, pub L::Doubles);

macro_rules! operator {
    ($numbers:ident, $operator:ident, $method:ident, $of_lanes:ident) => {
        impl<L: Lanes> $operator for $numbers<L> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0, self.0.$of_lanes(self.1, other.1))
            }
        }
    };
}

operator!(Singles, Add, add, add_singles);
operator!(Singles, Sub, sub, sub_singles);
operator!(Singles, Mul, mul, mul_singles);
operator!(Doubles, Add, add, add_doubles);
operator!(Doubles, Sub, sub, sub_doubles);
operator!(Doubles, Mul, mul, mul_doubles);
operator!(Doubles, Div, div, div_doubles);

impl<L: Lanes> Singles<L> {
    /// Takes eight numbers.
    #[inline(always)]
    pub fn new(lanes: L, x: [Vec4; 2]) -> Self {
        Self(lanes, lanes.singles(x))
    }

    /// One number in every lane.
    #[inline(always)]
    pub fn splat(lanes: L, x: f32) -> Self {
        Self::new(lanes, [Vec4::splat(x); 2])
    }

    /// Gives eight numbers.
    #[inline(always)]
    pub fn to_array(self) -> [Vec4; 2] {
        self.0.single_array(self.1)
    }

    /// The first, second and third number of either half, all over it.
    #[inline(always)]
    pub fn spread(self) -> [Self; 3] {
        let [x, y, z] = self.0.spread(self.1);
        [Self(self.0, x), Self(self.0, y), Self(self.0, z)]
    }

    /// The sums of either half of three, side by side, and a zero.
    #[inline(always)]
    pub fn sums([a, b, c]: [Self; 3]) -> Self {
        Self(a.0, a.0.sums([a.1, b.1, c.1]))
    }

    /// The first three components of eight vectors.
    #[inline(always)]
    pub fn components(lanes: L, rows: [Vec4; 8]) -> [Self; 3] {
        let [x, y, z] = lanes.components(rows);
        [Self(lanes, x), Self(lanes, y), Self(lanes, z)]
    }

    /// The eight vectors with these components and a last one of zero.
    #[inline(always)]
    pub fn rows([x, y, z]: [Self; 3]) -> [Vec4; 8] {
        x.0.rows([x.1, y.1, z.1])
    }
}

impl<L: Lanes> Doubles<L> {
    /// Takes four numbers.
    #[inline(always)]
    pub fn new(lanes: L, x: [f64; 4]) -> Self {
        Self(lanes, lanes.doubles(x))
    }

    /// Takes four numbers in single precision.
    #[inline(always)]
    pub fn widened(lanes: L, x: Vec4) -> Self {
        Self(lanes, lanes.widened(x))
    }

    /// One number in every lane.
    #[inline(always)]
    pub fn splat(lanes: L, x: f64) -> Self {
        Self::new(lanes, [x; 4])
    }

    /// Gives four numbers.
    #[inline(always)]
    pub fn to_array(self) -> [f64; 4] {
        self.0.double_array(self.1)
    }

    /// The columns of four rows; the rows, of four columns.
    #[inline(always)]
    pub fn transpose([a, b, c, d]: [Self; 4]) -> [Self; 4] {
        let lanes = a.0;
        let [x, y, z, w] = lanes.transpose_doubles([a.1, b.1, c.1, d.1]);
        [Self(lanes, x), Self(lanes, y), Self(lanes, z), Self(lanes, w)]
    }

    /// Whether it is larger in every lane.
    #[inline(always)]
    pub fn is_larger(self, other: Self) -> bool {
        self.0.are_larger(self.1, other.1)
    }
}

impl<L: Lanes> Number for Singles<L> {
    #[inline(always)]
    fn constant(self, x: f64) -> Self {
        Self::splat(self.0, x as f32)
    }
}

impl<L: Lanes> Number for Doubles<L> {
    #[inline(always)]
    fn constant(self, x: f64) -> Self {
        Self::splat(self.0, x)
    }
}

impl<L: Lanes> Real for Doubles<L> {
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0, self.0.sqrt_doubles(self.1))
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(self.0, self.0.max_doubles(self.1, other.1))
    }
}

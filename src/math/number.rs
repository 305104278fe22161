//! Numbers that a formula may be written over: one, or several side by side.

use std::ops::{Add, Div, Mul, Sub};

/// A number, or several side by side, one for each of several triangles.
///
/// A formula over it gives the same bits for a triangle alone as for one among others. It is marked `#[inline(always)]` and calls no closure:
/// code that is not inlined cannot take wide instructions.
pub trait Number: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {
    /// A constant of the same kind.
    fn constant(self, x: f64) -> Self;
}

/// A number of double precision, which can be divided.
pub trait Real: Number + Div<Output = Self> {
    /// The square root.
    fn sqrt(self) -> Self;

    /// The larger of two numbers; `other` where one of them is not a number.
    fn max(self, other: Self) -> Self;
}

impl Number for f64 {
    #[inline(always)]
    fn constant(self, x: f64) -> Self {
        x
    }
}

impl Real for f64 {
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
}

/// Stress xx, yy, xy of a strain by the law Q11, Q12, Q22, Q66.
#[inline(always)]
pub fn linear_stress<N: Number>([q11, q12, q22, q66]: [N; 4], [xx, yy, xy]: [N; 3]) -> [N; 3] {
    [q11 * xx + q12 * yy, q12 * xx + q22 * yy, (q66 + q66) * xy]
}

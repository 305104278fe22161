//! Symmetric 2×2 tensors: stress and strain in a triangle's own frame.

use super::elementary;
use glam::DVec2;
use std::ops::{Add, AddAssign, Mul, Neg, Sub};

/// A symmetric 2×2 tensor with *tensor* components: `xy` is the shear strain ε_xy, not the engineering shear γ = 2ε_xy.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Sym2 {
    /// Component along the first axis.
    pub xx: f64,
    /// Component along the second axis.
    pub yy: f64,
    /// Off-diagonal component.
    pub xy: f64,
}

impl Sym2 {
    /// The zero tensor.
    pub const ZERO: Self = Self::new(0.0, 0.0, 0.0);
    /// The identity.
    pub const IDENTITY: Self = Self::new(1.0, 1.0, 0.0);

    /// A tensor from its three components.
    pub const fn new(xx: f64, yy: f64, xy: f64) -> Self {
        Self { xx, yy, xy }
    }

    /// With the components xx, yy and xy.
    #[inline(always)]
    pub(crate) fn from_array([xx, yy, xy]: [f64; 3]) -> Self {
        Self::new(xx, yy, xy)
    }

    /// xx, yy and xy.
    #[inline(always)]
    pub(crate) fn to_array(self) -> [f64; 3] {
        [self.xx, self.yy, self.xy]
    }

    /// The dyad v ⊗ v.
    pub fn outer(v: DVec2) -> Self {
        Self::new(v.x * v.x, v.y * v.y, v.x * v.y)
    }

    /// Sum of the diagonal.
    pub fn trace(self) -> f64 {
        self.xx + self.yy
    }

    /// Determinant.
    pub fn determinant(self) -> f64 {
        self.xx * self.yy - self.xy * self.xy
    }

    /// The product with a vector.
    pub fn apply(self, v: DVec2) -> DVec2 {
        DVec2::new(self.xx * v.x + self.xy * v.y, self.xy * v.x + self.yy * v.y)
    }

    /// The quadratic form u·A·u; for a stress and a unit `u` the normal stress across a line with normal `u`.
    pub fn normal_component(self, u: DVec2) -> f64 {
        u.dot(self.apply(u))
    }

    /// The double contraction A : B.
    pub fn contract(self, other: Self) -> f64 {
        self.xx * other.xx + self.yy * other.yy + 2.0 * self.xy * other.xy
    }

    /// The components of the same tensor in axes turned by `angle` \[rad\] counter-clockwise.
    pub fn in_axes_turned_by(self, angle: f64) -> Self {
        let (s, c) = elementary::sin_cos(angle);
        self.in_axes(DVec2::new(c, s), DVec2::new(-s, c))
    }

    /// The components of the same tensor in the orthonormal axes `e1`, `e2`, given in the present axes.
    pub fn in_axes(self, e1: DVec2, e2: DVec2) -> Self {
        Self::new(self.normal_component(e1), self.normal_component(e2), e1.dot(self.apply(e2)))
    }

    /// The principal values, larger first.
    pub fn principal_values(self) -> (f64, f64) {
        let (mean, half) = (0.5 * (self.xx + self.yy), 0.5 * (self.xx - self.yy));
        let radius = (half * half + self.xy * self.xy).sqrt();
        (mean + radius, mean - radius)
    }

    /// Angle \[rad\] of the axis of the larger principal value, in (−π/2, π/2].
    pub fn principal_angle(self) -> f64 {
        0.5 * elementary::atan2(2.0 * self.xy, self.xx - self.yy)
    }

    /// The positive part: negative principal values replaced by zero.
    pub fn positive_part(self) -> Self {
        let (high, low) = self.principal_values();
        if low >= 0.0 {
            return self;
        }
        if high <= 0.0 {
            return Self::ZERO;
        }
        // A⁺ = high · (A − low·I)/(high − low): the projector on the axis of `high`, without computing that axis.
        let scale = high / (high - low);
        Self::new((self.xx - low) * scale, (self.yy - low) * scale, self.xy * scale)
    }

    /// Whether every component is finite.
    pub fn is_finite(self) -> bool {
        self.xx.is_finite() && self.yy.is_finite() && self.xy.is_finite()
    }
}

impl Add for Sym2 {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self::new(self.xx + o.xx, self.yy + o.yy, self.xy + o.xy)
    }
}

impl AddAssign for Sym2 {
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl Sub for Sym2 {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Self::new(self.xx - o.xx, self.yy - o.yy, self.xy - o.xy)
    }
}

impl Neg for Sym2 {
    type Output = Self;
    fn neg(self) -> Self {
        self * -1.0
    }
}

impl Mul<f64> for Sym2 {
    type Output = Self;
    fn mul(self, k: f64) -> Self {
        Self::new(self.xx * k, self.yy * k, self.xy * k)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positive_part_keeps_the_positive_eigenpair_only() {
        let a = Sym2::new(1.0, -2.0, 0.7);
        let (high, _) = a.principal_values();
        let p = a.positive_part();
        let (p_high, p_low) = p.principal_values();
        // Rounding only: three products and one division.
        assert!((p_high - high).abs() < 1e-14 && p_low.abs() < 1e-14);
        assert!((p.principal_angle() - a.principal_angle()).abs() < 1e-14);
    }

    #[test]
    fn turning_axes_keeps_invariants_and_the_principal_angle() {
        let a = Sym2::new(2.0, 0.5, -0.3);
        let b = a.in_axes_turned_by(0.4);
        assert!((a.trace() - b.trace()).abs() < 1e-15 && (a.determinant() - b.determinant()).abs() < 1e-14);
        assert!((a.principal_angle() - 0.4 - b.principal_angle()).abs() < 1e-14);
    }
}

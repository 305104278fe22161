//! Symmetric 3×3 matrices: resistance of a point, by directions.

use glam::{DMat3, DVec3};
use std::ops::{Add, AddAssign, Mul, Sub};

/// A symmetric 3×3 matrix by its six numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Sym3 {
    /// xx, yy, zz.
    pub diagonal: DVec3,
    /// yz, zx, xy.
    pub beside: DVec3,
}

impl Sym3 {
    /// The zero matrix.
    pub const ZERO: Self = Self { diagonal: DVec3::ZERO, beside: DVec3::ZERO };
    /// The identity.
    pub const IDENTITY: Self = Self { diagonal: DVec3::ONE, beside: DVec3::ZERO };

    /// Isotropic matrix: one value in all directions.
    pub fn isotropic(value: f64) -> Self {
        Self { diagonal: DVec3::splat(value), beside: DVec3::ZERO }
    }

    /// The dyad v ⊗ v.
    pub fn outer(v: DVec3) -> Self {
        Self { diagonal: v * v, beside: DVec3::new(v.y * v.z, v.z * v.x, v.x * v.y) }
    }

    /// All nine numbers.
    pub(crate) fn to_mat(self) -> DMat3 {
        let Self { diagonal: d, beside: o } = self;
        DMat3::from_cols(DVec3::new(d.x, o.z, o.y), DVec3::new(o.z, d.y, o.x), DVec3::new(o.y, o.x, d.z))
    }
}

impl Add for Sym3 {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { diagonal: self.diagonal + other.diagonal, beside: self.beside + other.beside }
    }
}

impl AddAssign for Sym3 {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sub for Sym3 {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self { diagonal: self.diagonal - other.diagonal, beside: self.beside - other.beside }
    }
}

impl Mul<f64> for Sym3 {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self { diagonal: self.diagonal * factor, beside: self.beside * factor }
    }
}

impl Mul<DVec3> for Sym3 {
    type Output = DVec3;

    fn mul(self, v: DVec3) -> DVec3 {
        self.to_mat() * v
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Six numbers give the results of all nine: the same products and sums, so the same bits.
    #[test]
    fn six_numbers_stand_for_nine() {
        let (n, u) = (DVec3::new(0.3, -1.7, 2.9), DVec3::new(-0.1, 5.3, 0.7));
        let nine = DMat3::from_cols(n * n.x, n * n.y, n * n.z);
        assert_eq!(Sym3::outer(n).to_mat(), nine);
        assert_eq!((Sym3::IDENTITY - Sym3::outer(n) * 0.3).to_mat(), DMat3::IDENTITY - nine * 0.3);
        assert_eq!((Sym3::isotropic(2.1) + Sym3::outer(n)).to_mat(), DMat3::from_diagonal(DVec3::splat(2.1)) + nine);
        assert_eq!(Sym3::outer(n) * u, nine * u);
    }
}

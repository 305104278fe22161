//! The state of one membrane triangle: rotation, stretch and stress.

use super::Sym2;
use glam::{DVec2, DVec3};

/// The rotation's two columns (images of the fibre axis and the transverse axis) and the right stretch, F = R·U.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Polar {
    /// First column of R: the fibre axis in space.
    pub fibre_axis: DVec3,
    /// Second column of R.
    pub transverse_axis: DVec3,
    /// U, symmetric, in the rest frame.
    pub stretch: Sym2,
}

/// The state of one triangle at given positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElementState {
    /// Rotation and stretch.
    pub polar: Polar,
    /// Biot stress T \[MPa\] in the frame (fibre, transverse).
    pub stress: Sym2,
}

impl ElementState {
    /// Placeholder before the first evaluation: unrotated, unstretched, free of stress.
    pub const REST: Self = Self {
        polar: Polar { fibre_axis: DVec3::X, transverse_axis: DVec3::Y, stretch: Sym2::IDENTITY },
        stress: Sym2::ZERO,
    };
}

/// The state of one triangle of a planar body, whose axes have no part along z: two thirds of the memory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlatState {
    /// Fibre axis; the transverse axis is a quarter turn on.
    pub fibre_axis: DVec2,
    /// As of any triangle.
    pub stretch: Sym2,
    /// As of any triangle.
    pub stress: Sym2,
}

impl From<FlatState> for ElementState {
    #[inline(always)]
    fn from(FlatState { fibre_axis, stretch, stress }: FlatState) -> Self {
        let transverse_axis = fibre_axis.perp().extend(0.0);
        Self { polar: Polar { fibre_axis: fibre_axis.extend(0.0), transverse_axis, stretch }, stress }
    }
}

impl From<ElementState> for FlatState {
    #[inline(always)]
    fn from(ElementState { polar: Polar { fibre_axis, stretch, .. }, stress }: ElementState) -> Self {
        Self { fibre_axis: fibre_axis.truncate(), stretch, stress }
    }
}

/// Geometric stiffness: contribution of the stress in a triangle to its tangent.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GeometricStiffness {
    /// Out-of-plane stiffness \[MPa\]: second Piola–Kirchhoff stress, its tensile part but for the exact tangent.
    pub normal: Sym2,
    /// In-plane stiffness \[MPa\] that stands for the geometric one in the rotated tangent, or keeps the projected one from being
    /// negative; zero for the exact one.
    pub in_plane: f64,
}

//! Small dense mathematics that everything else stands on: symmetric 2×2 and 3×3 tensors, rest triangles, the orthotropic matrix,
//! the field at a crack's tip.
//!
//! Nothing here allocates, panics or knows of meshes. Units are the caller's: the engine uses mm, g, ms, N, MPa.

pub(crate) mod compartment;
mod element;
pub mod elementary;
mod faded;
mod fibre_law;
mod fracture;
pub(crate) mod holzapfel_gasser_ogden;
mod nearest;
#[doc(hidden)]
pub mod number;
mod orthotropic;
mod per_row;
pub(crate) mod relaxation;
pub(crate) mod stiffening_fibres;
mod sym2;
mod sym3;
mod triangle;

/// Maximum size of a coordinate \[mm\] or strain that is given: its fourth power is a number.
pub(crate) const MAX_COORDINATE: f64 = 1e75;

/// Edge of the equilateral triangle of an area.
#[doc(hidden)]
pub fn edge_of_equilateral(area: f64) -> f64 {
    (area * 4.0 / 3.0_f64.sqrt()).sqrt()
}

/// Whether no part of a vector is above [`MAX_COORDINATE`] in size.
pub(crate) fn is_place(v: glam::DVec3) -> bool {
    v.to_array().iter().all(|part| part.abs() <= MAX_COORDINATE)
}

/// Whether a vector has a direction: it is neither too short nor too long for squares.
pub(crate) fn is_direction(v: glam::DVec3) -> bool {
    (1.0 / MAX_COORDINATE..=MAX_COORDINATE).contains(&v.length())
}

#[doc(hidden)]
pub use element::{ElementState, FlatState, GeometricStiffness, Polar};
#[doc(hidden)]
pub use faded::{FADES_FROM, Faded};
#[doc(hidden)]
pub use fibre_law::{CoupledStiffness, FibreLaw};
#[doc(hidden)]
pub use fracture::{CrackTip, Modes, Slopes};
#[doc(hidden)]
pub use holzapfel_gasser_ogden::{FibreFamily, GroundSubstance, HolzapfelGasserOgden, PreparedLaw};
#[doc(hidden)]
pub use nearest::nearest_in_triangle;
pub use orthotropic::{InadmissibleMaterial, Orthotropic};
#[doc(hidden)]
pub use per_row::PerRow;
#[doc(hidden)]
pub use relaxation::{Branch, Decay, FreeShape, stored_beside, tangent};
#[doc(hidden)]
pub use stiffening_fibres::{FibreResponse, StiffeningFibres};
pub use sym2::Sym2;
pub use sym3::Sym3;
#[doc(hidden)]
pub use triangle::{RestTriangle, SmallestAngle, smallest_angle};

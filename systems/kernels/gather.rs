//! What triangles have side by side in memory, taken row by row: four rows, transposed, are lanes.
//!
//! A row is one load, where its numbers one by one are four and as many moves into lanes.

use super::lanes::{DOUBLES, Doubles, Lanes};
use crate::math::{ElementState, Orthotropic, RestTriangle};
use glam::DVec3;

/// A vector as a row, with a zero at its end.
#[inline(always)]
pub fn row<L: Lanes>(lanes: L, x: DVec3) -> Doubles<L> {
    Doubles::new(lanes, [x.x, x.y, x.z, 0.0])
}

/// The components of four vectors.
#[inline(always)]
pub fn components<L: Lanes>(rows: [Doubles<L>; DOUBLES]) -> [Doubles<L>; 3] {
    let [x, y, z, _] = Doubles::transpose(rows);
    [x, y, z]
}

/// The shape gradients of a triangle as a row.
#[inline(always)]
pub fn gradients_of<L: Lanes>(lanes: L, RestTriangle { gradients: [g1, g2], .. }: &RestTriangle) -> Doubles<L> {
    Doubles::new(lanes, [g1.x, g1.y, g2.x, g2.y])
}

/// The elastic constants of a triangle as a row.
#[inline(always)]
pub fn law_of<L: Lanes>(lanes: L, law: &Orthotropic) -> Doubles<L> {
    Doubles::new(lanes, [law.q11, law.q12, law.q22, law.q66])
}

/// The state of a triangle as three rows: axes, stretch, stress.
#[inline(always)]
pub fn rows_of<L: Lanes>(lanes: L, ElementState { polar, stress: s }: &ElementState) -> [Doubles<L>; 3] {
    let (r1, r2, u) = (polar.fibre_axis, polar.transverse_axis, polar.stretch);
    [
        Doubles::new(lanes, [r1.x, r1.y, r1.z, r2.x]),
        Doubles::new(lanes, [r2.y, r2.z, u.xx, u.yy]),
        Doubles::new(lanes, [u.xy, s.xx, s.yy, s.xy]),
    ]
}

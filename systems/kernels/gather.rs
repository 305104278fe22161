//! Data of triangles that stands side by side in memory, taken row by row: four rows, transposed, are lanes.
//!
//! A row is one load, where its numbers one by one are four and as many moves into lanes.

use super::lanes::{DOUBLES, Doubles, Lanes};
use crate::math::{ElementState, FlatState, Orthotropic, RestTriangle, Sym2};
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

/// Vectors at the corners of the four triangles from `first` on: a lane without a triangle has those of the last.
#[inline(always)]
pub fn at_corners<L: Lanes>(
    lanes: L,
    (corners, first): (&[[u32; 3]], usize),
    x: &impl Fn(usize) -> DVec3,
) -> [[Doubles<L>; 3]; 3] {
    let mut rows = [[row(lanes, DVec3::ZERO); DOUBLES]; 3];
    for lane in 0..DOUBLES {
        let corners = &corners[(first + lane).min(corners.len() - 1)];
        for corner in 0..3 {
            rows[corner][lane] = row(lanes, x(corners[corner] as usize));
        }
    }
    // Not by `map`, which is not inlined.
    [components(rows[0]), components(rows[1]), components(rows[2])]
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

/// The states of four triangles.
pub struct StateLanes<L: Lanes> {
    /// Fibre and transverse axis.
    pub axes: [[Doubles<L>; 3]; 2],
    /// xx, yy and xy of the stretch.
    pub stretch: [Doubles<L>; 3],
    /// xx, yy and xy of the stress.
    pub stress: [Doubles<L>; 3],
}

/// Storage format of states of triangles.
pub trait Stored: Copy + Send + Sync + From<ElementState> + Into<ElementState> {
    /// Stretch and stress.
    fn tensors(&self) -> [Sym2; 2];

    /// States of four triangles, by lanes.
    fn lanes<L: Lanes>(lanes: L, states: [&Self; DOUBLES]) -> StateLanes<L>;
}

impl Stored for ElementState {
    #[inline(always)]
    fn tensors(&self) -> [Sym2; 2] {
        [self.polar.stretch, self.stress]
    }

    #[inline(always)]
    fn lanes<L: Lanes>(lanes: L, states: [&Self; DOUBLES]) -> StateLanes<L> {
        let mut rows = [[Doubles::splat(lanes, 0.0); DOUBLES]; 3];
        for lane in 0..DOUBLES {
            let Self { polar, stress: s } = states[lane];
            let (r1, r2, u) = (polar.fibre_axis, polar.transverse_axis, polar.stretch);
            rows[0][lane] = Doubles::new(lanes, [r1.x, r1.y, r1.z, r2.x]);
            rows[1][lane] = Doubles::new(lanes, [r2.y, r2.z, u.xx, u.yy]);
            rows[2][lane] = Doubles::new(lanes, [u.xy, s.xx, s.yy, s.xy]);
        }
        let ([ax, ay, az, bx], [by, bz, uxx, uyy]) = (Doubles::transpose(rows[0]), Doubles::transpose(rows[1]));
        let [uxy, txx, tyy, txy] = Doubles::transpose(rows[2]);
        StateLanes { axes: [[ax, ay, az], [bx, by, bz]], stretch: [uxx, uyy, uxy], stress: [txx, tyy, txy] }
    }
}

impl Stored for FlatState {
    #[inline(always)]
    fn tensors(&self) -> [Sym2; 2] {
        [self.stretch, self.stress]
    }

    #[inline(always)]
    fn lanes<L: Lanes>(lanes: L, states: [&Self; DOUBLES]) -> StateLanes<L> {
        let zero = Doubles::splat(lanes, 0.0);
        let mut rows = [[zero; DOUBLES]; 2];
        for lane in 0..DOUBLES {
            let Self { fibre_axis: a, stretch: u, stress: s } = states[lane];
            rows[0][lane] = Doubles::new(lanes, [a.x, a.y, u.xx, u.yy]);
            rows[1][lane] = Doubles::new(lanes, [u.xy, s.xx, s.yy, s.xy]);
        }
        let ([x, y, uxx, uyy], [uxy, txx, tyy, txy]) = (Doubles::transpose(rows[0]), Doubles::transpose(rows[1]));
        StateLanes { axes: [[x, y, zero], [zero - y, x, zero]], stretch: [uxx, uyy, uxy], stress: [txx, tyy, txy] }
    }
}

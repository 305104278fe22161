//! The membrane element for four triangles side by side: [`super::formulas`], lane by lane.
//!
//! A step spends most of its time outside the linear solve here. A case that a lane cannot do in the same way (a collapsed or mirrored
//! triangle) is done by the functions for one triangle, against which these are tested.

use super::formulas::{
    self, Rotated, Vector, dot, first_piola, gradient, in_space, inverse_trace, least_area, lengths_sq, less, radius,
    rotated_in_plane, rotated_in_space, second_piola, shear_majorant, spread,
};
use super::gather::{StateLanes, Stored, components, gradients_of, law_of, row};
use super::lanes::{DOUBLES, Doubles, Lanes};
use super::membrane::{self, ROUNDING_SQ};
use super::simd::Kernel;
use crate::math::number::{Real, linear_stress};
use crate::math::{
    ElementState, FADES_FROM, Faded, FlatState, GeometricStiffness, Orthotropic, PerRow, Polar, RestTriangle, Sym2,
};
use glam::DVec3;
use std::sync::atomic::{AtomicBool, Ordering};

/// Vectors of four triangles.
pub type Vectors<L> = Vector<Doubles<L>>;

/// Numbers of four triangles.
pub type F64x4 = [f64; DOUBLES];

/// Numbers of four triangles, lane by lane.
#[inline(always)]
pub fn doubles<L: Lanes, const N: usize>(lanes: L, x: &[F64x4; N]) -> [Doubles<L>; N] {
    let mut values = [Doubles::splat(lanes, 0.0); N];
    for i in 0..N {
        values[i] = Doubles::new(lanes, x[i]);
    }
    values
}

/// The numbers of each of four triangles.
#[inline(always)]
pub fn arrays<L: Lanes, const N: usize>(x: [Doubles<L>; N]) -> [F64x4; N] {
    let mut values = [[0.0; DOUBLES]; N];
    for i in 0..N {
        values[i] = x[i].to_array();
    }
    values
}

/// Polar decompositions of four deformation gradients.
pub struct RotatedX4<L: Lanes> {
    /// Rotations and stretches.
    pub rotated: Rotated<Doubles<L>>,
    /// Where it is not larger than `least` the triangle is one for the functions for one triangle.
    pub sound: Doubles<L>,
    /// Threshold that `sound` is to be larger than.
    pub least: Doubles<L>,
}

/// See [`super::polar`].
#[inline(always)]
pub fn rotated<L: Lanes>(lanes: L, f: [Vectors<L>; 2], is_planar: bool) -> RotatedX4<L> {
    if is_planar {
        let (rotated, sound) = rotated_in_plane(f);
        // Next to a mirror image the law fades, long before the rotation is but rounding.
        let faded = Doubles::splat(lanes, FADES_FROM * FADES_FROM);
        return RotatedX4 { rotated, sound, least: faded.max(lengths_sq(f) * Doubles::splat(lanes, 1e-28)) };
    }
    let (rotated, sound) = rotated_in_space(f);
    RotatedX4 { rotated, sound, least: least_area(f) }
}

/// Rotation, stretch and stress of every triangle at `position`; see [`membrane::state`].
pub struct States<'a> {
    /// Vertices of the triangles.
    pub corners: &'a [[u32; 3]],
    /// Positions \[mm\].
    pub position: &'a [DVec3],
    /// Rest shapes.
    pub rest: &'a [RestTriangle],
    /// Elastic constants.
    pub stiffness: PerRow<'a, Orthotropic>,
    /// Whether the normal stays +z.
    pub is_planar: bool,
    /// The stretch that is free of stress, of the body.
    pub unstretched: Sym2,
    /// Pre-stretch beside it.
    pub pre_stretch: PerRow<'a, Sym2>,
    /// Becomes true where there is a triangle whose law has [`Faded`].
    pub has_faded: AtomicBool,
}

impl States<'_> {
    #[inline(always)]
    fn free(&self, t: usize) -> Sym2 {
        self.unstretched - self.pre_stretch[t]
    }

    fn alone(&self, t: usize) -> ElementState {
        let x = self.corners[t].map(|v| self.position[v as usize]);
        membrane::state(x, &self.rest[t], &self.stiffness[t], self.is_planar, self.free(t))
    }

    /// Does over the cases that a lane cannot do in the same way: triangles that are not sound, and strains that are but rounding.
    #[inline(never)]
    fn mend<T: Stored>(&self, first: usize, out: &mut [T], (sound, least): (F64x4, F64x4), strain_sq: F64x4) {
        for (lane, out) in out.iter_mut().enumerate() {
            if !(sound[lane] > least[lane]) {
                let state = self.alone(first + lane);
                if Faded::at(state.polar.stretch, self.is_planar).is_some() {
                    self.has_faded.store(true, Ordering::Relaxed);
                }
                *out = state.into();
            } else if strain_sq[lane] <= ROUNDING_SQ {
                let mut state: ElementState = (*out).into();
                (state.polar.stretch, state.stress) = (self.free(first + lane), Sym2::ZERO);
                *out = state.into();
            }
        }
    }
}

impl<T: Stored> Kernel<T> for States<'_> {
    #[inline(always)]
    fn run<L: Lanes>(&self, lanes: L, first: usize, rows: &mut [T]) {
        let (zero, rounding_sq) = (Doubles::splat(lanes, 0.0), Doubles::splat(lanes, ROUNDING_SQ));
        for (group, out) in rows.chunks_mut(DOUBLES).enumerate() {
            let first = first + group * DOUBLES;
            let (mut edges, mut gradients, mut law) = ([[zero; DOUBLES]; 2], [zero; DOUBLES], [zero; DOUBLES]);
            let mut free = [[0.0; DOUBLES]; 3];
            for lane in 0..DOUBLES {
                // The last group is filled up with its last triangle.
                let t = first + lane.min(out.len() - 1);
                let [i, j, k] = self.corners[t].map(|v| v as usize);
                let x = row(lanes, self.position[i]);
                edges[0][lane] = row(lanes, self.position[j]) - x;
                edges[1][lane] = row(lanes, self.position[k]) - x;
                gradients[lane] = gradients_of(lanes, &self.rest[t]);
                law[lane] = law_of(lanes, &self.stiffness[t]);
                let own = self.free(t);
                (free[0][lane], free[1][lane], free[2][lane]) = (own.xx, own.yy, own.xy);
            }
            let free = doubles(lanes, &free);
            let (a, b) = (components(edges[0]), components(edges[1]));
            let RotatedX4 { rotated: Rotated { axes: [r1, r2], stretch }, sound, least } =
                rotated(lanes, gradient([a, b], Doubles::transpose(gradients)), self.is_planar);
            let ([xx, yy, xy], strain) = (stretch, less(stretch, free));
            let stress = linear_stress(Doubles::transpose(law), strain);
            let rows = [
                Doubles::transpose([r1[0], r1[1], r1[2], r2[0]]),
                Doubles::transpose([r2[1], r2[2], xx, yy]),
                Doubles::transpose([xy, stress[0], stress[1], stress[2]]),
            ];
            for (lane, out) in out.iter_mut().enumerate() {
                let [[ax, ay, az, bx], [by, bz, xx, yy], [xy, txx, tyy, txy]] =
                    [rows[0][lane].to_array(), rows[1][lane].to_array(), rows[2][lane].to_array()];
                let polar = Polar {
                    fibre_axis: DVec3::new(ax, ay, az),
                    transverse_axis: DVec3::new(bx, by, bz),
                    stretch: Sym2::new(xx, yy, xy),
                };
                *out = ElementState { polar, stress: Sym2::new(txx, tyy, txy) }.into();
            }
            let strain_sq = dot(strain, strain);
            // Of all four at once: next to no group has one that is not.
            if !(sound.is_larger(least) & strain_sq.is_larger(rounding_sq)) {
                self.mend(first, out, (sound.to_array(), least.to_array()), strain_sq.to_array());
            }
        }
    }
}

/// Geometric stiffness of the rotated tangent: [`membrane::shear_majorant`] and the tensile part of
/// [`membrane::second_piola`].
pub struct Geometric<'a, T> {
    /// States of the triangles from `start` on.
    pub state: &'a [T],
    /// The first of them.
    pub start: usize,
    /// Elastic constants, of all triangles.
    pub stiffness: PerRow<'a, Orthotropic>,
    /// How much of the tissue's own least shear stiffness there is to be beyond the geometric one.
    pub reserve: f64,
}

impl<T: Stored> Geometric<'_, T> {
    /// Stretch and stress of up to four triangles, and their stiffness in the plane.
    #[inline(always)]
    fn in_plane<L: Lanes>(&self, lanes: L, first: usize, count: usize) -> ([Vectors<L>; 2], Doubles<L>) {
        let zero = Doubles::splat(lanes, 0.0);
        let (mut state, mut law) = ([[zero; DOUBLES]; 2], [zero; DOUBLES]);
        for lane in 0..DOUBLES {
            // The last group is filled up with its last triangle.
            let t = first + lane.min(count - 1);
            let [u, s] = self.state[t - self.start].tensors();
            state[0][lane] = Doubles::new(lanes, [u.xx, u.yy, u.xy, s.xx]);
            state[1][lane] = Doubles::new(lanes, [s.yy, s.xy, 0.0, 0.0]);
            law[lane] = law_of(lanes, &self.stiffness[t]);
        }
        let ([uxx, uyy, uxy, txx], [tyy, txy, ..]) = (Doubles::transpose(state[0]), Doubles::transpose(state[1]));
        let (stretch, stress) = ([uxx, uyy, uxy], [txx, tyy, txy]);
        ([stretch, stress], shear_majorant(stress, stretch, Doubles::transpose(law), self.reserve))
    }
}

/// Of planar bodies, which have none out of the plane.
impl Kernel<f64> for Geometric<'_, FlatState> {
    #[inline(always)]
    fn run<L: Lanes>(&self, lanes: L, first: usize, rows: &mut [f64]) {
        for (group, out) in rows.chunks_mut(DOUBLES).enumerate() {
            let (_, shear) = self.in_plane(lanes, first + group * DOUBLES, out.len());
            out.iter_mut().zip(shear.to_array()).for_each(|(out, shear)| *out = shear);
        }
    }
}

impl Kernel<GeometricStiffness> for Geometric<'_, ElementState> {
    #[inline(always)]
    fn run<L: Lanes>(&self, lanes: L, first: usize, rows: &mut [GeometricStiffness]) {
        let half = Doubles::splat(lanes, 0.5);
        for (group, out) in rows.chunks_mut(DOUBLES).enumerate() {
            let ([stretch, stress], shear) = self.in_plane(lanes, first + group * DOUBLES, out.len());
            let ([sxx, syy, sxy], shear) = (second_piola(stress, stretch), shear.to_array());
            let (mean, s_radius) = (half * (sxx + syy), radius(half * (sxx - syy), sxy));
            let (high, low) = (mean + s_radius, mean - s_radius);
            let scale = high / (high - low);
            let part = arrays([(sxx - low) * scale, (syy - low) * scale, sxy * scale]);
            let [sxx, syy, sxy, high, low] = arrays([sxx, syy, sxy, high, low]);
            for (lane, out) in out.iter_mut().enumerate() {
                // The positive part, as of [`Sym2`].
                let normal = if low[lane] >= 0.0 {
                    Sym2::new(sxx[lane], syy[lane], sxy[lane])
                } else if high[lane] <= 0.0 {
                    Sym2::ZERO
                } else {
                    Sym2::new(part[0][lane], part[1][lane], part[2][lane])
                };
                *out = GeometricStiffness { normal, in_plane: shear[lane] };
            }
        }
    }
}

/// Writes down the forces on the corners of up to four triangles: `a` and `b` on the last two, on the first the force that balances them.
#[inline(always)]
pub fn put_forces<L: Lanes>([a, b]: [Vectors<L>; 2], out: &mut [[DVec3; 3]]) {
    let (c, [bx, by, bz]) = (formulas::balance([a, b]), b);
    let rows = [Doubles::transpose([c[0], c[1], c[2], a[0]]), Doubles::transpose([a[1], a[2], bx, by])];
    let bz = bz.to_array();
    for (lane, out) in out.iter_mut().enumerate() {
        let ([cx, cy, cz, ax], [ay, az, bx, by]) = (rows[0][lane].to_array(), rows[1][lane].to_array());
        *out = [DVec3::new(cx, cy, cz), DVec3::new(ax, ay, az), DVec3::new(bx, by, bz[lane])];
    }
}

/// Forces on the corners of every triangle under its stress: [`membrane::nodal_forces`].
pub struct CornerForces<'a, T> {
    /// States of the triangles.
    pub state: &'a [T],
    /// Rest shapes.
    pub rest: &'a [RestTriangle],
    /// Thickness \[mm\].
    pub thickness: PerRow<'a, f64>,
}

impl<T: Stored> Kernel<[DVec3; 3]> for CornerForces<'_, T> {
    #[inline(always)]
    fn run<L: Lanes>(&self, lanes: L, first: usize, rows: &mut [[DVec3; 3]]) {
        let zero = Doubles::splat(lanes, 0.0);
        for (group, out) in rows.chunks_mut(DOUBLES).enumerate() {
            let first = first + group * DOUBLES;
            let (mut state, mut gradients, mut volume) =
                ([&self.state[first]; DOUBLES], [zero; DOUBLES], [0.0; DOUBLES]);
            for lane in 0..DOUBLES {
                let t = first + lane.min(out.len() - 1);
                state[lane] = &self.state[t];
                gradients[lane] = gradients_of(lanes, &self.rest[t]);
                volume[lane] = self.rest[t].area * self.thickness[t];
            }
            let StateLanes { axes, stretch, stress } = T::lanes(lanes, state);
            let [g1x, g1y, g2x, g2y] = Doubles::transpose(gradients);
            let pi = first_piola(stress, stretch, inverse_trace(stretch));
            let minus = zero - Doubles::new(lanes, volume);
            let scaled = [g1x * minus, g1y * minus, g2x * minus, g2y * minus];
            put_forces(spread(in_space(axes, pi), scaled), out);
        }
    }
}

#[cfg(test)]
#[path = "membrane_lanes_tests.rs"]
mod tests;

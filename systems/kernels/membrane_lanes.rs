//! The membrane element for four triangles side by side: the formulas of [`super::membrane`] and [`super::polar`], lane by lane.
//!
//! A step spends most of its time outside the linear solve here. What a lane cannot do alike (a collapsed or mirrored
//! triangle) is done by the functions for one triangle, against which these are tested.

use super::gather::{StateLanes, Stored, components, gradients_of, law_of, row};
use super::lanes::{DOUBLES, Doubles, Lanes};
use super::membrane::{self, LEAST_TRACE, ROUNDING_SQ};
use super::simd::Kernel;
use crate::math::{
    ElementState, FADES_FROM, Faded, FlatState, GeometricStiffness, Orthotropic, PerRow, Polar, RestTriangle, Sym2,
};
use glam::{DVec2, DVec3};
use std::sync::atomic::{AtomicBool, Ordering};

/// Vectors of four triangles.
pub type Vectors<L> = [Doubles<L>; 3];

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

/// a·b.
#[inline(always)]
pub fn dot<L: Lanes>(a: Vectors<L>, b: Vectors<L>) -> Doubles<L> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a × b.
#[inline(always)]
pub fn cross<L: Lanes>(a: Vectors<L>, b: Vectors<L>) -> Vectors<L> {
    [a[1] * b[2] - b[1] * a[2], a[2] * b[0] - b[2] * a[0], a[0] * b[1] - b[0] * a[1]]
}

/// √(a² + b²).
#[inline(always)]
pub fn radius<L: Lanes>(a: Doubles<L>, b: Doubles<L>) -> Doubles<L> {
    (a * a + b * b).sqrt()
}

/// a·s + b·t.
#[inline(always)]
pub fn combine<L: Lanes>(a: Vectors<L>, s: Doubles<L>, b: Vectors<L>, t: Doubles<L>) -> Vectors<L> {
    [a[0] * s + b[0] * t, a[1] * s + b[1] * t, a[2] * s + b[2] * t]
}

/// Polar decompositions of four deformation gradients.
pub struct Rotated<L: Lanes> {
    /// Fibre and transverse axis.
    pub axes: [Vectors<L>; 2],
    /// xx, yy and xy of the stretch.
    pub stretch: Vectors<L>,
    /// Where it is not larger than `least` the triangle is one for the functions for one triangle.
    pub sound: Doubles<L>,
    /// What it is to be larger than.
    pub least: Doubles<L>,
}

/// See [`super::polar`].
#[inline(always)]
pub fn rotated<L: Lanes>(lanes: L, f1: Vectors<L>, f2: Vectors<L>, is_planar: bool) -> Rotated<L> {
    let (half, one, zero) = (Doubles::splat(lanes, 0.5), Doubles::splat(lanes, 1.0), Doubles::splat(lanes, 0.0));
    let lengths_sq = dot(f1, f1) + dot(f2, f2);
    let (p, q, trace, sound, least) = if is_planar {
        let (p, q) = ([f1[0] + f2[1], f1[1] - f2[0], zero], [f2[0] - f1[1], f2[1] + f1[0], zero]);
        let trace_sq = dot(p, p);
        // Next to a mirror image the law fades, long before the rotation is but rounding.
        let least = Doubles::splat(lanes, FADES_FROM * FADES_FROM).max(lengths_sq * Doubles::splat(lanes, 1e-28));
        (p, q, trace_sq.sqrt(), trace_sq, least)
    } else {
        let normal = cross(f1, f2);
        let twice_area = dot(normal, normal).sqrt();
        let inverse = one / twice_area;
        let n = [normal[0] * inverse, normal[1] * inverse, normal[2] * inverse];
        let (p, q) = (cross(f2, n), cross(n, f1));
        let (p, q) = (combine(f1, one, p, one), combine(f2, one, q, one));
        let trace = (lengths_sq + twice_area + twice_area).sqrt();
        (p, q, trace, twice_area, lengths_sq * Doubles::splat(lanes, 1e-30))
    };
    let inverse = one / trace;
    let (r1, r2) = ([p[0] * inverse, p[1] * inverse, p[2] * inverse], [q[0] * inverse, q[1] * inverse, q[2] * inverse]);
    let stretch = [dot(r1, f1), dot(r2, f2), half * (dot(r1, f2) + dot(r2, f1))];
    Rotated { axes: [r1, r2], stretch, sound, least }
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

    /// Does over what a lane cannot do alike: triangles that are not sound, and strains that are but rounding.
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
            let ([g1x, g1y, g2x, g2y], [q11, q12, q22, q66]) = (Doubles::transpose(gradients), Doubles::transpose(law));
            let (f1, f2) = (combine(a, g1x, b, g2x), combine(a, g1y, b, g2y));
            let Rotated { axes: [r1, r2], stretch: [xx, yy, xy], sound, least } =
                rotated(lanes, f1, f2, self.is_planar);
            let (exx, eyy, exy) = (xx - free[0], yy - free[1], xy - free[2]);
            let stress = [q11 * exx + q12 * eyy, q12 * exx + q22 * eyy, (q66 + q66) * exy];
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
            let strain_sq = exx * exx + eyy * eyy + exy * exy;
            // Of all four at once: next to no group has one that is not.
            if !(sound.is_larger(least) & strain_sq.is_larger(rounding_sq)) {
                self.mend(first, out, (sound.to_array(), least.to_array()), strain_sq.to_array());
            }
        }
    }
}

/// Π = T − (κ/tr U)·J of four triangles, [`membrane`]'s `first_piola`.
#[inline(always)]
pub fn first_piola<L: Lanes>(stress: Vectors<L>, stretch: Vectors<L>, inverse_trace: Doubles<L>) -> [Doubles<L>; 4] {
    let ([txx, tyy, txy], [uxx, uyy, uxy]) = (stress, stretch);
    let spin = ((tyy - txx) * uxy + txy * (uxx - uyy)) * inverse_trace;
    [txx, txy + spin, txy - spin, tyy]
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
        let (half, quarter) = (Doubles::splat(lanes, 0.5), Doubles::splat(lanes, 0.25));
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
        let [q11, q12, q22, q66] = Doubles::transpose(law);
        let trace = uxx + uyy;
        let (u_half, t_half) = (half * (uxx - uyy), half * (txx - tyy));
        let smallest = Doubles::splat(lanes, f64::MIN_POSITIVE);
        let low = (half * trace - radius(u_half, uxy)).max(Doubles::splat(lanes, 0.2) * trace).max(smallest);
        let (t_mean, t_radius) = (half * (txx + tyy), radius(t_half, txy));
        let along = t_mean + t_radius + (t_radius + t_radius) * (low / trace);
        let geometric = along * trace * quarter / (low * low);
        let shear_law = quarter * (q11 + q22) - half * q12;
        // The smaller of two numbers.
        let own = zero - (zero - q66).max(zero - shear_law);
        let shear = (geometric + Doubles::splat(lanes, self.reserve) * own).max(zero);
        ([[uxx, uyy, uxy], [txx, tyy, txy]], shear)
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
        let smallest = Doubles::splat(lanes, f64::MIN_POSITIVE);
        for (group, out) in rows.chunks_mut(DOUBLES).enumerate() {
            let (state, shear) = self.in_plane(lanes, first + group * DOUBLES, out.len());
            let ([[uxx, uyy, uxy], stress], shear) = (state, shear.to_array());
            let trace = uxx + uyy;
            let inverse_trace = Doubles::splat(lanes, 1.0) / trace.max(Doubles::splat(lanes, LEAST_TRACE));
            let pi = first_piola(stress, state[0], inverse_trace);
            let determinant = uxx * uyy - uxy * uxy;
            let bound = Doubles::splat(lanes, 2.5e-3) * trace * trace;
            let inverse = Doubles::splat(lanes, 1.0) / determinant.max(bound).max(smallest);
            let sxx = (uyy * pi[0] - uxy * pi[2]) * inverse;
            let syy = (uxx * pi[3] - uxy * pi[1]) * inverse;
            let sxy = half * ((uyy * pi[1] - uxy * pi[3]) + (uxx * pi[2] - uxy * pi[0])) * inverse;
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

/// Writes down the forces on the corners of up to four triangles: `a` and `b` on the last two, on the first what balances them.
#[inline(always)]
pub fn balance<L: Lanes>(lanes: L, a: Vectors<L>, b: Vectors<L>, out: &mut [[DVec3; 3]]) {
    let minus_one = Doubles::splat(lanes, -1.0);
    let (c, [bx, by, bz]) = ([minus_one * a[0] - b[0], minus_one * a[1] - b[1], minus_one * a[2] - b[2]], b);
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
            let StateLanes { axes: [r1, r2], stretch, stress } = T::lanes(lanes, state);
            let [g1x, g1y, g2x, g2y] = Doubles::transpose(gradients);
            let trace = stretch[0] + stretch[1];
            let inverse_trace = Doubles::splat(lanes, 1.0) / trace.max(Doubles::splat(lanes, LEAST_TRACE));
            let pi = first_piola(stress, stretch, inverse_trace);
            let (p1, p2) = (combine(r1, pi[0], r2, pi[2]), combine(r1, pi[1], r2, pi[3]));
            let minus = zero - Doubles::new(lanes, volume);
            let a = combine(p1, g1x * minus, p2, g1y * minus);
            let b = combine(p1, g2x * minus, p2, g2y * minus);
            balance(lanes, a, b, out);
        }
    }
}

/// How far triangles go: the rows have nothing in them. Of the sums the first says how many go far, at the least; the
/// second is that of A·a⁴ with the rest area A \[mm²\] and the norm a of the change of the deformation gradient.
pub struct Far<'a> {
    /// Vertices of the triangles.
    pub corners: &'a [[u32; 3]],
    /// Rest shapes.
    pub rest: &'a [RestTriangle],
    /// Displacement of the vertices \[mm\].
    pub displacement: &'a [DVec3],
    /// The a from which on a triangle goes far.
    pub from: f64,
}

impl Kernel<(), DVec2> for Far<'_> {
    #[inline(always)]
    fn run<L: Lanes>(&self, lanes: L, first: usize, rows: &mut [()]) -> DVec2 {
        let most_sq = self.from * self.from;
        let (mut count, mut sum, zero) = (0, 0.0, Doubles::splat(lanes, 0.0));
        for start in (first..first + rows.len()).step_by(DOUBLES) {
            let (mut edges, mut gradients, mut areas) = ([[zero; DOUBLES]; 2], [zero; DOUBLES], [0.0; DOUBLES]);
            let within = (first + rows.len() - start).min(DOUBLES);
            for lane in 0..DOUBLES {
                let t = start + lane.min(within - 1);
                let [i, j, k] = self.corners[t].map(|v| v as usize);
                let u = row(lanes, self.displacement[i]);
                edges[0][lane] = row(lanes, self.displacement[j]) - u;
                edges[1][lane] = row(lanes, self.displacement[k]) - u;
                gradients[lane] = gradients_of(lanes, &self.rest[t]);
                areas[lane] = self.rest[t].area;
            }
            let (a, b) = (components(edges[0]), components(edges[1]));
            let [g1x, g1y, g2x, g2y] = Doubles::transpose(gradients);
            let (d1, d2) = (combine(a, g1x, b, g2x), combine(a, g1y, b, g2y));
            let change_sq = dot(d1, d1) + dot(d2, d2);
            let weighted = (Doubles::new(lanes, areas) * change_sq * change_sq).to_array();
            let change_sq = change_sq.to_array();
            for lane in 0..within {
                // What is no number goes far.
                count += usize::from(!(change_sq[lane] <= most_sq));
                sum += weighted[lane];
            }
        }
        DVec2::new(count as f64, sum)
    }
}

#[cfg(test)]
#[path = "membrane_lanes_tests.rs"]
mod tests;

//! Moments and forces of bending: passes over four triangles at a time, each with other triangles' numbers of the one before.

use super::DihedralAngles;
use super::spurious_energy::Halves;
use super::taut::Part;
use crate::storage::Topology;
use crate::systems::kernels::bending_lanes::{EdgeValuesX4, RestX4, TiltX4, at};
use crate::systems::kernels::gather::at_corners;
use crate::systems::kernels::lanes::{DOUBLES, Doubles, Lanes};
use crate::systems::kernels::membrane_lanes::{Vectors, arrays, doubles};
use crate::systems::kernels::simd::Kernel;
use crate::systems::parallel;
use glam::DVec3;

/// Intermediate values of the passes over the triangles. *Derived.* Lists of [`EdgeValuesX4`] end with zeros, for the boundary.
#[derive(Debug, Default)]
pub struct BendingPasses {
    /// Tilts of a displacement, at last forces on corners along the normals.
    pub(super) rows: Vec<EdgeValuesX4>,
    /// Moments without any turn of the mid-edge normals, at last with all.
    pub(super) first: Vec<EdgeValuesX4>,
    /// Moments of the rotations of the mid-edge normals.
    pub(super) second: Vec<EdgeValuesX4>,
    /// Per edge half the deviation of its dihedral angle from the rest value.
    pub(super) off: Vec<f64>,
    /// Whether the deviations are those at the end of the motion.
    pub(super) is_at_end: bool,
    /// Displacements and final positions of the vertices in a motion.
    pub(super) motion: Vec<[DVec3; 2]>,
    /// Normals at the end of the motion.
    pub(super) ends: Vec<[DVec3; DOUBLES]>,
    pub(super) halves: Vec<Halves>,
}

impl BendingPasses {
    /// Whether the angles are those at `x`, to the last bit.
    fn ends_at(&self, x: &[DVec3]) -> bool {
        let bits = |x: DVec3| x.to_array().map(f64::to_bits);
        self.is_at_end
            && self.motion.len() == x.len()
            && self.motion.iter().zip(x).all(|([_, end], x)| bits(*end) == bits(*x))
    }
}

/// Makes a list for so many groups of four, with zeros at its end.
pub(super) fn size<T: Copy + Default>(list: &mut Vec<T>, count: usize) {
    list.resize(count + 1, T::default());
    list[count] = T::default();
}

impl DihedralAngles {
    /// The tilts of the triangles at `x`.
    pub(super) fn find_tilts(&mut self, corners: &[[u32; 3]], x: &[DVec3]) {
        let Self { groups, tilt, .. } = self;
        tilt.resize(groups.len(), TiltX4::default());
        parallel::for_x4(tilt, &Evaluation { groups, corners, x });
    }

    /// Finds half the deviations of the dihedral angles from their rest values at `x`, where the tilts have been found.
    pub(super) fn find_angles(&mut self, corners: &[[u32; 3]], x: &[DVec3], passes: &mut BendingPasses) {
        let Self { edges, tilt, half, .. } = self;
        // Steps mostly begin where the last one's motion has been judged to end.
        if !passes.ends_at(x) {
            edges.find(corners, |t| tilt[t / DOUBLES].normal[t % DOUBLES], |v| x[v], &mut passes.off);
            passes.is_at_end = false;
        }
        let off = &passes.off;
        half.resize(tilt.len(), EdgeValuesX4::default());
        parallel::for_x4(half, &Around { edges, off });
    }

    /// Adds to every vertex `sign` times the forces of moments: for `at` times the half angles as they are, and `by` times
    /// their change by a displacement `u`.
    pub(super) fn spread(
        &self,
        scales: (f64, f64),
        u: impl Fn(usize) -> DVec3 + Sync,
        (is_exact, sign): (bool, f64),
        (corners, topology): (&[[u32; 3]], &Topology),
        (out, passes): (&mut [DVec3], &mut BendingPasses),
    ) {
        self.find_forces(scales, u, is_exact, corners, passes);
        let rows = &passes.rows;
        parallel::for_rows(out, |v, out| {
            let mut sum = DVec3::ZERO;
            for &c in &topology.incident[v] {
                let (t, corner) = (c as usize / 3, c as usize % 3);
                sum += self.tilt[t / DOUBLES].normal[t % DOUBLES] * at(rows, t, corner);
            }
            *out += sum * sign;
        });
    }

    /// Adds the product \[N\] to the forces on the corners of the triangles.
    pub fn add_to_corners(
        &self,
        corners: &[[u32; 3]],
        u: &[DVec3],
        is_exact: bool,
        out: &mut [[DVec3; 3]],
        passes: &mut BendingPasses,
    ) {
        self.find_forces((0.0, self.factor), |v| u[v], is_exact, corners, passes);
        let rows = &passes.rows;
        parallel::for_rows(out, |t, out| {
            if is_exact || self.part[t] != Part::None {
                let normal = self.tilt[t / DOUBLES].normal[t % DOUBLES];
                for corner in 0..3 {
                    out[corner] += normal * at(rows, t, corner);
                }
            }
        });
    }

    /// Leaves in `rows` the forces on the corners along the normals.
    fn find_forces(
        &self,
        (at, by): (f64, f64),
        u: impl Fn(usize) -> DVec3 + Sync,
        is_exact: bool,
        corners: &[[u32; 3]],
        BendingPasses { rows, first, second, .. }: &mut BendingPasses,
    ) {
        debug_assert_eq!(corners.len(), self.rest.len());
        let count = self.groups.len();
        for list in [&mut *rows, first, second] {
            size(list, count);
        }
        if by != 0.0 {
            parallel::for_x4(&mut rows[..count], &Tilts { folds: self, corners, u, is_exact });
        }
        let angles = Change { folds: self, tilts: rows, at, by };
        parallel::for_x4(&mut first[..count], &First { angles, is_exact });
        if is_exact {
            parallel::for_x4(&mut second[..count], &Second { angles, first });
            parallel::for_x4(&mut first[..count], &Third { groups: &self.groups, second });
        }
        parallel::for_x4(&mut rows[..count], &Along { folds: self, moments: first, is_exact });
    }

    /// 1 for each of four triangles whose moments are in the majorant, else 0.
    #[inline(always)]
    pub(super) fn are_whole(&self, four: usize) -> [f64; DOUBLES] {
        let (parts, mut are_whole) = (self.parts(four), [0.0; DOUBLES]);
        for lane in 0..DOUBLES {
            are_whole[lane] = if parts[lane] == Part::Whole { 1.0 } else { 0.0 };
        }
        are_whole
    }

    /// Parts of four triangles that the majorant includes.
    #[inline(always)]
    fn parts(&self, four: usize) -> [Part; DOUBLES] {
        let mut parts = [Part::None; DOUBLES];
        parts.copy_from_slice(&self.part[four * DOUBLES..][..DOUBLES]);
        parts
    }
}

/// Tilts of the triangles at `x`.
struct Evaluation<'a> {
    groups: &'a [RestX4],
    corners: &'a [[u32; 3]],
    x: &'a [DVec3],
}

impl Kernel<TiltX4> for Evaluation<'_> {
    #[inline(always)]
    fn run<L: Lanes>(&self, lanes: L, first: usize, rows: &mut [TiltX4]) {
        for (four, out) in (first..).zip(rows) {
            *out = TiltX4::new(lanes, (self.corners, four * DOUBLES), &|v| self.x[v], &self.groups[four]);
        }
    }
}

/// Gathers edge values at the edges of triangles.
struct Around<'a> {
    edges: &'a super::angles::Edges,
    off: &'a [f64],
}

impl Kernel<EdgeValuesX4> for Around<'_> {
    #[inline(always)]
    fn run<L: Lanes>(&self, _: L, first: usize, rows: &mut [EdgeValuesX4]) {
        for (four, out) in (first..).zip(rows) {
            *out = self.edges.around(four, self.off);
        }
    }
}

/// Tilts of a displacement.
pub(super) struct Tilts<'a, U> {
    pub folds: &'a DihedralAngles,
    pub corners: &'a [[u32; 3]],
    pub u: U,
    pub is_exact: bool,
}

impl<U: Fn(usize) -> DVec3 + Sync> Kernel<EdgeValuesX4> for Tilts<'_, U> {
    #[inline(always)]
    fn run<L: Lanes>(&self, lanes: L, first: usize, rows: &mut [EdgeValuesX4]) {
        let Self { folds, corners, u, is_exact } = self;
        for (four, out) in (first..).zip(rows) {
            *out = if *is_exact || folds.parts(four) != [Part::None; DOUBLES] {
                arrays(folds.tilt[four].of(lanes, at_corners(lanes, (corners, four * DOUBLES), u)))
            } else {
                EdgeValuesX4::default()
            };
        }
    }
}

/// Half angles: `at` times as they are, and `by` times their change by tilts.
#[derive(Clone, Copy)]
struct Change<'a> {
    folds: &'a DihedralAngles,
    tilts: &'a [EdgeValuesX4],
    at: f64,
    by: f64,
}

impl Change<'_> {
    #[inline(always)]
    fn half<L: Lanes>(&self, lanes: L, four: usize) -> Vectors<L> {
        let Self { folds, tilts, at, by } = self;
        let mut half = [Doubles::splat(lanes, 0.0); 3];
        if *at != 0.0 {
            let as_is = doubles(lanes, &folds.half[four]);
            for e in 0..3 {
                half[e] = as_is[e] * Doubles::splat(lanes, *at);
            }
        }
        if *by != 0.0 {
            let change = folds.groups[four].half_of_tilts(lanes, doubles(lanes, &tilts[four]), tilts);
            for e in 0..3 {
                half[e] = half[e] + change[e] * Doubles::splat(lanes, *by);
            }
        }
        half
    }
}

/// Moments without any turn of the mid-edge normals: all that there are in the majorant.
struct First<'a> {
    angles: Change<'a>,
    is_exact: bool,
}

impl Kernel<EdgeValuesX4> for First<'_> {
    #[inline(always)]
    fn run<L: Lanes>(&self, lanes: L, first: usize, rows: &mut [EdgeValuesX4]) {
        let Self { angles, is_exact } = self;
        for (four, out) in (first..).zip(rows) {
            let are_whole = if *is_exact { [1.0; DOUBLES] } else { angles.folds.are_whole(four) };
            *out = if are_whole == [0.0; DOUBLES] {
                EdgeValuesX4::default()
            } else {
                let moment = angles.folds.groups[four].product(lanes, angles.half(lanes, four));
                let are_whole = Doubles::new(lanes, are_whole);
                arrays([moment[0] * are_whole, moment[1] * are_whole, moment[2] * are_whole])
            };
        }
    }
}

/// Moments with the mid-edge normals turned by the first ones.
struct Second<'a> {
    angles: Change<'a>,
    first: &'a [EdgeValuesX4],
}

impl Kernel<EdgeValuesX4> for Second<'_> {
    #[inline(always)]
    fn run<L: Lanes>(&self, lanes: L, first: usize, rows: &mut [EdgeValuesX4]) {
        for (four, out) in (first..).zip(rows) {
            let rest = &self.angles.folds.groups[four];
            let half = self.angles.half(lanes, four);
            let differences = rest.differences(lanes, four, self.first);
            *out = arrays(rest.product(lanes, rest.plus_turned(lanes, half, differences)));
        }
    }
}

/// Moments with the mid-edge normals turned by the first ones and by the moments of that turn.
struct Third<'a> {
    groups: &'a [RestX4],
    second: &'a [EdgeValuesX4],
}

impl Kernel<EdgeValuesX4> for Third<'_> {
    #[inline(always)]
    fn run<L: Lanes>(&self, lanes: L, first: usize, rows: &mut [EdgeValuesX4]) {
        for (four, out) in (first..).zip(rows) {
            let rest = &self.groups[four];
            let (own, nothing) = (doubles(lanes, &self.second[four]), [Doubles::splat(lanes, 0.0); 3]);
            let differences = rest.differences(lanes, four, self.second);
            let more = rest.product(lanes, rest.plus_turned(lanes, nothing, differences));
            *out = arrays([own[0] + more[0], own[1] + more[1], own[2] + more[2]]);
        }
    }
}

/// Forces of moments on the corners along the normals.
struct Along<'a> {
    folds: &'a DihedralAngles,
    moments: &'a [EdgeValuesX4],
    is_exact: bool,
}

impl Kernel<EdgeValuesX4> for Along<'_> {
    #[inline(always)]
    fn run<L: Lanes>(&self, lanes: L, first: usize, rows: &mut [EdgeValuesX4]) {
        let Self { folds, moments, is_exact } = self;
        for (four, out) in (first..).zip(rows) {
            *out = if *is_exact || folds.parts(four) != [Part::None; DOUBLES] {
                let half = folds.groups[four].half_of_tilts(lanes, doubles(lanes, &moments[four]), moments);
                arrays(folds.tilt[four].along(lanes, half))
            } else {
                EdgeValuesX4::default()
            };
        }
    }
}

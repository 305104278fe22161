//! Spurious energy of bending by a motion along the tangent, for the [energy guard](crate::systems::guard).

use super::DihedralAngles;
use super::forces::{BendingPasses, Tilts, size};
use crate::systems::kernels::bending;
use crate::systems::kernels::bending_lanes::{EdgeValuesX4, RestX4, unit_normals};
use crate::systems::kernels::formulas::dot;
use crate::systems::kernels::lanes::{DOUBLES, Doubles, Lanes};
use crate::systems::kernels::membrane_lanes::{F64x4, Vectors, arrays, doubles};
use crate::systems::kernels::simd::Kernel;
use crate::systems::parallel;
use glam::DVec3;

/// A triangle whose half angles are smaller \[rad\] stores next to nothing.
const LEVEL: f64 = 1e-3;

impl DihedralAngles {
    /// Bending energy \[mJ\] of the angles last evaluated; triangles with negligible angles are left out.
    pub fn stored(&self, partials: &mut Vec<f64>) -> f64 {
        parallel::sum(self.rest.len(), partials, |t| {
            let half = self.half(t);
            if half.abs().max_element() < LEVEL {
                return 0.0;
            }
            let phi = half + self.turned(t, |t| bending::product(&self.rest[t].law, self.half(t)));
            0.5 * phi.dot(bending::product(&self.rest[t].law, phi))
        })
    }

    /// Spurious energy E(x + u) − E(x) + f·u − u·K·u \[mJ\] for a displacement u from where the angles were last evaluated. K is
    /// the tangent of the step, exact or the majorant. The work of damping by the way `before` in the step is subtracted: along u,
    /// and along that way too where that is not counted yet. Where the dihedral angle passes 180°, E takes it from the other side,
    /// as the forces of the next step do. For that x + u has to have the bits that the next step starts from: `motion` gives u and
    /// x + u of each of so many vertices.
    pub fn spurious_energy(
        &self,
        corners: &[[u32; 3]],
        (vertices, motion): (usize, impl Fn(usize) -> [DVec3; 2] + Sync),
        before: Option<(&[DVec3], bool)>,
        is_exact: bool,
        (partials, passes): (&mut Vec<f64>, &mut BendingPasses),
    ) -> f64 {
        let BendingPasses { rows, second: earlier, off, is_at_end, motion: motions, ends, halves, .. } = passes;
        let count = self.groups.len();
        motions.resize(vertices, Default::default());
        ends.resize(count, Default::default());
        size(rows, count);
        size(earlier, count);
        size(halves, count);
        parallel::for_rows(motions, |v, out| *out = motion(v));
        parallel::for_x4(ends, &Ends { groups: &self.groups, corners, motions });
        let tilts = Tilts { folds: self, corners, u: |v: usize| motions[v][0], is_exact: true };
        parallel::for_x4(&mut rows[..count], &tilts);
        if let Some((before, _)) = before {
            let tilts = Tilts { folds: self, corners, u: |v: usize| before[v], is_exact: true };
            parallel::for_x4(&mut earlier[..count], &tilts);
        }
        self.edges.find(corners, |t| ends[t / DOUBLES][t % DOUBLES], |v| motions[v][1], off);
        *is_at_end = true;
        let has_before = before.is_some();
        let halving = Halving { folds: self, tilts: rows, earlier, off, has_before };
        parallel::for_x4(&mut halves[..count], &halving);
        let is_counted = before.is_none_or(|(_, is_counted)| is_counted);
        let balance = Balance { folds: self, halves, is_exact, has_before, is_counted };
        parallel::sum_x4(count, partials, &balance)
    }
}

/// Four half angles per edge of every triangle, and their products with the law: at the start of a motion, at its end, their
/// change along the tilts, and that of the motion before.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Halves {
    half: [EdgeValuesX4; 4],
    /// Products of the four half angles with the law, per edge and triangle.
    first: [[F64x4; DOUBLES]; 3],
}

/// Places of the four half angles.
const START: usize = 0;
const END: usize = 1;
const CHANGE: usize = 2;
const EARLIER: usize = 3;

/// Normals at the end of a motion.
struct Ends<'a> {
    groups: &'a [RestX4],
    corners: &'a [[u32; 3]],
    motions: &'a [[DVec3; 2]],
}

impl Kernel<[DVec3; DOUBLES]> for Ends<'_> {
    #[inline(always)]
    fn run<L: Lanes>(&self, lanes: L, first: usize, rows: &mut [[DVec3; DOUBLES]]) {
        for (four, out) in (first..).zip(rows) {
            let triangles = (self.corners, four * DOUBLES);
            *out = unit_normals(lanes, triangles, &|v| self.motions[v][1], &self.groups[four]);
        }
    }
}

/// The half angles of a motion, with their products.
struct Halving<'a> {
    folds: &'a DihedralAngles,
    tilts: &'a [EdgeValuesX4],
    earlier: &'a [EdgeValuesX4],
    off: &'a [f64],
    has_before: bool,
}

impl Kernel<Halves> for Halving<'_> {
    #[inline(always)]
    fn run<L: Lanes>(&self, lanes: L, first: usize, rows: &mut [Halves]) {
        let Self { folds, tilts, earlier, off, has_before } = self;
        for (four, Halves { half, first }) in (first..).zip(rows) {
            let rest = &folds.groups[four];
            half[START] = folds.half[four];
            half[END] = folds.edges.around(four, off);
            half[CHANGE] = arrays(rest.half_of_tilts(lanes, doubles(lanes, &tilts[four]), tilts));
            if *has_before {
                half[EARLIER] = arrays(rest.half_of_tilts(lanes, doubles(lanes, &earlier[four]), earlier));
            }
            let mut products = [[Doubles::splat(lanes, 0.0); 3]; 4];
            for q in 0..if *has_before { 4 } else { EARLIER } {
                products[q] = rest.product(lanes, doubles(lanes, &half[q]));
            }
            for e in 0..3 {
                let of_edge = [products[START][e], products[END][e], products[CHANGE][e], products[EARLIER][e]];
                first[e] = arrays(Doubles::transpose(of_edge));
            }
        }
    }
}

/// Spurious energy of the triangles: the rows have nothing in them.
struct Balance<'a> {
    folds: &'a DihedralAngles,
    halves: &'a [Halves],
    is_exact: bool,
    has_before: bool,
    /// Whether the way before is counted.
    is_counted: bool,
}

impl Balance<'_> {
    /// Half angles with the mid-edge normals turned.
    #[inline(always)]
    fn turned<L: Lanes>(&self, lanes: L, four: usize) -> [Vectors<L>; 4] {
        let (rest, Halves { half, first }) = (&self.folds.groups[four], &self.halves[four]);
        let zero = Doubles::splat(lanes, 0.0);
        let mut differences = [[zero; 3]; 4];
        for e in 0..3 {
            let mut of_edge = [zero; DOUBLES];
            for lane in 0..DOUBLES {
                let (other, place) = rest.across(e, lane);
                let other = self.halves[other].first.as_flattened()[place];
                of_edge[lane] = Doubles::new(lanes, other) - Doubles::new(lanes, first[e][lane]);
            }
            let of_edge = Doubles::transpose(of_edge);
            for q in 0..4 {
                differences[q][e] = of_edge[q];
            }
        }
        let mut phi = [[zero; 3]; 4];
        for q in 0..4 {
            phi[q] = rest.plus_turned(lanes, doubles(lanes, &half[q]), differences[q]);
        }
        phi
    }
}

impl Kernel<(), f64> for Balance<'_> {
    #[inline(always)]
    fn run<L: Lanes>(&self, lanes: L, first: usize, rows: &mut [()]) -> f64 {
        let Self { folds, halves, is_exact, has_before, is_counted } = self;
        let half = Doubles::splat(lanes, 0.5);
        let (factor, damping) = (Doubles::splat(lanes, folds.factor), Doubles::splat(lanes, folds.factor - 1.0));
        let mut sum = Doubles::splat(lanes, 0.0);
        for four in first..first + rows.len() {
            let rest = &folds.groups[four];
            let phi = self.turned(lanes, four);
            let (start, end) = (rest.product(lanes, phi[START]), rest.product(lanes, phi[END]));
            let (before, after) = (dot(phi[START], start), dot(phi[END], end));
            let pull = if *is_exact {
                dot(rest.product(lanes, phi[CHANGE]), phi[CHANGE])
            } else {
                let by_tilts = doubles(lanes, &halves[four].half[CHANGE]);
                dot(rest.product(lanes, by_tilts), by_tilts) * Doubles::new(lanes, folds.are_whole(four))
            };
            sum = sum + (half * (after - before) - dot(start, phi[CHANGE]) - factor * pull);
            if *has_before {
                let mut along = phi[CHANGE];
                if !is_counted {
                    for e in 0..3 {
                        along[e] = along[e] + phi[EARLIER][e];
                    }
                }
                sum = sum - damping * dot(rest.product(lanes, phi[EARLIER]), along);
            }
        }
        let [a, b, c, d] = sum.to_array();
        (a + b) + (c + d)
    }
}

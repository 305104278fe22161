//! What a motion along the tangent leaves over of the energy of bending: for [`contain`](crate::systems::contain).

use super::{Folds, Halves, Passes, RestFold};
use crate::storage::NONE;
use crate::systems::kernels::fold::{self, OverEdges};
use crate::systems::kernels::lanes::{DOUBLES, Doubles, Lanes};
use crate::systems::kernels::membrane_lanes::{Four, arrays, dot, doubles};
use crate::systems::kernels::simd::Kernel;
use crate::systems::parallel;
use glam::DVec3;
use std::sync::PoisonError;

/// A triangle whose half angles are smaller \[rad\] stores next to nothing.
const LEVEL: f64 = 1e-3;

impl Folds {
    /// The energy \[mJ\] of the angles last evaluated, but for what is next to nothing.
    pub fn stored(&self, partials: &mut Vec<f64>) -> f64 {
        parallel::sum(self.rest.len(), partials, |t| {
            if self.half[t].abs().max_element() < LEVEL {
                return 0.0;
            }
            let phi = self.half[t] + self.turned(t, |t| fold::product(&self.rest[t].law, self.half[t]));
            0.5 * phi.dot(fold::product(&self.rest[t].law, phi))
        })
    }

    /// E(x + u) − E(x) + f·u − u·K·u \[mJ\] with the tangent K of the step, exact or the majorant, for a displacement u
    /// from where the angles were last evaluated, less what damping by the way `before` in the step does along u, and
    /// along that way too where that is not counted yet. Where a fold goes on beyond 180° E is that of the fold told
    /// from its other side, as the forces of the next step are. For that x + u has to have the bits that the next step
    /// starts from: `motion` gives u and x + u of each of so many vertices.
    pub fn left_over(
        &self,
        corners: &[[u32; 3]],
        (vertices, motion): (usize, impl Fn(usize) -> [DVec3; 2] + Sync),
        before: Option<(&[DVec3], bool)>,
        is_exact: bool,
        partials: &mut Vec<f64>,
    ) -> f64 {
        let mut passes = self.passes.lock().unwrap_or_else(PoisonError::into_inner);
        let Passes { off, motion: motions, moved, halves, .. } = &mut *passes;
        let count = self.rest.len();
        motions.resize(vertices, Default::default());
        moved.resize(count, Default::default());
        halves.resize(count, Default::default());
        parallel::for_rows(motions, |v, out| *out = motion(v));
        parallel::for_rows(moved, |t, moved| {
            let corners = corners[t].map(|v| v as usize);
            let (ends, tilt) = (corners.map(|v| motions[v][1]), &self.tilt[t]);
            let earlier = before.map_or(DVec3::ZERO, |(before, _)| tilt.of(corners.map(|v| before[v])));
            *moved = [fold::normal(ends, self.made_of[t].0.area), tilt.of(corners.map(|v| motions[v][0])), earlier];
        });
        self.edges.find(corners, |t| moved[t][0], |v| motions[v][1], off);
        let has_before = before.is_some();
        parallel::for_chunks(halves, &Halving { folds: self, moved, off, has_before });
        let is_counted = before.is_none_or(|(_, is_counted)| is_counted);
        let balance = Balance { folds: self, halves, is_exact, has_before, is_counted };
        parallel::sum_chunks(&mut vec![(); count], partials, &balance)
    }
}

/// The products with four vectors over the edges: [`fold::product`]'s, side by side.
#[inline(always)]
fn products<L: Lanes>(lanes: L, m: &OverEdges, v: [Doubles<L>; 3]) -> [Doubles<L>; 3] {
    let mut q = [v[0]; 6];
    for i in 0..6 {
        q[i] = Doubles::splat(lanes, m[i]);
    }
    [
        q[0] * v[0] + q[3] * v[1] + q[5] * v[2],
        q[3] * v[0] + q[1] * v[1] + q[4] * v[2],
        q[5] * v[0] + q[4] * v[1] + q[2] * v[2],
    ]
}

/// The half angles of a motion, with their products.
struct Halving<'a> {
    folds: &'a Folds,
    moved: &'a [[DVec3; 3]],
    off: &'a [f64],
    has_before: bool,
}

impl Kernel<Halves> for Halving<'_> {
    #[inline(always)]
    fn run<L: Lanes>(&self, lanes: L, first: usize, rows: &mut [Halves]) {
        let Self { folds, moved, off, has_before } = self;
        for (i, [half, product]) in rows.iter_mut().enumerate() {
            let t = first + i;
            let [start, end] = [folds.half[t], folds.edges.around(t, off)];
            let change = folds.half_of_tilts(t, |t| moved[t][1]);
            let earlier = if *has_before { folds.half_of_tilts(t, |t| moved[t][2]) } else { DVec3::ZERO };
            for e in 0..3 {
                half[e] = [start[e], end[e], change[e], earlier[e]];
            }
            *product = arrays(products(lanes, &folds.rest[t].law, doubles(lanes, half)));
        }
    }
}

/// What the triangles leave over: the rows have nothing in them.
struct Balance<'a> {
    folds: &'a Folds,
    halves: &'a [Halves],
    is_exact: bool,
    has_before: bool,
    /// Whether the way before is counted.
    is_counted: bool,
}

impl Kernel<(), f64> for Balance<'_> {
    #[inline(always)]
    fn run<L: Lanes>(&self, lanes: L, first: usize, rows: &mut [()]) -> f64 {
        let Self { folds, halves, is_exact, has_before, is_counted } = self;
        let mut sum = 0.0;
        for t in first..first + rows.len() {
            let RestFold { law, turn, across, .. } = &folds.rest[t];
            let [half, product] = &halves[t];
            let mut phi = doubles(lanes, half);
            for e in 0..3 {
                let (n, f) = (across[e] as usize / 3, across[e] as usize % 3);
                let other = if across[e] == NONE { [0.0; DOUBLES] } else { halves[n][1][f] };
                let difference = Doubles::new(lanes, other) - Doubles::new(lanes, product[e]);
                phi[e] = phi[e] + difference * Doubles::splat(lanes, turn[e]);
            }
            let moment = products(lanes, law, phi);
            let energy = dot(phi, moment).to_array();
            let (phi, moment) = (arrays(phi), arrays(moment));
            let [start, change, earlier] = [of(&moment, 0), of(&moment, 2), of(&moment, 3)];
            let (way, by_tilts) = (of(&phi, 2), of(half, 2));
            let pull = if *is_exact {
                folds.factor * change.dot(way)
            } else {
                fold::product(&folds.law(t), by_tilts).dot(by_tilts)
            };
            let along = if *is_counted { way } else { way + of(&phi, 3) };
            let damped = if *has_before { (folds.factor - 1.0) * earlier.dot(along) } else { 0.0 };
            sum += 0.5 * (energy[1] - energy[0]) - start.dot(way) - pull - damped;
        }
        sum
    }
}

/// One of four vectors over the edges.
#[inline(always)]
fn of(x: &[Four; 3], lane: usize) -> DVec3 {
    DVec3::new(x[0][lane], x[1][lane], x[2][lane])
}

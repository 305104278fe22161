//! What a motion along the tangent leaves over of the energy of bending: for [`contain`](crate::systems::contain).

use super::{Folds, Passes, RestFold};
use crate::storage::NONE;
use crate::systems::kernels::fold::{self, OverEdges};
use crate::systems::parallel;
use glam::{DVec3, DVec4};
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

    /// E(x + u) − E(x) + f·u − u·K·u \[mJ\] with the tangent K of the step, exact or the majorant, for a displacement u from where the angles
    /// were last evaluated, less what damping by the way `before` in the step does along u, and along that way too where that is not
    /// counted yet. Where a fold goes on beyond 180° E is that of the fold told from its other side, as the forces of the next step are. For that
    /// x + u has to have the bits that the next step starts from: `motion` gives u and x + u of each of so many vertices.
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
        parallel::for_rows(halves, |t, [half, product]| {
            let [start, end] = [self.half[t], self.edges.around(t, off)];
            let change = self.half_of_tilts(t, |t| moved[t][1]);
            let earlier = if before.is_some() { self.half_of_tilts(t, |t| moved[t][2]) } else { DVec3::ZERO };
            *half = [0, 1, 2].map(|e| DVec4::new(start[e], end[e], change[e], earlier[e]));
            *product = products(&self.rest[t].law, half);
        });
        parallel::sum(count, partials, |t| {
            let RestFold { law, turn, across, .. } = &self.rest[t];
            let [half, product] = &halves[t];
            let mut phi = *half;
            for (e, &across) in across.iter().enumerate() {
                let other =
                    if across == NONE { DVec4::ZERO } else { halves[across as usize / 3][1][across as usize % 3] };
                phi[e] += (other - product[e]) * turn[e];
            }
            let moment = products(law, &phi);
            let energy = phi[0] * moment[0] + phi[1] * moment[1] + phi[2] * moment[2];
            let [start, change, earlier] = [0, 2, 3].map(|i| DVec3::new(moment[0][i], moment[1][i], moment[2][i]));
            let [way, way_before] = [2, 3].map(|i| DVec3::new(phi[0][i], phi[1][i], phi[2][i]));
            let pull = if is_exact {
                self.factor * change.dot(way)
            } else {
                let by_tilts = DVec3::new(half[0].z, half[1].z, half[2].z);
                fold::product(&self.law(t), by_tilts).dot(by_tilts)
            };
            let damped = before.map_or(0.0, |(_, is_counted)| {
                let along = if is_counted { way } else { way + way_before };
                (self.factor - 1.0) * earlier.dot(along)
            });
            0.5 * (energy.y - energy.x) - start.dot(way) - pull - damped
        })
    }
}

/// The products with four vectors over the edges: [`fold::product`]'s, side by side.
#[inline(always)]
fn products(m: &OverEdges, v: &[DVec4; 3]) -> [DVec4; 3] {
    [
        v[0] * m[0] + v[1] * m[3] + v[2] * m[5],
        v[0] * m[3] + v[1] * m[1] + v[2] * m[4],
        v[0] * m[5] + v[1] * m[4] + v[2] * m[2],
    ]
}

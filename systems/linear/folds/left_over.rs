//! What a motion along the tangent leaves over of the energy of bending: for [`contain`](crate::systems::contain).

use super::{Folds, Part, Passes};
use crate::storage::NONE;
use crate::systems::kernels::fold;
use crate::systems::parallel;
use glam::DVec3;
use std::sync::PoisonError;

/// A triangle whose half angles are smaller \[rad\] stores next to nothing.
const LEVEL: f64 = 1e-3;

impl Folds {
    /// φ of a triangle for half angles.
    #[inline(always)]
    fn phi(&self, t: usize, half: impl Fn(usize) -> DVec3) -> DVec3 {
        half(t) + self.turned(t, |t| fold::product(&self.rest[t].law, half(t)))
    }

    /// Whether something holds for a triangle or one across.
    #[inline(always)]
    fn is_near(&self, t: usize, is: impl Fn(usize) -> bool) -> bool {
        is(t) || self.rest[t].across.iter().any(|&n| n != NONE && is(n as usize / 3))
    }

    /// The energy \[mJ\] of the angles last evaluated, but for what is next to nothing.
    pub fn stored(&self, partials: &mut Vec<f64>) -> f64 {
        parallel::sum(self.rest.len(), partials, |t| {
            if self.half[t].abs().max_element() < LEVEL {
                return 0.0;
            }
            let phi = self.phi(t, |t| self.half[t]);
            0.5 * phi.dot(fold::product(&self.rest[t].law, phi))
        })
    }

    /// E(x + u) − E(x) + f·u − u·K·u \[mJ\] with the tangent K as it is in the step, for a displacement `u` from where the angles
    /// were last evaluated, of the triangles that go far and those beside them. Where a fold goes on beyond 180° E is that of the
    /// fold told from its other side, as the forces of the next step are.
    pub fn left_over(
        &self,
        corners: &[[u32; 3]],
        x: &[DVec3],
        u: impl Fn(usize) -> DVec3 + Sync,
        goes_far: impl Fn(usize) -> bool + Sync,
        partials: &mut Vec<f64>,
    ) -> f64 {
        let mut passes = self.passes.lock().unwrap_or_else(PoisonError::into_inner);
        let Passes { bent, moved, is_far, .. } = &mut *passes;
        let count = self.rest.len();
        is_far.resize(count, false);
        bent.resize(count, Default::default());
        moved.resize(count, Default::default());
        parallel::for_rows(is_far, |t, is_far| *is_far = goes_far(t));
        let is_looked_at = |t: usize| self.is_near(t, |t| is_far[t]);
        // Normals at the end, and tilts.
        parallel::for_rows(bent, |t, bent| {
            let corners = corners[t].map(|v| v as usize);
            let u = corners.map(&u);
            let end = [x[corners[0]] + u[0], x[corners[1]] + u[1], x[corners[2]] + u[2]];
            *bent = [fold::normal(end, self.made_of[t].0.area), self.tilt[t].of(u)];
        });
        parallel::for_rows(moved, |t, moved| {
            if !self.is_near(t, is_looked_at) {
                return;
            }
            let mut half = DVec3::ZERO;
            for (e, &across) in self.rest[t].across.iter().enumerate() {
                if across != NONE {
                    let [from, to] = [e, (e + 1) % 3].map(|corner| corners[t][corner] as usize);
                    let edge = (x[to] + u(to)) - (x[from] + u(from));
                    let now = fold::angle(bent[t][0], bent[across as usize / 3][0], edge);
                    half[e] = 0.5 * fold::shorter_way(now - self.rest[t].angle[e]);
                }
            }
            *moved = [half, self.half_of_tilts(t, |t| bent[t][1])];
        });
        parallel::sum(count, partials, |t| {
            if !is_looked_at(t) {
                return 0.0;
            }
            let law = &self.rest[t].law;
            let [start, end] = [self.phi(t, |t| self.half[t]), self.phi(t, |t| moved[t][0])];
            let (change, by_tilts) = (self.phi(t, |t| moved[t][1]), moved[t][1]);
            let moment = fold::product(law, start);
            let stored = 0.5 * (end.dot(fold::product(law, end)) - start.dot(moment));
            let pull =
                if self.part[t] == Part::Whole { fold::product(law, by_tilts) * self.factor } else { DVec3::ZERO };
            stored - moment.dot(change) - pull.dot(by_tilts)
        })
    }
}

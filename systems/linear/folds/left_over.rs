//! What a motion along the tangent leaves over of the energy of bending: for [`contain`](crate::systems::contain).

use super::{Folds, Passes};
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

    /// E(x + u) − E(x) + f·u − u·K·u \[mJ\] with the tangent K of the step, exact or the majorant, for a displacement `u` from where the angles
    /// were last evaluated, less what damping by the way `before` in the step does along u, and along that way too where that is not
    /// counted yet. Where a fold goes on beyond 180° E is that of the fold told from its other side, as the forces of the next step are. For that
    /// `end`, x + u, has to have the bits that the next step starts from.
    pub fn left_over(
        &self,
        corners: &[[u32; 3]],
        (u, end): (impl Fn(usize) -> DVec3 + Sync, impl Fn(usize) -> DVec3 + Sync),
        before: Option<(&[DVec3], bool)>,
        is_exact: bool,
        partials: &mut Vec<f64>,
    ) -> f64 {
        let mut passes = self.passes.lock().unwrap_or_else(PoisonError::into_inner);
        let Passes { rows, bent, moved } = &mut *passes;
        let count = self.rest.len();
        bent.resize(count, Default::default());
        moved.resize(count, Default::default());
        rows.resize(count, DVec3::ZERO);
        // Normals at the end, and tilts.
        parallel::for_rows(bent, |t, bent| {
            let corners = corners[t].map(|v| v as usize);
            *bent = [fold::normal(corners.map(&end), self.made_of[t].0.area), self.tilt[t].of(corners.map(&u))];
        });
        if let Some((before, _)) = before {
            parallel::for_rows(rows, |t, tilts| *tilts = self.tilt[t].of(corners[t].map(|v| before[v as usize])));
        }
        parallel::for_rows(moved, |t, moved| {
            let mut half = DVec3::ZERO;
            for (e, &across) in self.rest[t].across.iter().enumerate() {
                if across != NONE {
                    let [from, to] = [e, (e + 1) % 3].map(|corner| corners[t][corner] as usize);
                    let now = fold::angle(bent[t][0], bent[across as usize / 3][0], end(to) - end(from));
                    half[e] = 0.5 * fold::shorter_way(now - self.rest[t].angle[e]);
                }
            }
            let earlier = if before.is_some() { self.half_of_tilts(t, |t| rows[t]) } else { DVec3::ZERO };
            *moved = [half, self.half_of_tilts(t, |t| bent[t][1]), earlier];
        });
        parallel::sum(count, partials, |t| {
            let law = &self.rest[t].law;
            let [start, end] = [self.phi(t, |t| self.half[t]), self.phi(t, |t| moved[t][0])];
            let (change, by_tilts) = (self.phi(t, |t| moved[t][1]), moved[t][1]);
            let moment = fold::product(law, start);
            let stored = 0.5 * (end.dot(fold::product(law, end)) - start.dot(moment));
            let pull = if is_exact {
                self.factor * fold::product(law, change).dot(change)
            } else {
                fold::product(&self.law(t), by_tilts).dot(by_tilts)
            };
            let damped = before.map_or(0.0, |(_, is_counted)| {
                let earlier = self.phi(t, |t| moved[t][2]);
                let along = if is_counted { change } else { change + earlier };
                (self.factor - 1.0) * fold::product(law, earlier).dot(along)
            });
            stored - moment.dot(change) - pull - damped
        })
    }
}

//! What a motion along the tangent leaves over of the energy of bending: for [`contain`](crate::systems::contain).

use super::{Folds, Passes};
use crate::storage::NONE;
use crate::systems::kernels::fold;
use crate::systems::parallel;
use glam::DVec3;
use std::sync::PoisonError;

/// A triangle whose half angles are smaller \[rad\] stores next to nothing.
const LEVEL: f64 = 1e-3;

/// Half angles from which on what a moment does along the change of tilts is no longer less than what the tangent sees \[rad\].
const SHARP: f64 = 0.25;

/// Half angles from which on a fold may go on beyond 180°, however little it tilts: what its triangle shares with other folds then
/// changes at once \[rad\].
const NEARLY_CLOSED: f64 = 1.5;

/// Rings: triangles that go far; those beside them, whose energies are told; and those whose angles and normals that takes.
const FAR: u8 = 1;
const BESIDE: u8 = 2;
const ANGLES: u8 = 3;
const NORMALS: u8 = 4;

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

    /// Whether a displacement tilts a triangle by more than so much, or a tenth of that where it is in a sharp fold,
    /// or at all where a fold is nearly closed.
    pub fn tilts_far(
        &self,
        corners: &[[u32; 3]],
        u: impl Fn(usize) -> DVec3 + Sync,
        far: f64,
        partials: &mut Vec<f64>,
    ) -> bool {
        let count = |t: usize| f64::from(u8::from(self.tilts_beyond(t, corners[t].map(|v| u(v as usize)), far)));
        parallel::sum(self.rest.len(), partials, count) > 0.0
    }

    #[inline(always)]
    fn tilts_beyond(&self, t: usize, u: [DVec3; 3], far: f64) -> bool {
        let far = match self.half[t].abs().max_element() {
            half if half > NEARLY_CLOSED => 0.0,
            half if half > SHARP => 0.1 * far,
            _ => far,
        };
        let tilt = self.tilt[t].of(u).abs();
        // What is no number is beyond.
        !(tilt.x <= far && tilt.y <= far && tilt.z <= far)
    }

    /// E(x + u) − E(x) + f·u − u·K·u \[mJ\] with the tangent K as it is in the step, for a displacement `u` from where the angles
    /// were last evaluated: of the triangles that go far or tilt by more than `far`, and of those beside them; zero without any. Where
    /// a fold goes on beyond 180° E is that of the fold told from its other side, as the forces of the next step are.
    pub fn left_over(
        &self,
        (corners, x): (&[[u32; 3]], &[DVec3]),
        u: impl Fn(usize) -> DVec3 + Sync,
        (goes_far, far): (impl Fn(usize, [DVec3; 3]) -> bool + Sync, f64),
        partials: &mut Vec<f64>,
    ) -> f64 {
        let mut passes = self.passes.lock().unwrap_or_else(PoisonError::into_inner);
        let Passes { bent, moved, ring, rings, .. } = &mut *passes;
        let count = self.rest.len();
        ring.resize(count, 0);
        bent.resize(count, Default::default());
        moved.resize(count, Default::default());
        parallel::for_rows(ring, |t, ring| {
            let u = corners[t].map(|v| u(v as usize));
            *ring = u8::from(goes_far(t, u) || self.tilts_beyond(t, u, far));
        });
        rings.clear();
        rings.extend((0..count as u32).filter(|&t| ring[t as usize] == FAR));
        if rings.is_empty() {
            return 0.0;
        }
        for to in [BESIDE, ANGLES, NORMALS] {
            for i in 0..rings.len() {
                for across in self.rest[rings[i] as usize].across {
                    if across != NONE && ring[across as usize / 3] == 0 {
                        ring[across as usize / 3] = to;
                        rings.push(across / 3);
                    }
                }
            }
        }
        let is_within = |t: usize, last: u8| (FAR..=last).contains(&ring[t]);
        // Normals at the end, and tilts.
        parallel::for_rows(bent, |t, bent| {
            if is_within(t, NORMALS) {
                let corners = corners[t].map(|v| v as usize);
                let u = corners.map(&u);
                let end = [x[corners[0]] + u[0], x[corners[1]] + u[1], x[corners[2]] + u[2]];
                *bent = [fold::normal(end, self.made_of[t].0.area), self.tilt[t].of(u)];
            }
        });
        parallel::for_rows(moved, |t, moved| {
            if !is_within(t, ANGLES) {
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
            if !is_within(t, BESIDE) {
                return 0.0;
            }
            let law = &self.rest[t].law;
            let [start, end] = [self.phi(t, |t| self.half[t]), self.phi(t, |t| moved[t][0])];
            let (change, by_tilts) = (self.phi(t, |t| moved[t][1]), moved[t][1]);
            let moment = fold::product(law, start);
            let stored = 0.5 * (end.dot(fold::product(law, end)) - start.dot(moment));
            let pull = fold::product(&self.law(t), by_tilts);
            stored - moment.dot(change) - pull.dot(by_tilts)
        })
    }
}

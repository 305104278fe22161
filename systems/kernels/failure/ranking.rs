//! The choice among the candidates: the best, by a stated rule where several are equal, and its runner-up.

use super::curve::Curve;
use super::region::Region;
use super::{Candidate, Decision, Origin, VALUE_TIE};
use crate::math::elementary;
use glam::DVec2;
use smallvec::SmallVec;
use std::f64::consts::PI;

/// cos 2°: directions nearer than that are the same decision.
const COS_SAME: f64 = 0.999_390_827_019_095_8;
/// Difference of d·p, and of angles \[rad\], that rounding may make and the tie rule must not see.
const INDISTINCT: f64 = 1e-9;
/// Four kinks, four smooth maxima with their opposites, four limits and p.
const CAPACITY: usize = 17;
/// The rotation by 1e-4 rad, larger than the slack of the admissible set.
const ROTATION_STEP: DVec2 = DVec2::new(1.0 - 5e-9, 1e-4);

#[derive(Clone, Copy)]
struct Entry {
    direction: DVec2,
    value: f64,
    origin: Origin,
    is_maximum: bool,
}

/// The admissible candidates, in the order they were offered.
pub(super) struct Ranking {
    fibre: DVec2,
    region: Region,
    entries: SmallVec<[Entry; CAPACITY]>,
}

impl Ranking {
    pub(super) fn new(fibre: DVec2, region: Region) -> Self {
        Self { fibre, region, entries: SmallVec::new() }
    }

    /// Offers `d` and, where they differ, `−d`; see [`Ranking::offer`].
    pub(super) fn offer_line(&mut self, d: DVec2, value: f64, origin: Origin, rises: [bool; 2]) {
        self.offer(d, value, origin, rises);
        if !self.region.is_everything() {
            self.offer(-d, value, origin, rises);
        }
    }

    /// Offers the limits of the admissible set and, where all directions are equal, the previous one.
    pub(super) fn offer_limits(&mut self, curve: &Curve) {
        for d in self.region.limits().into_iter().flatten() {
            let (across, along) = (self.fibre.perp_dot(d), self.fibre.dot(d));
            // At a kink the kink itself has been offered, with its exact δ.
            if (across * along).abs() > 0.5 * INDISTINCT && self.region.admits(d) {
                let (value, slope) = curve.value_and_slope(along, across);
                self.offer(d, value, Origin::Limit, [slope > 0.0, slope < 0.0]);
            }
        }
        if let (Some(p), true) = (self.region.previous, curve.is_constant()) {
            self.offer(p, curve.value_along_fibre(), curve.kink_origin(), [false; 2]);
        }
    }

    /// Adds `d` if it is admissible. `rises`: whether c grows from there counter-clockwise, and clockwise.
    pub(super) fn offer(&mut self, direction: DVec2, value: f64, origin: Origin, rises: [bool; 2]) {
        if value.is_nan() || self.entries.len() == CAPACITY || !self.region.admits(direction) {
            return;
        }
        let [left, right] = rises;
        let is_beaten_left = left && self.region.admits(ROTATION_STEP.rotate(direction));
        let is_beaten_right =
            right && self.region.admits(DVec2::new(ROTATION_STEP.x, -ROTATION_STEP.y).rotate(direction));
        let is_maximum = !is_beaten_left && !is_beaten_right;
        self.entries.push(Entry { direction, value, origin, is_maximum });
    }

    /// The decision, its values multiplied by `unit_of_value`.
    pub(super) fn decide(&self, unit_of_value: f64) -> Option<Decision> {
        let entries = &self.entries;
        // An earlier entry keeps its place against rounding: a kink against the smooth maximum that tends to it.
        let top = *entries
            .iter()
            .reduce(|best, e| if e.value > best.value + 4.0 * f64::EPSILON * best.value.abs() { e } else { best })?;
        let best = entries
            .iter()
            .filter(|e| e.is_maximum && e.value >= top.value - VALUE_TIE * top.value.abs() && self.is_other(e, &top))
            .fold(top, |best, e| if self.goes_first(e.direction, best.direction) { *e } else { best });
        let runner_up = entries
            .iter()
            .filter(|e| e.is_maximum && self.is_other(e, &best))
            .reduce(|first, e| if e.value > first.value { e } else { first });
        let candidate = |e: &Entry| {
            let value = e.value * unit_of_value;
            value.is_finite().then(|| self.candidate(e.direction, value))
        };
        Some(Decision { best: candidate(&best)?, origin: best.origin, runner_up: runner_up.and_then(candidate) })
    }

    fn is_other(&self, a: &Entry, b: &Entry) -> bool {
        let cosine = a.direction.dot(b.direction);
        (if self.region.is_everything() { cosine.abs() } else { cosine }) <= COS_SAME
    }

    /// The tie rule; it turns with the input and does not see the fibre's sign.
    fn goes_first(&self, a: DVec2, b: DVec2) -> bool {
        if let Some(p) = self.region.previous {
            let nearer = a.dot(p) - b.dot(p);
            if nearer.abs() > INDISTINCT {
                return nearer > 0.0;
            }
        }
        let turn = |d: DVec2| {
            let angle = elementary::atan2(self.fibre.perp_dot(d), self.fibre.dot(d)).rem_euclid(PI);
            if angle > PI - INDISTINCT { 0.0 } else { angle }
        };
        let earlier = turn(b) - turn(a);
        if earlier.abs() > INDISTINCT {
            return earlier > 0.0;
        }
        if let Some(p) = self.region.previous {
            return p.perp_dot(a) > p.perp_dot(b);
        }
        self.region.turn_into_sector(a) < self.region.turn_into_sector(b)
    }

    fn candidate(&self, direction: DVec2, value: f64) -> Candidate {
        let is_lower = direction.y < 0.0 || (direction.y == 0.0 && direction.x < 0.0);
        let direction = if self.region.is_everything() && is_lower { -direction } else { direction };
        Candidate { direction, value }
    }
}

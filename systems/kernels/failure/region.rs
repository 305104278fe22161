//! The admissible directions: the cone about the previous direction, cut with the sector of connected triangles.

use super::{Cone, Sector, unit};
use crate::math::elementary;
use glam::DVec2;
use std::f64::consts::{PI, TAU};

/// Slack of the tests, on d·p and on sector angles \[rad\]: in floating point cos 90° is 6e-17, not 0.
const REGION_SLACK: f64 = 1e-9;

/// The admissible set, ready to be asked.
#[derive(Clone, Copy)]
pub(super) struct Region {
    /// p, unit.
    pub previous: Option<DVec2>,
    smallest_cosine: f64,
    /// The two limits of a cone that excludes something.
    cone: [Option<DVec2>; 2],
    sector: Option<Limits>,
}

/// A sector that is not the whole circle.
#[derive(Clone, Copy)]
struct Limits {
    /// First angle \[rad\].
    from: f64,
    /// The first and the last direction, unit.
    ends: [DVec2; 2],
    /// A direction in the middle, of no particular length; of the complement where `is_wide`.
    middle: DVec2,
    /// Whether the sector is wider than half a turn.
    is_wide: bool,
}

impl Region {
    /// `None` where the cone or the sector is empty or not finite.
    pub(super) fn new(cone: Option<Cone>, sector: Option<Sector>) -> Option<Self> {
        let half_angle = cone.map_or(PI, |c| c.half_angle);
        if !(half_angle >= 0.0 && half_angle.is_finite()) {
            return None;
        }
        let turn = elementary::unit_at(half_angle.min(PI));
        let previous = match cone {
            Some(c) => Some(unit(c.previous)?),
            None => None,
        };
        let sector = match sector.map(|s| (s.from, s.to - s.from)) {
            Some((from, width)) if !(from.is_finite() && width >= 0.0 && width.is_finite()) => return None,
            Some((from, width)) if width < TAU - REGION_SLACK => Some(Limits::new(from, width)),
            _ => None,
        };
        let bounding = previous.filter(|_| half_angle < PI);
        let cone = [turn, DVec2::new(turn.x, -turn.y)].map(|turn| Some(turn.rotate(bounding?)));
        Some(Self { previous, smallest_cosine: turn.x - REGION_SLACK, cone, sector })
    }

    /// Whether nothing is excluded and nothing tells `d` from `−d`.
    pub(super) fn is_everything(&self) -> bool {
        self.previous.is_none() && self.sector.is_none()
    }

    /// Whether the unit direction `d` is admissible.
    pub(super) fn admits(&self, d: DVec2) -> bool {
        self.previous.is_none_or(|p| d.dot(p) >= self.smallest_cosine) && self.sector.is_none_or(|s| s.holds(d))
    }

    /// Angle \[rad\] from the sector's first limit counter-clockwise to `d`.
    pub(super) fn turn_into_sector(&self, d: DVec2) -> Option<f64> {
        let turn = (elementary::angle_of(d) - self.sector?.from).rem_euclid(TAU);
        Some(if turn >= TAU - REGION_SLACK { 0.0 } else { turn })
    }

    /// The limits of the cone and of the sector; each may lie outside the other.
    pub(super) fn limits(&self) -> [Option<DVec2>; 4] {
        let [left, right] = self.cone;
        let [first, last] = [0, 1].map(|i| self.sector.map(|s| s.ends[i]));
        [left, right, first, last]
    }
}

impl Limits {
    fn new(from: f64, width: f64) -> Self {
        let (first, last) = (elementary::unit_at(from), elementary::unit_at(from + width));
        let is_wide = width > PI;
        let [a, b] = if is_wide { [last, first] } else { [first, last] };
        // Both parts point to the middle; the first vanishes at half a turn, the second at none.
        let middle = a + b + a.perp() - b.perp();
        Self { from, ends: [first, last], middle, is_wide }
    }

    fn holds(&self, d: DVec2) -> bool {
        let [first, last] = self.ends;
        if self.is_wide {
            // Not further than the slack inside the complement, which is narrow.
            !(last.perp_dot(d) > REGION_SLACK && d.perp_dot(first) > REGION_SLACK && d.dot(self.middle) > 0.0)
        } else {
            first.perp_dot(d) >= -REGION_SLACK
                && d.perp_dot(last) >= -REGION_SLACK
                && d.dot(self.middle) >= -4.0 * REGION_SLACK
        }
    }
}

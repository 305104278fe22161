//! The admissible directions: the cone about the previous direction, cut with the sector of connected triangles.

use super::{Cone, Sector, unit};
use glam::DVec2;
use std::f64::consts::{PI, TAU};

/// Slack of the tests, on d·p and on sector angles \[rad\]: in floating point cos 90° is 6e-17, not 0.
const SLACK: f64 = 1e-9;

/// The admissible set, ready to be asked.
#[derive(Clone, Copy)]
pub(super) struct Region {
    /// p, unit.
    pub previous: Option<DVec2>,
    /// θ_P \[rad\], at most π.
    half_angle: f64,
    smallest_cosine: f64,
    /// First angle and width \[rad\] of a sector that is not the whole circle.
    sector: Option<(f64, f64)>,
}

impl Region {
    /// `None` where the cone or the sector is empty or not finite.
    pub fn new(cone: Option<Cone>, sector: Option<Sector>) -> Option<Self> {
        let half_angle = cone.map_or(PI, |c| c.half_angle);
        if !(half_angle >= 0.0 && half_angle.is_finite()) {
            return None;
        }
        let half_angle = half_angle.min(PI);
        let previous = match cone {
            Some(c) => Some(unit(c.previous)?),
            None => None,
        };
        let sector = match sector.map(|s| (s.from, s.to - s.from)) {
            Some((from, width)) if !(from.is_finite() && width >= 0.0 && width.is_finite()) => return None,
            Some((from, width)) if width < TAU - SLACK => Some((from, width)),
            _ => None,
        };
        Some(Self { previous, half_angle, smallest_cosine: half_angle.cos() - SLACK, sector })
    }

    /// Whether nothing is excluded and nothing tells `d` from `−d`.
    pub fn is_everything(&self) -> bool {
        self.previous.is_none() && self.sector.is_none()
    }

    /// Whether the unit direction `d` is admissible.
    pub fn admits(&self, d: DVec2) -> bool {
        self.previous.is_none_or(|p| d.dot(p) >= self.smallest_cosine)
            && self.turn_into_sector(d).is_none_or(|(turn, width)| turn <= width + SLACK)
    }

    /// Angle \[rad\] from the sector's first limit counter-clockwise to `d`, and the sector's width.
    pub fn turn_into_sector(&self, d: DVec2) -> Option<(f64, f64)> {
        let (from, width) = self.sector?;
        let turn = (d.to_angle() - from).rem_euclid(TAU);
        Some((if turn >= TAU - SLACK { 0.0 } else { turn }, width))
    }

    /// The limits of the cone and of the sector; each may lie outside the other.
    pub fn limits(&self) -> [Option<DVec2>; 4] {
        let cone = |angle: f64| {
            let p = self.previous.filter(|_| self.half_angle < PI)?;
            Some(DVec2::from_angle(angle).rotate(p))
        };
        let sector = |share: f64| self.sector.map(|(from, width)| DVec2::from_angle(from + share * width));
        [cone(self.half_angle), cone(-self.half_angle), sector(0.0), sector(1.0)]
    }
}

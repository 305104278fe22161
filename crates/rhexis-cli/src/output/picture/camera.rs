//! From space to the picture: parallel projection, so that lengths across the view are to scale; from a point where that is asked for.

use super::View;
use glam::{DVec2, DVec3};

/// A rectangle of the picture \[px\].
#[derive(Clone, Copy)]
pub(super) struct Area {
    pub low: DVec2,
    pub high: DVec2,
}

impl Area {
    pub(super) fn size(self) -> DVec2 {
        self.high - self.low
    }

    pub(super) fn middle(self) -> DVec2 {
        0.5 * (self.low + self.high)
    }

    pub(super) fn contains(self, p: DVec2) -> bool {
        p.cmpge(self.low).all() && p.cmple(self.high).all()
    }

    /// The same, to what rounding does to a point on the frame.
    pub(super) fn contains_nearly(self, p: DVec2) -> bool {
        Self { low: self.low - 0.5, high: self.high + 0.5 }.contains(p)
    }

    pub(super) fn overlaps(self, points: &[DVec2]) -> bool {
        let low = points.iter().copied().fold(DVec2::INFINITY, DVec2::min);
        let high = points.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
        low.cmple(self.high).all() && high.cmpge(self.low).all()
    }
}

/// The eye is so many times as far from what it sees as that reaches from its middle.
const EYE: f64 = 3.0;
/// What comes nearer to the eye than this part of its distance is drawn as if it were there.
const NEAREST: f64 = 0.05;

/// Projection onto a plane.
#[derive(Clone, Copy)]
pub(super) struct Camera {
    right: DVec3,
    up: DVec3,
    /// Unit direction towards the viewer.
    pub toward: DVec3,
    /// The point of space shown at `middle`.
    target: DVec3,
    middle: DVec2,
    /// Pixels per \[mm\], at the target's depth.
    pub scale: f64,
    /// From the eye to the target's plane \[mm\]; infinite for a parallel projection.
    distance: f64,
}

impl Camera {
    /// The camera that shows all `points` in `area`; `None` if they have no extent or too large a one.
    pub(super) fn fitting(view: View, points: impl Iterator<Item = DVec3> + Clone, area: Area) -> Option<Self> {
        let mut camera = Self {
            middle: area.middle(),
            ..Self::facing(toward_viewer(view), DVec3::Y, DVec3::ZERO, area.middle(), 1.0)
        };
        if let View::Perspective { .. } = view {
            camera.stand_off(points.clone());
        }
        let flat = points.map(|x| camera.project(x) - camera.middle);
        let low = flat.clone().fold(DVec2::INFINITY, DVec2::min);
        let high = flat.fold(DVec2::NEG_INFINITY, DVec2::max);
        let size = high - low;
        camera.scale = (area.size() / size.max(DVec2::splat(f64::MIN_POSITIVE))).min_element();
        camera.middle = area.middle() - camera.scale * (low + 0.5 * size);
        (size.max_element() > 0.0 && camera.scale.is_finite() && camera.scale > 0.0 && camera.target.is_finite())
            .then_some(camera)
    }

    /// Places the eye before the middle of the points.
    fn stand_off(&mut self, points: impl Iterator<Item = DVec3> + Clone) {
        let low = points.clone().fold(DVec3::INFINITY, DVec3::min);
        let high = points.clone().fold(DVec3::NEG_INFINITY, DVec3::max);
        let target = 0.5 * (low + high);
        let reach = points.map(|x| x.distance(target)).fold(0.0, f64::max);
        if target.is_finite() && reach > 0.0 {
            (self.target, self.distance) = (target, EYE * reach);
        }
    }

    /// Width and height that points take up in a view \[mm\].
    pub(super) fn extent(view: View, points: impl Iterator<Item = DVec3> + Clone) -> DVec2 {
        let camera = Self::facing(toward_viewer(view), DVec3::Y, DVec3::ZERO, DVec2::ZERO, 1.0);
        let flat = points.map(|x| camera.along(x));
        flat.clone().fold(DVec2::NEG_INFINITY, DVec2::max) - flat.fold(DVec2::INFINITY, DVec2::min)
    }

    /// Looks along `-toward` at `target`; `up` of the picture is `upward` or, should that be hidden, +y or +z.
    pub(super) fn facing(toward: DVec3, upward: DVec3, target: DVec3, middle: DVec2, scale: f64) -> Self {
        let toward = toward.try_normalize().unwrap_or(DVec3::Z);
        let lying = |v: DVec3| v - v.dot(toward) * toward;
        let hint = if toward.z.abs() > 0.999 { upward } else { DVec3::Z };
        let up = [hint, upward, DVec3::Y, DVec3::Z]
            .into_iter()
            .map(lying)
            .find(|v| v.length_squared() > 1e-6)
            .map_or(DVec3::Y, DVec3::normalize_or_zero);
        Self { right: up.cross(toward), up, toward, target, middle, scale, distance: f64::INFINITY }
    }

    /// Like this camera, but looking along a normal of the surface, enlarged.
    pub(super) fn closeup(&self, normal: DVec3, target: DVec3, middle: DVec2, scale: f64) -> Self {
        let up = self.up - self.up.dot(normal) * normal;
        let up = up.try_normalize().unwrap_or_else(|| normal.cross(self.right).normalize_or_zero());
        Self { right: up.cross(normal), up, toward: normal, target, middle, scale, distance: f64::INFINITY }
    }

    pub(super) fn project(&self, x: DVec3) -> DVec2 {
        let d = x - self.target;
        let nearer = (1.0 - d.dot(self.toward) / self.distance).max(NEAREST);
        self.middle + self.along(d) / nearer
    }

    /// A vector in the target's plane as it is seen \[px\].
    pub(super) fn along(&self, v: DVec3) -> DVec2 {
        self.scale * DVec2::new(v.dot(self.right), -v.dot(self.up))
    }

    /// Grows towards the viewer \[mm\].
    pub(super) fn depth(&self, x: DVec3) -> f64 {
        (x - self.target).dot(self.toward)
    }

    /// A light from the upper left of the viewer.
    pub(super) fn light(&self) -> DVec3 {
        (self.toward - 0.5 * self.right + 0.6 * self.up).normalize_or_zero()
    }
}

fn toward_viewer(view: View) -> DVec3 {
    match view {
        View::Along { direction } if direction.is_finite() && direction != DVec3::ZERO => direction,
        View::Oblique { azimuth, elevation } | View::Perspective { azimuth, elevation }
            if azimuth.is_finite() && elevation.is_finite() =>
        {
            let (azimuth, elevation) = (azimuth.to_radians(), elevation.clamp(-90.0, 90.0).to_radians());
            DVec3::new(elevation.cos() * azimuth.cos(), elevation.cos() * azimuth.sin(), elevation.sin())
        }
        _ => DVec3::Z,
    }
}

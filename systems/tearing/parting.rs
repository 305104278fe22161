//! The search for tissue that fails without a tip: stretched beyond what it bears.

use super::Surface;
use crate::components::Parting;
use crate::math::elementary;
use glam::{DVec2, DVec3};
use std::f64::consts::FRAC_PI_2;

/// The triangle that is farthest beyond the ultimate stretch, of equal ones the lowest row, but for those with a corner that is left to
/// a tip, hold or grip.
pub fn parting(surface: &Surface, ultimate: f64, is_taken: &dyn Fn(u32) -> bool) -> Option<Parting> {
    let mut best: Option<Parting> = None;
    for t in 0..surface.triangles.len() {
        let found =
            beyond_stretch(surface, t, ultimate).filter(|found| best.is_none_or(|best| found.value > best.value));
        let is_left = |_: &Parting| !surface.triangles.corners[t].iter().any(|&vertex| is_taken(vertex));
        best = found.filter(is_left).or(best);
    }
    best
}

/// A triangle whose greatest principal stretch, one plus the Biot strain from the stress-free state, exceeds the ultimate one.
fn beyond_stretch(surface: &Surface, t: usize, ultimate: f64) -> Option<Parting> {
    let strain = surface.state(t).polar.stretch - surface.unstretched;
    let value = (1.0 + strain.principal_values().0) / ultimate;
    if !(value > 1.0) {
        return None;
    }
    let direction = in_space(surface, t, elementary::unit_at(strain.principal_angle() + FRAC_PI_2));
    Some(Parting { triangle: t as u32, fibre: surface.triangles.fibre[t], direction, value, at: centroid(surface, t) })
}

fn corners(surface: &Surface, t: usize) -> [DVec3; 3] {
    surface.triangles.corners[t].map(|v| surface.vertices.rest_position[v as usize])
}

fn centroid(surface: &Surface, t: usize) -> DVec3 {
    let x = corners(surface, t);
    (x[0] + x[1] + x[2]) / 3.0
}

/// A direction of a triangle's frame (fibre, transverse) in the rest shape.
fn in_space(surface: &Surface, t: usize, direction: DVec2) -> DVec3 {
    let (x, fibre) = (corners(surface, t), surface.triangles.fibre[t]);
    let normal = (x[1] - x[0]).cross(x[2] - x[0]).normalize_or_zero();
    (fibre * direction.x + normal.cross(fibre) * direction.y).normalize_or_zero()
}

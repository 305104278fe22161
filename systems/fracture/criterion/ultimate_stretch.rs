//! Tissue that fails where no tip leads, for it is stretched too far.

use crate::components::{LigamentFailure, PartedBy, TearSite};
use crate::math::elementary;
use crate::systems::fracture::Surface;
use glam::{DVec2, DVec3};
use std::f64::consts::FRAC_PI_2;

/// The triangle stretched farthest beyond the ultimate stretch, of those without a held vertex; the lowest row of equal ones. Where one
/// is at a vertex of a tip, that tip goes on, or openings would stand side by side and nothing would part.
pub(crate) fn beyond_stretch(
    surface: &Surface,
    ultimate: f64,
    tips: &[u32],
    is_held: &dyn Fn(u32) -> bool,
) -> Option<LigamentFailure> {
    let (mut best, mut ahead): (Option<LigamentFailure>, Option<LigamentFailure>) = (None, None);
    let is_worse =
        |found: &LigamentFailure, best: &Option<LigamentFailure>| found.value > best.map_or(1.0, |best| best.value);
    for t in 0..surface.triangles.len() {
        let corners = surface.triangles.corners[t];
        let Some(found) = of_triangle(surface, t, ultimate) else { continue };
        if corners.iter().any(|&corner| is_held(corner)) {
            continue;
        }
        match corners.iter().find(|corner| tips.contains(corner)) {
            None if is_worse(&found, &best) => best = Some(found),
            Some(&tip) if is_worse(&found, &ahead) => {
                let way = found.ends[0] - surface.vertices.rest_position[tip as usize];
                let direction = found.direction * way.dot(found.direction).signum();
                ahead = Some(LigamentFailure { site: TearSite::Vertex(tip), direction, ..found });
            }
            _ => {}
        }
    }
    ahead.or(best)
}

/// A triangle whose greatest principal stretch, one plus the Biot strain from the stress-free state, exceeds the ultimate one.
fn of_triangle(surface: &Surface, t: usize, ultimate: f64) -> Option<LigamentFailure> {
    let strain = surface.state(t).polar.stretch - surface.triangles.unstretched(t, surface.unstretched);
    let value = (1.0 + strain.principal_values().0) / ultimate;
    if !(value > 1.0) {
        return None;
    }
    let direction = in_space(surface, t, elementary::unit_at(strain.principal_angle() + FRAC_PI_2));
    Some(LigamentFailure {
        site: TearSite::Triangle(t as u32),
        fibre: surface.triangles.fibre[t],
        direction,
        value,
        ends: [centroid(surface, t); 2],
        by: PartedBy::Stretch,
    })
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

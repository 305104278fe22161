//! Finding the point of the rest surface nearest to a point in space.

use crate::math::nearest_in_triangle;
use crate::storage::measure::rest_corners;
use crate::systems::fracture::Cutter;
use glam::DVec3;

/// A point of the surface.
#[derive(Clone, Copy, Debug)]
pub(in crate::systems::fracture) struct SurfacePoint {
    pub triangle: u32,
    pub weights: [f64; 3],
}

impl Cutter<'_, '_> {
    /// The nearest point; of several equally near ones that in the lowest row. Every triangle is looked at: a blade falls
    /// rarely.
    pub(in crate::systems::fracture) fn nearest(&self, point: DVec3) -> Option<SurfacePoint> {
        let mut best: Option<(f64, SurfacePoint)> = None;
        for (row, &corners) in self.mesh.triangles.corners.iter().enumerate() {
            let x = rest_corners(self.mesh.vertices, corners);
            let weights = nearest_in_triangle(x, point);
            let distance = (x[0] * weights[0] + x[1] * weights[1] + x[2] * weights[2]).distance_squared(point);
            if distance.is_finite() && best.is_none_or(|(least, _)| distance < least) {
                best = Some((distance, SurfacePoint { triangle: row as u32, weights }));
            }
        }
        best.map(|(_, at)| at)
    }
}

/// Distance \[mm\] of a point from the nearest point of a triangle.
pub fn distance_to_triangle(x: [DVec3; 3], point: DVec3) -> f64 {
    let weights = nearest_in_triangle(x, point);
    (x[0] * weights[0] + x[1] * weights[1] + x[2] * weights[2]).distance(point)
}

//! The shortest edges that a tear may leave.
//!
//! Angles alone set no limit: a tip that goes on among the lips of earlier tears leaves triangles of good shape and any size. One that is a
//! thousandth of its neighbours turns hundreds of times in a step that they resolve, and no linear solve says where it goes.

use crate::storage::EditRecord;
use crate::systems::fracture::{Cutter, Quality};

/// The shortest edge that a tear makes, over the averaging radius.
const LEAST_EDGE: f64 = 0.03;

impl Quality {
    /// The default with the least edge of tears whose averaging radius \[mm\] this is.
    pub fn of_radius(radius: f64) -> Self {
        Self { least_edge: LEAST_EDGE * radius, ..Self::default() }
    }
}

impl Cutter<'_, '_> {
    /// The least length \[mm\] of edges that an edit of these triangles may leave.
    pub(in crate::systems::fracture) fn least_edge(&self, triangles: impl Iterator<Item = u32>) -> f64 {
        if self.quality.least_edge == 0.0 { 0.0 } else { self.quality.least_edge.min(self.shortest(triangles)) }
    }

    /// Whether the records from `start` on leave a triangle with an edge shorter than `least` \[mm\].
    pub(in crate::systems::fracture) fn leaves_shorter_edges(&self, start: usize, least: f64) -> bool {
        // A collapse may have taken rows away.
        let count = self.mesh.triangles.len() as u32;
        let shaped = self.shaped(start).flat_map(EditRecord::shaped_triangles).filter(|&row| row < count);
        least > 0.0 && self.shortest(shaped) < least
    }

    /// The shortest rest edge \[mm\] of some triangles; infinite where there are none.
    fn shortest(&self, triangles: impl Iterator<Item = u32>) -> f64 {
        let edge = |t: u32| {
            let [a, b, c] = self.rest_of(t);
            a.distance_squared(b).min(b.distance_squared(c)).min(c.distance_squared(a))
        };
        triangles.map(edge).fold(f64::INFINITY, f64::min).sqrt()
    }
}

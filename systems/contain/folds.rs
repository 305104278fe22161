//! What bending adds to what a step leaves over.

use super::{Solved, partly, uncrushed};
use crate::systems::kernels::membrane;
use glam::DVec3;

impl Solved<'_> {
    /// What the folds leave over by this `part` of the answer \[mJ\]: of those of the triangles that go far,
    /// or tilt far: by so much that a normal turns like that of a triangle that goes far.
    pub(super) fn bent(&self, part: f64, partials: &mut Vec<f64>) -> f64 {
        let Some(folds) = self.operator.folds else { return 0.0 };
        let (vertices, triangles, frames) = (self.operator.vertices, self.operator.triangles, self.operator.frames);
        let u = |v: usize| partly(self.increment.delta[v], self.free[v], part);
        let goes_far = |t: usize, u: [DVec3; 3]| {
            let (d1, d2) = membrane::gradient(u, &triangles.rest[t]);
            let change_sq = d1.length_squared() + d2.length_squared();
            let least = self.far * uncrushed(&frames.state[t], frames.is_planar);
            !(change_sq <= least * least)
        };
        folds.left_over((&triangles.corners, &vertices.position), u, (goes_far, self.far), partials)
    }
}

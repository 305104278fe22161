//! What bending adds to what a step leaves over.

use super::{Solved, partly};

impl Solved<'_> {
    /// What the folds leave over by this `part` of the answer \[mJ\].
    pub(super) fn bent(&self, part: f64, partials: &mut Vec<f64>) -> f64 {
        let Some(folds) = self.operator.folds else { return 0.0 };
        let (vertices, triangles) = (self.operator.vertices, self.operator.triangles);
        let before = self.is_damped_before().then_some((self.increment.displacement.as_slice(), self.is_counted));
        let u = |v: usize| partly(self.increment.delta[v], self.free[v], part);
        folds.left_over((&triangles.corners, &vertices.position), u, before, partials)
    }
}

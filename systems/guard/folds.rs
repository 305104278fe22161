//! What bending adds to what a step leaves over.

use super::solved::Solved;
use crate::components::{Increment, partly};
use crate::settings::Tangent;

impl Solved<'_> {
    /// What the folds leave over by this `part` of the answer \[mJ\].
    pub(super) fn bent(&self, part: f64, partials: &mut Vec<f64>) -> f64 {
        let Some(folds) = self.operator.folds else { return 0.0 };
        let Increment { start, displacement, .. } = self.increment;
        let before = self.is_damped_before.then_some((displacement.as_slice(), self.is_counted));
        let motion = |v: usize| {
            let u = partly(self.delta[v], self.free[v], part);
            [u, start[v] + (displacement[v] + u)]
        };
        let is_exact = self.operator.tangent == Tangent::Exact;
        folds.left_over(&self.operator.triangles.corners, (start.len(), motion), before, is_exact, partials)
    }
}

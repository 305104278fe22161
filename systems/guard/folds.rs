//! Spurious energy of bending.

use super::solved::{Solved, Sums};
use crate::components::Increment;
use crate::settings::Tangent;

impl Solved<'_> {
    /// Spurious energy of bending by this `fraction` of the answer \[mJ\].
    pub(super) fn bent(&self, fraction: f64, sums: &mut Sums<'_>) -> f64 {
        let Some(folds) = self.operator.folds else { return 0.0 };
        let Increment { start, displacement, .. } = self.increment;
        let before = self.is_damped_before.then_some((displacement.as_slice(), self.is_counted));
        let motion = |v: usize| {
            let u = self.delta[v] * fraction;
            [u, start[v] + (displacement[v] + u)]
        };
        let is_exact = self.operator.tangent == Tangent::Exact;
        let Sums { partials, passes, .. } = sums;
        let corners = &self.operator.triangles.corners;
        folds.spurious_energy(corners, (start.len(), motion), before, is_exact, (partials, passes))
    }
}

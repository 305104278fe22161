//! What bending adds to what a step leaves over.

use super::{Solved, partly};
use crate::components::Increment;
use crate::settings::Tangent;
use glam::DVec3;

impl Solved<'_> {
    /// What the folds leave over by this `part` of the answer \[mJ\].
    pub(super) fn bent(&self, part: f64, partials: &mut Vec<f64>) -> f64 {
        let Some(folds) = self.operator.folds else { return 0.0 };
        let triangles = self.operator.triangles;
        let Increment { start, displacement, delta, .. } = self.increment;
        let before = self.is_damped_before.then_some((displacement.as_slice(), self.is_counted));
        let u = |v: usize| partly(delta[v], self.free[v], part);
        let end = |v: usize| start[v] + (displacement[v] + u(v));
        let more = folds.left_over(&triangles.corners, (u, end), before, partials);
        if self.operator.tangent != Tangent::Exact {
            return more;
        }
        // That is with the majorant of the tangent which has been solved with.
        let u: Vec<DVec3> = (0..delta.len()).map(u).collect();
        let pull = |is_exact| {
            let mut forces = vec![DVec3::ZERO; u.len()];
            folds.add_product(&triangles.corners, self.operator.topology, &u, is_exact, &mut forces);
            forces.iter().zip(&u).map(|(force, u)| force.dot(*u)).sum::<f64>()
        };
        more + pull(false) - pull(true)
    }
}

//! The fraction of a further solve's answer that lowers the incremental potential.
//!
//! A = K + D/dt + M/dt² + … is the matrix of a solve that starts where an earlier one of the step has led. Its answer d obeys
//! A·d = r, and −r is the gradient of the incremental potential Φ. Along a fraction p of it
//!
//! Φ(x + p·d) − Φ(x) = E(x + p·d) − E(x) + p·f·d − ½·p²·d·K·d − (p − ½·p²)·d·A·d.
//!
//! The energy guard's sum has the first terms already, with −p²·d·(K + D/dt)·d in place of −½·p²·d·K·d. The work of damping by
//! earlier solves of the step along the way is subtracted there. A is positive definite, so that a small fraction always lowers Φ.

use super::solved::{Solved, Sums};
use crate::systems::parallel;
use crate::systems::solver::{Operator, ProductMemory};
use glam::DVec3;

/// Smallest fraction.
const LEAST: f64 = 1.0 / 64.0;

/// The part of what the slope promises by which Φ has to fall (Armijo 1966).
const PROMISED: f64 = 1e-4;

/// A fraction of a solve's answer along free axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fraction {
    /// In (0, 1].
    pub fraction: f64,
    /// Energy \[mJ\] that going so far creates, without the work of the residual.
    pub created: f64,
}

impl Solved<'_> {
    /// The largest of 1, ½, … 1/64 of the answer that lowers the incremental potential; the last is taken in any case. `full` is the operator of the solve, with loads and
    /// all.
    pub(super) fn fraction(&self, full: &Operator, sums: &mut Sums<'_>) -> Fraction {
        let without_masses = Operator { external: None, inertia: 0.0, ..*full };
        let undamped = Operator { viscosity: 0.0, ..without_masses };
        let (mut corner, mut product) = (Vec::new(), vec![DVec3::ZERO; self.delta.len()]);
        let mut form = |operator: &Operator| {
            let mut memory = ProductMemory { corner: &mut corner, passes: &mut *sums.passes };
            operator.apply(self.delta, self.free, &mut memory, &mut product, sums.partials)
        };
        let (whole, damped, elastic) = (form(full), form(&without_masses), form(&undamped));
        let mut fraction = 1.0;
        loop {
            let strained = self.strained(fraction, sums);
            let dissipated = parallel::sum(full.triangles.len(), sums.partials, |t| self.damped_along(t, fraction));
            let potential = strained + dissipated + fraction * fraction * (damped - 0.5 * elastic)
                - (fraction - 0.5 * fraction * fraction) * whole;
            if potential <= -PROMISED * fraction * whole || fraction <= LEAST {
                let created = strained - self.dissipated(fraction, sums.partials) - fraction * (1.0 - fraction) * whole;
                return Fraction { fraction, created };
            }
            fraction *= 0.5;
        }
    }
}

//! The fraction of a way that lowers the incremental potential: of a Newton correction or a corrector solve, or of a local relaxation.
//!
//! A = K + D/dt + M/dt² + … is the matrix of a solve that starts where an earlier one of the step has led. Its answer obeys A·d
//! = r up to its residual, and −r is the gradient of the incremental potential Φ. Along a fraction p of a way u
//!
//! Φ(x + p·u) − Φ(x) = E(x + p·u) − E(x) + p·f·u − ½·p²·u·K·u − p·r·u + ½·p²·u·A·u.
//!
//! The energy guard's sum has the first terms already, with −p²·u·(K + D/dt)·u in place of −½·p²·u·K·u. The work of damping by
//! earlier solves of the step along the way is subtracted there. A is positive definite, so that a small fraction of the answer always lowers
//! Φ. So does one of a way that [vertices](super::local_relaxation) have found whose slope r·u is positive.
//!
//! The whole answer needs no product: r·u is u·A·u + s·u with the residual s that the solve has left, and A is K + D/dt and, on the diagonal,
//! masses and supports, M/dt² + B:
//!
//! Φ(x + u) − Φ(x) = [E(x + u) − E(x) + f·u − u·(K + D/dt)·u] + ½·u·(D/dt)·u − ½·u·(M/dt² + B)·u − s·u.

use super::solved::{Solved, Strained, Sums};
use crate::systems::parallel;
use crate::systems::solver::{Operator, ProductMemory};
use glam::DVec3;

/// Smallest fraction.
const LEAST_SEARCHED: f64 = 1.0 / 64.0;

/// The part of the decrease promised by the slope by which Φ has to fall (Armijo 1966).
const ARMIJO_OF_WAY: f64 = 1e-4;

/// A fraction of a way along free axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fraction {
    /// Fraction of the way, in (0, 1].
    pub fraction: f64,
    /// Energy \[mJ\] that going so far creates.
    pub created: f64,
    /// Change of the incremental potential \[mJ\].
    pub potential: f64,
}

impl Solved<'_> {
    /// Leaves −∇Φ \[N\] along free axes at the start of the solve in `sums.pull`. `full` is its operator, with external stiffness.
    pub(super) fn find_pull(&self, full: &Operator, sums: &mut Sums<'_>) {
        let Sums { partials, passes, corner, pull, .. } = sums;
        pull.resize(self.delta.len(), DVec3::ZERO);
        full.apply(self.delta, self.free, &mut ProductMemory { corner, passes }, pull, partials);
        parallel::for_rows(pull, |v, pull| *pull = (*pull + self.residual[v]) * self.free[v]);
    }

    /// Change of the incremental potential \[mJ\] along the whole answer, by the energies of its triangles and the work of the residual.
    pub(super) fn potential(
        &self,
        full: &Operator,
        (whole, residual_work): (&Strained, f64),
        partials: &mut Vec<f64>,
    ) -> f64 {
        let supported = parallel::sum(self.delta.len(), partials, |v| {
            let u = self.delta[v] * self.free[v];
            u.dot(full.vertex_block(v) * u)
        });
        let swept = full.volume.map_or(0.0, |volume| volume.swept(self.delta));
        let pressed = full.volume_pressure(self.delta) * swept;
        whole.spurious + whole.damped - 0.5 * (supported + pressed) + residual_work
    }

    /// The largest of 1, ½, … 1/64 of the way that lowers the incremental potential, whose slope is that of [`find_pull`](Self::find_pull); the
    /// last is taken in any case.
    pub(super) fn fraction(&self, full: &Operator, sums: &mut Sums<'_>) -> Fraction {
        let without_masses = Operator { external: None, volume: None, inertia: 0.0, ..*full };
        let undamped = Operator { viscosity: 0.0, ..without_masses };
        let Sums { partials, passes, corner, pull, product, .. } = &mut *sums;
        product.resize(self.delta.len(), DVec3::ZERO);
        let mut form = |operator: &Operator| {
            operator.apply(self.delta, self.free, &mut ProductMemory { corner, passes }, product, partials)
        };
        let (whole, damped, elastic) = (form(full), form(&without_masses), form(&undamped));
        let slope = parallel::sum(pull.len(), partials, |v| pull[v].dot(self.delta[v]));
        let mut fraction = 1.0;
        loop {
            let strained = self.strained(fraction, sums);
            let dissipated = parallel::sum(full.triangles.len(), sums.partials, |t| self.damped_along(t, fraction));
            let potential =
                strained + dissipated + fraction * fraction * (damped - 0.5 * elastic + 0.5 * whole) - fraction * slope;
            if potential < 0.0 && potential <= -ARMIJO_OF_WAY * fraction * slope || fraction <= LEAST_SEARCHED {
                let created =
                    strained - self.dissipated(fraction, sums.partials) - fraction * (slope - fraction * whole);
                return Fraction { fraction, created, potential };
            }
            fraction *= 0.5;
        }
    }
}

//! Levenberg–Marquardt damping of Newton corrections (Levenberg 1944; Marquardt 1963): more inertia than the step has, after a
//! correction that led astray.
//!
//! It is inertia that holds slack tissue, of which the tangent says nothing. A body that takes less than its answer gets masses that are
//! four times as large. The shortfall against the equations of the step stays in the residual, whose work the energy guard
//! counts.

use crate::components::{Increment, SolverScratch};
use crate::math::elementary;
use crate::settings::ablation::Part;
use crate::storage::Vertices;
use crate::systems::{StepContext, parallel};

/// Fraction of the answer below which the damping rises by two levels.
const SMALL_FRACTION: f64 = 0.2;

/// Largest damping level: the inertia of a step a thousandth as long.
const MOST_QUADRUPLINGS: u32 = 10;

/// Inertia \[1/ms²\] that is added to that of the step. The first solve of a chain is not damped.
pub(super) fn inertia(step: &StepContext, scratch: &mut SolverScratch) -> f64 {
    if !step.is_correction || !step.has(Part::LmDamping) {
        scratch.lm_damping = 0;
    }
    (elementary::powi(4.0, scratch.lm_damping) - 1.0) * step.inertia()
}

/// Leaves the force of the added inertia in the residual.
pub(super) fn leave(added: f64, vertices: &Vertices, increment: &mut Increment, scratch: &mut SolverScratch) {
    let SolverScratch { residual, free, .. } = scratch;
    parallel::for_rows(residual, |v, r| *r += free[v] * increment.delta[v] * (vertices.mass[v] * added));
    increment.is_fraction = true;
}

/// Adapts the damping level to the fraction of the last answer that was taken: the smaller, the more inertia in the next correction.
pub fn adapt_lm_damping(scratch: &mut SolverScratch, fraction: f64) {
    let quadrupled = match fraction {
        _ if fraction < SMALL_FRACTION => scratch.lm_damping + 2,
        _ if fraction < 1.0 => scratch.lm_damping + 1,
        _ => scratch.lm_damping.saturating_sub(1),
    };
    scratch.lm_damping = quadrupled.min(MOST_QUADRUPLINGS);
}

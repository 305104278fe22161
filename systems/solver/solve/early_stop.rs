//! Solves that stop early: by the error of positions, or because a step's iterations are used up.
//!
//! The energy norm of an error e bounds its motion: Σ m·|e|²/s² ≤ e·A·e, with equality for parts held by inertia alone. So the root of its
//! estimate over that of moving all masses by one edge is no less than the mean error of positions, in edges. Conjugate gradients
//! that stop leave a residual r, which does the work −x·r that no load has done. Scaled by x·b/x·A·x the answer of a guess does none,
//! as that from zero: any energy lost then is lost to the implicit step alone.

use crate::components::{Increment, SolveResult, SolverScratch, TearDecisions};
use crate::storage::Tips;
use crate::systems::solver::{Operator, ProductMemory};
use crate::systems::{StepContext, parallel, work};
use glam::DVec3;

/// The square of an equilateral triangle's edge over its area.
const EDGE_SQUARED: f64 = 2.309_401_076_758_503;

/// Criterion above which a tear may advance in the next step.
const NEARLY_TEARING: f64 = 0.9;

/// Iterations that the budget leaves to a solve, if there is one, so that the work to come after it stays within: an advance of a tear, and the
/// second solve that decides on it.
pub(super) fn within_budget(
    step: &StepContext,
    result: &SolveResult,
    tears: Option<(&Tips, &TearDecisions)>,
) -> Option<u32> {
    let step = if !step.is_corrector && tears.is_some_and(may_tear) { step.before(1) } else { *step };
    step.left(result).map(|left| {
        let left = left.saturating_sub(work::SET_UP).saturating_sub(result.work_of_advance);
        left.max(work::LEAST_ITERATIONS)
    })
}

/// Whether a tear may be due by the decisions of the last step; assumed where tips have come or gone.
fn may_tear((tips, decisions): (&Tips, &TearDecisions)) -> bool {
    let is_near = decisions.tips.iter().flatten().any(|decision| decision.value > NEARLY_TEARING);
    is_near
        || decisions.tips.len() != tips.len()
        || decisions.nucleation.is_some()
        || decisions.ligament_failure.is_some()
}

/// The energy \[mJ\] of the masses' motion by the mean edge in the step.
pub(super) fn motion_by_an_edge(operator: &Operator, scratch: &mut SolverScratch) -> f64 {
    let (vertices, triangles, partials) = (operator.vertices, operator.triangles, &mut scratch.partials);
    let mass = parallel::sum(vertices.len(), partials, |v| vertices.mass[v]);
    let area = parallel::sum(triangles.len(), partials, |t| triangles.rest[t].area);
    operator.inertia * mass * EDGE_SQUARED * area / triangles.len().max(1) as f64
}

/// Scales the answer along free axes so that the residual left does no work along it.
pub(super) fn scale_to_no_work(
    operator: &Operator,
    memory: &mut ProductMemory<'_>,
    increment: &mut Increment,
    scratch: &mut SolverScratch,
) {
    let SolverScratch { free, residual, product, partials, .. } = scratch;
    let delta = &mut increment.delta;
    product.resize(delta.len(), DVec3::ZERO);
    let taken = operator.apply(delta, free, memory, product, partials);
    let left = parallel::sum(delta.len(), partials, |v| residual[v].dot(delta[v] * free[v]));
    let scale = 1.0 + left / taken;
    // A scale out of this range means a negligible answer, which is kept.
    if !(taken > 0.0 && (0.5..=2.0).contains(&scale)) {
        return;
    }
    parallel::for_rows(delta, |v, x| *x *= DVec3::ONE + free[v] * (scale - 1.0));
    parallel::for_rows(residual, |v, r| *r += product[v] * free[v] * (1.0 - scale));
}

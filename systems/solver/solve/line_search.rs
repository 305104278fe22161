//! The line search of static increments: one that reduces neither the imbalance nor its work is halved.

use crate::components::{Forces, Increment, LineSearch, SolveResult, SolverScratch};
use crate::systems::parallel;
use crate::systems::solver::scale_guided;

/// Smallest fraction of a static increment that the line search tries; each fraction is half of the one before.
const LEAST_LINE_SEARCH_FRACTION: f64 = 1.0 / 64.0;

/// Merit of the line search: work of the imbalance along an increment, and the squared norm of the imbalance.
fn merit(increment: &Increment, scratch: &SolverScratch) -> (f64, f64) {
    let rows = increment.delta.iter().zip(&scratch.residual).zip(&scratch.free);
    let guided = scratch.guide_constraints.merit(&increment.delta, &scratch.residual);
    rows.fold(guided, |(work, norm_sq), ((d, r), f)| (work + (*d * *f).dot(*r), norm_sq + (*r * *f).length_squared()))
}

/// Remembers the imbalance before a static increment is made. The solve has overwritten the residual: it is formed anew.
pub(super) fn start_line_search(
    forces: &Forces,
    increment: &Increment,
    (result, scratch): (&SolveResult, &mut SolverScratch),
) {
    parallel::for_rows(&mut scratch.residual, |v, r| *r = forces.nodal[v]);
    let (work, norm_sq) = merit(increment, scratch);
    // The first increment carries the prescribed motion: there is nothing to compare it with.
    let is_first = result.newton_iterations == 1;
    scratch.line_search = (!is_first).then_some(LineSearch { work: work.abs(), norm_sq, fraction: 1.0 });
}

/// Replaces a rejected increment by the correction that halves it: minus half of it, later half of the last correction.
pub(super) fn reject_increment(increment: &mut Increment, scratch: &mut SolverScratch) -> bool {
    let Some(search) = scratch.line_search else { return false };
    let (work, norm_sq) = merit(increment, scratch);
    let is_better = norm_sq <= search.norm_sq || work.abs() <= 0.9 * search.work * search.fraction;
    if is_better || search.fraction <= LEAST_LINE_SEARCH_FRACTION {
        return false;
    }
    let back = if search.fraction == 1.0 { -0.5 } else { 0.5 };
    let SolverScratch { free, guide_constraints, .. } = scratch;
    scale_guided((guide_constraints, &*free), &mut increment.delta, back);
    scratch.line_search = Some(LineSearch { fraction: 0.5 * search.fraction, ..search });
    true
}

//! Finds linearly implicit steps that would create energy.
//!
//! The membrane has the forces f and the tangent K where a step of backward Euler starts. For a displacement u in it and a gain Δv
//! of velocity, holds and loads do the work W = −f·u + uᵀ·K·u + v₁·M·Δv. The energy stored and that of motion together grow by no
//! more than W where
//!
//! E(x + u) − E(x) ≤ −f·u + uᵀ·K·u + ½·Δv·M·Δv.
//!
//! A step that is solved once more, for its tears or for contact, goes on from the state that it has reached, by a displacement
//! that adds w to its velocity. With v₀ at its start and the same loads, the two iterations together create the energy of the
//! first one and E(x + u) − E(x) + f·u − uᵀ·K·u − ½·w·M·w + w·M·v₀.
//!
//! Where the step takes only a fraction p of u, on prescribed axes as on free ones, p·(1 − p)·u·A·u by the rows of free axes of that work is
//! not done. Here A is the matrix of the step, whose equations p·u does not solve. The spurious energy is less by that, and with a small
//! enough fraction energy is lost. A hold that was to jump goes the rest of its way in later steps.
//!
//! A turn by the angle ω stores nothing along the tangent but in truth stretches the tissue by ω²/2. So a flap or a free
//! fragment that turns far in one step breaks the inequality. A solve that stops at the residual r does the spurious work −u·r.
//! Where stiff fibres are crushed, a ten-thousandth of their forces is as much as the energy in the body. Repeated, spurious
//! energy grows without bound. So it is summed from step to step, down to zero. A solve that takes the sum beyond a share of
//! the energy in the body meets these remedies, in this order:
//!
//! 1. a local relaxation: vertices of the triangles that create the most descend on the incremental potential itself;
//! 2. in a fallback sub-step, or where the budget allows no other solve, the largest fraction of the increment that stays below the limit;
//! 3. a [Newton correction](crate::settings::Advanced::newton_corrections) with the projected tangent and a line search, where
//!    settings allow it;
//! 4. refusal: the step is undone and [retried in halves](crate::settings::Advanced::max_step_halvings).
//!
//! A corrector solve of tips that glide takes the fraction of its answer that lowers the incremental potential: where sheets snap from slack to
//! taut whole answers go to and fro, and the tear would be decided on any of them.
//!
//! Damping counts as external work: the stress that earlier solves of the step have left works along the displacement of this
//! one, so that its dissipation cancels spurious energy. So does drag.
//!
//! For a body that bends, E includes the energy of bending, f its moments, and K its majorant.

pub mod audit;
mod folds;
mod lanes;
mod line_search;
mod local_relaxation;
pub mod momentum;
pub mod nonlinear;
mod place;
mod solved;
mod verdict;

use crate::components::{
    Damping, Drag, FibreLaws, Forces, Frames, FreeAxes, Grips, GuardLedger, Increment, Planar, PreStretch, SolveResult,
    SolverScratch, fibre_law,
};
use crate::math::Orthotropic;
use crate::settings::ablation::Part;
use crate::storage::{Topology, Triangles, Vertices};
use crate::systems::bending::{BendingPasses, DihedralAngles};
use crate::systems::forces::element::BodyLaw;
use crate::systems::solver::{Operator, reactions};
use crate::systems::{Formula, StepContext, parallel};
use glam::DVec3;
use solved::{Solved, Strained, Sums};
use verdict::{Judged, Permitted};

/// Limit of the spurious energy, as a share of the energy in the body. The next steps mostly take away the energy that one
/// adds, so that a much smaller share would refuse steps that do no harm.
const SPURIOUS_SHARE: f64 = 0.1;

/// Largest number of triangles from which a local relaxation may start in a first attempt, before halves or corrections.
const SPIKE: usize = 2;

/// Steps without that limit of triangles after one with a local relaxation, as a spike that flaps goes on for a while.
const RELAXING: u32 = 8;

/// A strain whose energy counts as being in the body: slack tissue at rest stores nothing, and may turn.
const SLACK_STRAIN: f64 = 0.01;

/// Smallest fraction of the increment that is tried by halving.
const HALVED: f64 = 1e-3;

/// Smallest fraction of the increment of a body at rest, tried by eighths. Where stiff tissue is crushed, inertia alone holds
/// it from the side in a solve. In a step that is long beside its waves the increment is a million times as long as the tissue. Along
/// it energy falls all the same, and a fraction that goes no further than a tenth of a triangle lets it buckle, step by step.
const LEAST_FRACTION: f64 = 1e-15;

/// Rounding of a sum over all triangles, over the limit.
const SUM_ROUNDING: f64 = 1e-12;

type Query<'a> = (
    (&'a Vertices, &'a Triangles, &'a Topology, &'a Frames),
    (&'a mut Increment, Option<&'a DihedralAngles>, place::Holders<'a>),
    (Option<&'a mut BendingPasses>, &'a mut Forces),
    (&'a SolveResult, &'a mut SolverScratch, &'a mut GuardLedger),
    (Option<&'a Damping>, Option<&'a Drag>),
    (Option<&'a PreStretch>, Option<&'a Planar>, FibreLaws<'a>),
);

/// Marks the bodies that get a Newton correction and returns their number; with none, all marks stay.
pub fn uncorrected(world: &mut hecs::World, _: &StepContext) -> usize {
    let bodies = world.query_mut::<(&SolveResult, &SolverScratch)>().into_iter();
    let count = bodies.filter(|(_, scratch)| scratch.to_correct.is_some()).count();
    if count > 0 {
        for (result, scratch) in world.query_mut::<(&mut SolveResult, &SolverScratch)>() {
            result.select(scratch.to_correct.is_some());
        }
    }
    count
}

/// The energy guard: adds the spurious energy of the last solve to the sum, and mends or marks the bodies above the limit. In a fallback
/// sub-step such a body takes the largest fraction of its increment that stays below it, and is refused where even zero exceeds it.
pub fn enforce(world: &mut hecs::World, step: &StepContext) -> usize {
    // Energy created by several solves is judged at their end.
    if !step.has(Part::EnergyGuard)
        || step.is_static
        || step.newton_iterations > 1
        || step.formula != Formula::BackwardEuler
    {
        return 0;
    }
    let count = parallel::for_bodies::<Query>(
        world,
        |((_, triangles, ..), _, _, (result, ..), ..)| result.rows_to_solve(triangles.len()),
        |body| enforce_in(body, step),
    );
    // Reactions of bodies that took only a part of the answer.
    reactions::of_part(world, step);
    count
}

/// The energy guard for one body.
fn enforce_in(
    (
        (vertices, triangles, topology, frames),
        (increment, folds, holders),
        (passes, Forces { corner, .. }),
        (result, scratch, ledger),
        (damping, drag),
        (pre_stretch, planar, fibres),
    ): Query<'_>,
    step: &StepContext,
) {
    let slack = *increment.slack_energy.get_or_insert_with(|| slack_energy(triangles, |t| &triangles.stiffness[t]));
    let (viscosity, tangent) = (damping.map_or(0.0, |d| d.time) * step.inv_effective_dt(), result.tangent);
    let membrane = Operator::membrane((vertices, triangles, topology, frames), tangent);
    let operator = Operator { folds, inertia: step.inertia(), viscosity, ..membrane };
    let fibres = fibre_law(fibres, pre_stretch);
    let (is_planar, unstretched) = (planar.is_some(), PreStretch::unstretched(pre_stretch));
    // The budget allows no two solves: neither halves nor a correction with a fallback sub-step after it.
    let is_last = !step.affords(result, 2);
    // After the first Newton correction there is enough left for a fallback sub-step.
    let may_correct = step.newton_corrections > 0
        && step.affords(result, if step.is_correction { 1 } else { 2 })
        && scratch.guide_constraints.is_empty()
        && !may_spin(planar, &scratch.free, holders.0);
    let (twice_stored, work) = (scratch.twice_stored, scratch.residual_work);
    let SolverScratch {
        free,
        residual,
        partials,
        pairs,
        to_correct,
        is_counted,
        direction: pull,
        product,
        relaxation,
        ..
    } = &mut *scratch;
    let is_damped_before = viscosity > 0.0 && increment.displacement.iter().any(|u| *u != DVec3::ZERO);
    let solved = Solved {
        operator,
        increment,
        delta: &increment.delta,
        free,
        law: BodyLaw { is_planar, unstretched, fibres: fibres.as_ref() },
        residual,
        is_counted: *is_counted,
        is_damped_before,
        drag: drag.map_or(0.0, |drag| drag.coefficient * step.inv_effective_dt()),
        inv_effective_dt: step.inv_effective_dt(),
    };
    // Energy created by the previous solve is in the body where this one starts, and this one is to take it away.
    let is_corrected = to_correct.is_some();
    let limit = to_correct.take().unwrap_or_else(|| SPURIOUS_SHARE * solved.energy(twice_stored, slack, partials));
    // Where the body has lost energy since, the sum is clamped to the present limit.
    let before = if is_corrected { ledger.spurious_energy } else { ledger.spurious_energy.min(limit) };
    let mut spare = BendingPasses::default();
    let mut sums = Sums { partials, pairs, passes: passes.unwrap_or(&mut spare), corner, pull, product };
    let is_searched = step.is_corrector && !step.is_correction && result.has_gliding_tips;
    let whole = if is_searched {
        solved.strained_and_damped(&mut sums)
    } else {
        Strained { spurious: solved.strained(1.0, &mut sums), damped: 0.0 }
    };
    let more = solved.less_dissipated(whole.spurious, 1.0, sums.partials);
    let judged = Judged {
        solved: &solved,
        holders,
        before,
        more,
        work,
        // Rounding of zero energy counts as zero.
        most: limit * (1.0 + SUM_ROUNDING),
    };
    let may = Permitted {
        triangles: if !step.has(Part::LocalRelaxation) {
            0
        } else if step.is_retried || is_last || step.is_correction || ledger.relaxing > 0 {
            usize::MAX
        } else {
            SPIKE
        },
        is_shortened: step.has(Part::IncrementLimit) && (step.is_fallback || is_last && !is_corrected),
        is_corrected,
        is_solved_further: may_correct,
        is_undone: step.has(Part::Undo),
    };
    let searched = if is_searched { judged.searched(&whole, &mut sums) } else { None };
    let (verdict, place) = match searched {
        Some(verdict) => (verdict, None),
        None => judged.verdict(&may, relaxation, &mut sums),
    };
    verdict.apply(place, limit, (increment, scratch, ledger));
}

/// Whether a body may spin, held by nothing or only in its plane: retried halves keep its spin, Newton corrections brake it.
fn may_spin(planar: Option<&Planar>, free: &FreeAxes, grips: Option<&Grips>) -> bool {
    let is_gripped = |grips: &Grips| grips.pinches.iter().any(|pinch| !pinch.held.rows().is_empty());
    planar.is_some() || free.iter().all(|axes| *axes == DVec3::ONE) && !grips.is_some_and(is_gripped)
}

/// The fraction of the increment tried after this one.
fn shorter(fraction: f64) -> f64 {
    match fraction {
        _ if fraction > HALVED => 0.5 * fraction,
        _ if fraction > LEAST_FRACTION => 0.125 * fraction,
        _ => 0.0,
    }
}

/// Energy that a body whose triangles have such laws would store at the strain [`SLACK_STRAIN`] \[mJ\].
fn slack_energy<'a>(triangles: &Triangles, law: impl Fn(usize) -> &'a Orthotropic) -> f64 {
    let of_triangle = |t: usize| {
        let q = law(t);
        0.5 * triangles.rest[t].area * triangles.thickness[t] * (q.q11 + q.q22) * (SLACK_STRAIN * SLACK_STRAIN)
    };
    (0..triangles.len()).map(of_triangle).sum()
}

//! The solve of a Newton iteration: imbalance, convergence, preconditioner, conjugate gradients, reactions.

mod choice;
mod early_stop;
mod line_search;

use super::{Available, CgError, CgInfo, Factor, MixedSolver, Operator, ProductMemory, reactions};
use crate::components::{
    CompartmentState, CompartmentWork, Damping, EnergyAudit, ExternalStiffness, Forces, Frames, Grips, Holds,
    Increment, PreStretch, Pressure, Reactions, SolveResult, SolverScratch, TearDecisions, Tearing,
};
use crate::settings::ablation::Part;
use crate::settings::{LinearParams, Tangent};
use crate::storage::room::grow;
use crate::storage::{Tips, Topology, Triangles, Vertices};
use crate::systems::bending::{BendingPasses, DihedralAngles};
use crate::systems::{StepContext, parallel, work};
use choice::available;
use early_stop::{motion_by_an_edge, scale_to_no_work, within_budget};
use glam::DVec3;
use line_search::{reject_increment, start_line_search};

/// Relative residual of the linear solve of the first Newton iteration; later ones follow Eisenstat and Walker.
const FIRST_NEWTON: f64 = 1e-4;

/// Factor on the tolerance of the last allowed iteration, whose residual no later one corrects; it would turn a free body.
const LAST_NEWTON: f64 = 0.1;

type Query<'a> = (
    (&'a Vertices, &'a Triangles, &'a Topology, &'a mut Frames),
    (&'a mut Forces, &'a mut Increment, &'a mut SolveResult, &'a mut SolverScratch),
    (&'a mut Factor, &'a mut MixedSolver),
    (Option<&'a ExternalStiffness>, Option<&'a DihedralAngles>, Option<&'a mut BendingPasses>, Option<&'a Damping>),
    (Option<&'a Holds>, Option<&'a mut Reactions>, Option<&'a mut Grips>),
    (Option<&'a Tearing>, Option<(&'a Tips, &'a TearDecisions)>),
    (Option<&'a PreStretch>, Option<&'a EnergyAudit>, Option<&'a Pressure>, Option<&'a mut CompartmentState>),
);

/// Solves (M/s² + D/s + K)·δ = f − M·(u/s² − b) for the change δ of the displacement u, with the span s and the knowns b of the
/// step's formula: Δt and v/Δt in backward Euler.
pub fn solve(world: &mut hecs::World, step: &StepContext) -> usize {
    parallel::for_bodies::<Query>(
        world,
        |((_, triangles, ..), (_, _, result, _), ..)| result.rows_to_solve(triangles.len()),
        |body| solve_body(body, step),
    )
}

/// Counts the bodies that need another Newton iteration.
pub fn unconverged(world: &mut hecs::World, _: &StepContext) -> usize {
    let is_needed = |result: &SolveResult| result.is_active() && !result.linear_residual.is_nan();
    world.query_mut::<&SolveResult>().into_iter().filter(|result| is_needed(result)).count()
}

/// Ends the iterations of a linearly implicit solve: a body is converged that has a finite answer.
pub fn end(world: &mut hecs::World, _: &StepContext) -> usize {
    let mut count = 0;
    for result in world.query_mut::<&mut SolveResult>() {
        count += usize::from(result.is_active());
        result.select(false);
        result.has_converged = result.linear_residual.is_finite();
    }
    count
}

/// One body's solve.
fn solve_body(
    (
        (vertices, triangles, topology, frames),
        (forces, increment, result, scratch),
        (factor, mixed),
        (external, folds, passes, damping),
        (holds, mut reactions, mut grips),
        (tearing, tears),
        (pre_stretch, audit, pressure, compartment),
    ): Query<'_>,
    step: &StepContext,
) {
    let imbalance_before = result.imbalance;
    // Before the first increment prescribed motion is still to come.
    let has_begun = result.newton_iterations > 1;
    scratch.least_imbalance = if has_begun { scratch.least_imbalance.min(imbalance_before) } else { f64::INFINITY };
    (increment.is_fraction, increment.applied, increment.has_projected_vertices) = (false, 1.0, false);
    let force_scale = imbalance(vertices, forces, increment, (result, scratch), step);
    // At every evaluation, so that an iteration that stops short of its tolerance has reactions too.
    if step.newton_iterations > 1 {
        let prescribers = (holds, reactions.as_deref_mut(), grips.as_deref_mut());
        reactions::record(prescribers, step.time, |v| -scratch.residual[v]);
    }
    let of_content = compartment.as_ref().map_or(0.0, |compartment| compartment.rounding());
    let unavoidable =
        if step.newton_iterations > 1 { rounding(vertices, triangles, frames, external) + of_content } else { 0.0 };
    if has_converged(increment, (result, scratch), step, unavoidable.max(step.newton_tolerance * force_scale)) {
        result.select(false);
        result.has_converged = true;
        return;
    }
    if step.is_static && reject_increment(increment, scratch) {
        return;
    }
    // Newton iteration limit or budget reached; the last iterate is already evaluated.
    if !step.is_static && step.newton_iterations > 1 && result.newton_iterations == step.newton_iterations {
        return;
    }
    if step.newton_iterations > 1 && result.newton_iterations > 0 && !step.affords(result, 1) {
        result.select(false);
        return;
    }
    result.tangent = step.tangent_of(result);
    result.newton_iterations += 1;
    result.work = result.work.saturating_add(work::EVALUATION);
    result.work_of_advance = tearing.map_or(0, |_| work::of_advances(1, triangles.len()));
    let mut none = CompartmentWork::default();
    let CompartmentWork { stiffness, answer, trial, .. } =
        compartment.map_or(&mut none, |compartment| &mut *compartment.work);
    let follower = match (&*trial, pressure) {
        (Some(trial), _) => trial.filled.pressure - trial.out.outside,
        (None, Some(pressure)) => pressure.curve.at(step.time),
        (None, None) => 0.0,
    };
    let operator = Operator {
        external,
        volume: trial.is_some().then_some(&*stiffness),
        folds,
        inertia: step.inertia(),
        viscosity: damping.map_or(0.0, |d| d.time) * step.inv_effective_dt(),
        // A linear response is that of linear elasticity, whose load acts on the shape as it is.
        pressure: if follower != 0.0
            && step.is_static
            && step.newton_iterations > 1
            && !super::has_free_rim((vertices, triangles, topology), &scratch.free)
        {
            follower
        } else {
            0.0
        },
        ..Operator::membrane((vertices, triangles, topology, frames), result.tangent)
    };
    if step.is_static && result.newton_iterations > 1 {
        increment.delta.fill(DVec3::ZERO);
    }
    if scratch.contact.solved_together.is_none()
        && (step.is_fallback || !step.is_static && !step.has(Part::InitialGuess))
    {
        // From a zero guess the residual of conjugate gradients does no work along the answer (Galerkin orthogonality).
        let SolverScratch { free, .. } = &*scratch;
        parallel::for_rows(&mut increment.delta, |v, delta| *delta *= DVec3::ONE - free[v]);
    }
    let params = linear_params(step, result, imbalance_before, force_scale);
    let left = within_budget(step, result, tears);
    let is_shortened = left.is_some_and(|left| left < params.iterations);
    let params =
        LinearParams { iterations: left.map_or(params.iterations, |left| left.min(params.iterations)), ..params };
    let available = available((step, left), (&operator, &scratch.free, tearing), (&mut *factor, mixed));
    scratch.is_audited = step.asks_for_exact_residual(audit.is_some());
    let is_linear_step = !step.is_static && step.newton_iterations == 1;
    // The position tolerance is ignored in retries: in a short sub-step every motion is small against an edge.
    let uses_position_tolerance = is_linear_step
        && !step.is_retried
        && step.position_tolerance.is_finite()
        && scratch.guide_constraints.is_empty();
    // The norm that residuals are measured by: the largest right-hand side of the step. Newton's iterations, further solves of the energy
    // guard and fallbacks use their own.
    if !is_linear_step || step.is_correction || step.is_fallback {
        scratch.reference_sq = 0.0;
    }
    scratch.motion_scale = if uses_position_tolerance { motion_by_an_edge(&operator, scratch) } else { 0.0 };
    scratch.near = if uses_position_tolerance {
        step.position_tolerance * step.position_tolerance * scratch.motion_scale
    } else {
        0.0
    };
    scratch.twice_stored = if is_linear_step { twice_stored(triangles, frames, pre_stretch, scratch) } else { 0.0 };
    let mut rotated = None;
    let mut spare = BendingPasses::default();
    let mut memory = ProductMemory { corner: &mut forces.corner, passes: passes.unwrap_or(&mut spare) };
    scratch.residual_work = 0.0;
    match solve_or_fall_back(
        operator,
        (step, &params),
        available,
        (&mut memory, increment, answer),
        (result, scratch),
        &mut rotated,
    ) {
        Ok(info) => {
            let is_rescaled = uses_position_tolerance && scratch.contact.solved_together.is_none();
            // Another length would be another volume.
            if is_rescaled && operator.volume.is_none() {
                scale_to_no_work(&operator, &mut memory, increment, scratch);
            }
            if is_linear_step {
                scratch.residual_work = residual_work(increment, scratch);
            }
            note(&info, &params, result, scratch);
            result.is_cut_short = is_shortened && !info.is_solved;
        }
        // No answer: a value that is not finite is caught after the step, which is then rolled back.
        Err(_) => result.linear_residual = f64::NAN,
    }
    result.fallback_factors += factor.take_fallbacks();
    result.work = result.work.saturating_add(factor.take_work());
    // Solves of other systems in this scratch ask for their residual alone.
    (scratch.near, scratch.contact.solved_together) = (0.0, None);
    if step.newton_iterations == 1 {
        let used = rotated.as_ref().map_or(operator, |frames| Operator { frames, tangent: result.tangent, ..operator });
        reactions::of_linear_step(&used, forces, increment, step, (holds, reactions, grips));
    }
    // The energy guard judges the answer with the tangent that it was solved with.
    if let Some(rotated) = rotated {
        scratch.fallback.spare = std::mem::replace(frames, rotated);
    }
    if step.is_static {
        start_line_search(forces, increment, (result, scratch));
    }
}

/// Records the iterations and the residual of a linear solve.
fn note(info: &CgInfo, params: &LinearParams, result: &mut SolveResult, scratch: &SolverScratch) {
    let SolverScratch { motion_scale, twice_stored, .. } = *scratch;
    let relative = |scale: f64| if scale > 0.0 { (info.error_energy / scale).sqrt() } else { 0.0 };
    result.iterations += info.iterations;
    result.work = result.work.saturating_add(work::SET_UP).saturating_add(info.iterations);
    result.position_error = relative(motion_scale);
    result.linear_residual = info.relative_residual;
    result.stress_error = if params.stress_tolerance.is_finite() { relative(twice_stored) } else { 0.0 };
    result.is_late |= info.is_late;
}

/// The work \[mJ\] that the residual r = b − A·δ of a linear solve does along the answer, −δ·r on free axes: the energy that an early stop
/// creates or takes.
fn residual_work(increment: &Increment, scratch: &mut SolverScratch) -> f64 {
    let SolverScratch { free, residual, partials, .. } = scratch;
    -parallel::sum(residual.len(), partials, |v| residual[v].dot(increment.delta[v] * free[v]))
}

/// Σ V·T:C⁻¹:T \[mJ\] at the start of the step, in whose norm the error of the stress is estimated: with the linear law it is
/// Σ V·T:(U − U₀), twice the stored energy.
fn twice_stored(
    triangles: &Triangles,
    frames: &Frames,
    pre_stretch: Option<&PreStretch>,
    scratch: &mut SolverScratch,
) -> f64 {
    let unstretched = PreStretch::unstretched(pre_stretch);
    let energy = |t: usize| {
        let state = frames.state(t);
        let volume = triangles.rest[t].area * triangles.thickness[t];
        let strain = match frames.stiffened.get(t) {
            None => state.polar.stretch - triangles.unstretched(t, unstretched),
            Some(stiffened) => stiffened.law.strain(state.stress),
        };
        volume * state.stress.contract(strain)
    };
    parallel::sum(frames.len(), &mut scratch.partials, energy)
}

/// Fills `scratch.residual` with the residual of the momentum equation f − M·(u/s² − b) \[N\], and `result.imbalance` with its largest free
/// component. Returns the largest corner force \[N\].
fn imbalance(
    vertices: &Vertices,
    forces: &Forces,
    increment: &Increment,
    (result, scratch): (&mut SolveResult, &mut SolverScratch),
    step: &StepContext,
) -> f64 {
    grow(&mut scratch.residual, vertices.len(), vertices.position.capacity());
    scratch.residual.resize(vertices.len(), DVec3::ZERO);
    parallel::for_rows(&mut scratch.residual, |v, r| {
        *r = forces.nodal[v] + step.momentum(increment, v) * vertices.mass[v];
    });
    if step.newton_iterations == 1 {
        return 0.0;
    }
    let of_vertices = scratch.residual.iter().zip(&scratch.free).map(|(r, f)| *r * *f);
    // A NaN is not small.
    let larger = |most: f64, r: DVec3| if r.is_finite() { most.max(r.abs().max_element()) } else { f64::INFINITY };
    result.imbalance = of_vertices.fold(scratch.guide_constraints.imbalance(&scratch.residual), larger);
    forces.scale
}

/// The nodal force \[N\] that rounding alone leaves: a strain is known to ε·|x|/edge, so a corner force Q·h·edge·strain
/// to ε·Q·h·|x|, of which up to eight meet in a vertex. A body torn through is free of stress, and no fraction of its
/// own forces can be reached. The forces of springs and jaws are known to ε·|x| times their stiffness. By the rest
/// shape, lest a body that nothing holds and that flies off counts as at rest far away.
fn rounding(vertices: &Vertices, triangles: &Triangles, frames: &Frames, external: Option<&ExternalStiffness>) -> f64 {
    let extent = vertices.rest_position.iter().map(|x| x.abs().max_element()).fold(0.0, f64::max);
    let stiffness = triangles.thickness.iter().enumerate().map(|(t, h)| {
        let q = frames.stiffness(triangles, t);
        q.q11.max(q.q22) * h
    });
    let blocks = external.map_or(&[][..], |external| &external.block);
    let springs = blocks.iter().map(|k| k.diagonal.max_element());
    8.0 * f64::EPSILON * extent * stiffness.chain(springs).fold(0.0, f64::max)
}

fn has_converged(
    increment: &Increment,
    (result, scratch): (&SolveResult, &SolverScratch),
    step: &StepContext,
    least: f64,
) -> bool {
    if step.newton_iterations == 1 || !(result.imbalance <= least && result.imbalance.is_finite()) {
        return false;
    }
    // Prescribed motion still to be made; and a dynamic step that has not been solved at all has not moved the body, which
    // would rest in place with its velocity, however small that is.
    let is_moved = |(d, f): (&DVec3, &DVec3)| *d * (DVec3::ONE - *f) != DVec3::ZERO;
    result.newton_iterations > 0 || step.is_static && !increment.delta.iter().zip(&scratch.free).any(is_moved)
}

/// Forcing term of a Newton iteration: the square of the last gain (Eisenstat, Walker 1996, choice 2), limited by the tolerance of the step.
fn linear_params(step: &StepContext, result: &SolveResult, imbalance_before: f64, force_scale: f64) -> LinearParams {
    if step.newton_iterations == 1 {
        return step.linear;
    }
    let linear = LinearParams { tolerance: FIRST_NEWTON, stress_tolerance: f64::INFINITY, ..step.linear };
    if result.newton_iterations == 1 {
        return linear;
    }
    let needed = 0.1 * step.newton_tolerance * force_scale / result.imbalance.max(f64::MIN_POSITIVE);
    let gain = result.imbalance / imbalance_before.max(f64::MIN_POSITIVE);
    let least = step.linear.tolerance.min(FIRST_NEWTON);
    let share = if result.newton_iterations == step.newton_iterations { LAST_NEWTON } else { 1.0 };
    LinearParams { tolerance: (share * needed.max(gain * gain).min(1e-3)).max(least), ..linear }
}

/// The solve with the step's tangent or, where that is indefinite, without the load stiffness of pressure, or with the rotated one, which
/// is then left in `rotated`.
fn solve_or_fall_back(
    operator: Operator,
    (step, params): (&StepContext, &LinearParams),
    mut available: Available,
    (memory, increment, answer): (&mut ProductMemory<'_>, &mut Increment, &mut Vec<DVec3>),
    (fallen, scratch): (&mut SolveResult, &mut SolverScratch),
    rotated: &mut Option<Frames>,
) -> Result<CgInfo, CgError> {
    if let Some(relative_residual) = scratch.contact.solved_together {
        form_residual(&operator, memory, increment, scratch);
        return Ok(CgInfo { relative_residual, is_solved: true, ..CgInfo::default() });
    }
    let reserve = step.reserve();
    let mut solve = |operator: &Operator, delta: &mut [DVec3], scratch: &mut SolverScratch| match operator
        .volume
        .filter(|_| scratch.guide_constraints.is_empty())
    {
        Some(volume) => {
            let unknowns = (delta, &mut *answer);
            super::bordered::solve((operator, volume), params, &mut available, memory, unknowns, scratch)
        }
        None => super::solve(operator, params, &mut available, memory, delta, scratch),
    };
    // The masses of a dynamic step make a semidefinite operator definite.
    if operator.tangent == Tangent::Rotated || operator.tangent != Tangent::Exact && !step.is_static {
        return solve(&operator, &mut increment.delta, scratch);
    }
    let SolverScratch { fallback, residual, .. } = &mut *scratch;
    fallback.rhs.clone_from(residual);
    fallback.guess.clone_from(&increment.delta);
    let result = solve(&operator, &mut increment.delta, scratch);
    if !matches!(result, Err(CgError::Indefinite { .. })) {
        return result;
    }
    if operator.pressure != 0.0 {
        begin_anew(increment, scratch);
        let result = solve(&Operator { pressure: 0.0, ..operator }, &mut increment.delta, scratch);
        if !matches!(result, Err(CgError::Indefinite { .. })) {
            return result;
        }
    }
    fallen.fell_back = true;
    fallen.tangent = Tangent::Rotated;
    begin_anew(increment, scratch);
    let frames = rotated.insert(operator.rotated_frames(reserve, std::mem::take(&mut scratch.fallback.spare)));
    solve(&Operator { frames, pressure: 0.0, tangent: Tangent::Rotated, ..operator }, &mut increment.delta, scratch)
}

/// Turns the right-hand side into the residual of an answer that is at hand.
fn form_residual(
    operator: &Operator,
    memory: &mut ProductMemory<'_>,
    increment: &Increment,
    scratch: &mut SolverScratch,
) {
    let SolverScratch { free, residual, product, partials, .. } = scratch;
    product.resize(residual.len(), DVec3::ZERO);
    operator.apply(&increment.delta, free, memory, product, partials);
    parallel::for_rows(residual, |v, r| *r = (*r - product[v]) * free[v]);
}

/// Puts the right-hand side and the first guess back.
fn begin_anew(increment: &mut Increment, scratch: &mut SolverScratch) {
    scratch.residual.clone_from(&scratch.fallback.rhs);
    increment.delta.clone_from(&scratch.fallback.guess);
}

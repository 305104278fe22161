//! Finds steps of several Newton iterations, or of two stages, that have created energy.
//!
//! A converged step obeys its formula and nothing else: in a large turn of stiff tissue the formula itself makes
//! energy, two iterations leave an imbalance, and TR-BDF2 loses none but where it must. Such steps are judged by their final
//! state. With the energy E stored at x, the body's own forces f (stress, damping, bending), the imbalance r on free axes, and
//! by the formula
//!
//! M·(v_γ − v₀) = s·(F₀ + F_γ),     M·(v₁ − v_γ) = s·((m − 1)·(F₀ + F_γ) + F₁),     F = f + (holds and loads) − r,
//!
//! the step does the work of the mean of F in each stage along its way, u_γ and w = u₁ − u_γ. Holds and loads are the part of
//! it that is neither f nor r:
//!
//! W = ½·(v_γ + v₀)·M·(v_γ − v₀) + w·M·(v₁ − v_γ)/τ − ½·u_γ·(f₀ + f_γ − r_γ) − w·((m − 1)·(f₀ + f_γ − r_γ) + f₁ − r₁)/√2,
//!
//! with τ = √2·s, the second stage's length; in backward Euler, which has one stage, W = u·M·(v₁ − v₀)/Δt − u·(f₁ − r₁). The
//! growth of E and the kinetic energy beyond W is added to the same sum as the spurious energy of [linearised steps](super),
//! with the same bounds. A step that is refused is retried in halves, at last by a linearised one.
//!
//! Where tears have changed the mesh and the step is redone, the energy created along the way from there is added, along which
//! holds and loads act as at its end.

use super::place::of_triangle;
use super::{SPURIOUS_SHARE, slack_energy};
use crate::components::{
    Bending, Damping, FibreLaws, Forces, Frames, GuardLedger, Increment, Planar, PreStretch, SolveResult,
    SolverScratch, fibre_law,
};
use crate::event::{GuardCause, GuardPlace};
use crate::math::FibreLaw;
use crate::storage::{Topology, Triangles, Vertices};
use crate::systems::bending::{BendingPasses, DihedralAngles};
use crate::systems::context::MIDDLE;
use crate::systems::forces::element::BodyLaw;
use crate::systems::forces::relaxation;
use crate::systems::solver::{Operator, ProductMemory};
use crate::systems::{Formula, StepContext, parallel};
use glam::DVec3;
use std::f64::consts::FRAC_1_SQRT_2;

/// Query of the components on which the energy of a body depends.
type Elastic<'a> = (
    (&'a Vertices, &'a Triangles, &'a Topology, &'a Frames),
    (Option<&'a Planar>, Option<&'a PreStretch>, FibreLaws<'a>),
    Option<(&'a Bending, &'a DihedralAngles)>,
);

/// Whether the step is judged at its end: it has several Newton iterations, or two stages.
fn is_judged(step: &StepContext) -> bool {
    !step.is_static && (step.newton_iterations > 1 || step.formula != Formula::BackwardEuler)
}

/// Keeps the body's own forces, before loads are added to them, and the energy at the first evaluation.
pub fn begin(world: &mut hecs::World, step: &StepContext) -> usize {
    if !is_judged(step) {
        return 0;
    }
    type Query<'a> = (Elastic<'a>, &'a Forces, &'a Increment, (&'a SolveResult, &'a mut SolverScratch));
    parallel::for_bodies::<Query>(
        world,
        |(((_, triangles, ..), ..), .., (result, _))| result.rows_to_solve(triangles.len()),
        |(elastic, forces, increment, (result, scratch))| {
            let is_first = match step.formula {
                Formula::Start => true,
                Formula::BackwardEuler => result.newton_iterations == 0,
                Formula::Trapezoidal => false,
                Formula::SecondBackwardDifference => step.is_resumed && result.newton_iterations == 0,
            };
            if is_first {
                scratch.account.energy = Some(evaluated_energy(elastic, &mut scratch.partials));
            }
            if is_first && step.is_resumed {
                scratch.account.earlier.clone_from(&increment.displacement);
            }
            let kept = match step.formula {
                Formula::Start => &mut scratch.account.earlier,
                _ => &mut scratch.account.own,
            };
            kept.clone_from(&forces.nodal);
        },
    )
}

/// Extrapolates the body's own forces along its tangent to the end of the solve, where each stage is one solve.
pub fn linearise(world: &mut hecs::World, step: &StepContext) -> usize {
    if !is_judged(step) || step.newton_iterations > 1 {
        return 0;
    }
    type Query<'a> = (
        (&'a Vertices, &'a Triangles, &'a Topology, &'a Frames),
        (&'a mut Forces, &'a Increment, &'a SolveResult, &'a mut SolverScratch),
        (Option<&'a DihedralAngles>, Option<&'a mut BendingPasses>, Option<&'a Damping>),
    );
    parallel::for_bodies::<Query>(
        world,
        |((_, triangles, ..), (_, _, result, _), _)| result.rows_to_solve(triangles.len()),
        |((vertices, triangles, topology, frames), (forces, increment, result, scratch), (folds, passes, damping))| {
            let (viscosity, tangent) = (damping.map_or(0.0, |d| d.time) * step.inv_effective_dt(), result.tangent);
            let operator =
                Operator { folds, viscosity, ..Operator::membrane((vertices, triangles, topology, frames), tangent) };
            let SolverScratch { free, product, partials, account, .. } = scratch;
            product.resize(vertices.len(), DVec3::ZERO);
            let mut spare = BendingPasses::default();
            let mut memory = ProductMemory { corner: &mut forces.corner, passes: passes.unwrap_or(&mut spare) };
            operator.apply(&increment.delta, free, &mut memory, product, partials);
            parallel::for_rows(&mut account.own, |v, own| *own -= product[v]);
        },
    )
}

/// Adds the forces at the end of the first stage to those at its start.
pub fn second_stage(world: &mut hecs::World, _: &StepContext) -> usize {
    parallel::for_bodies::<(&Vertices, &mut SolverScratch, &SolveResult)>(
        world,
        |(vertices, scratch, _)| if scratch.account.energy.is_some() { vertices.len() } else { 0 },
        |(_, scratch, _)| {
            let SolverScratch { account, free, residual, .. } = scratch;
            parallel::for_rows(&mut account.earlier, |v, sum| *sum += account.own[v] - residual[v] * free[v]);
        },
    )
}

/// Adds up the spurious energy of the step, and marks the bodies where that is too much.
pub fn enforce(world: &mut hecs::World, step: &StepContext) -> usize {
    if !is_judged(step) {
        return 0;
    }
    type Solve<'a> = (&'a SolveResult, &'a mut SolverScratch, &'a mut GuardLedger);
    type Query<'a> = (Elastic<'a>, (&'a Forces, &'a mut Increment), Solve<'a>);
    parallel::for_bodies::<Query>(
        world,
        |(((vertices, ..), ..), _, (result, scratch, _))| {
            let is_judged = result.is_in_step && !result.linear_residual.is_nan() && scratch.account.energy.is_some();
            if is_judged { vertices.len() } else { 0 }
        },
        |(elastic, (forces, increment), (_, scratch, ledger))| {
            let SolverScratch { free, residual, partials, account, .. } = scratch;
            let ((vertices, triangles, _, frames), ..) = elastic;
            let Some(start) = account.energy.take() else { return };
            let inv_effective_dt = step.inv_effective_dt();
            let work = |v: usize| {
                let (mass, own) = (vertices.mass[v], account.own[v] - residual[v] * free[v]);
                let Increment { start_velocity, displacement, .. } = &*increment;
                let [before, after] = [start_velocity[v], vertices.velocity[v]];
                if step.is_resumed {
                    return (displacement[v] - account.earlier[v]).dot(forces.nodal[v] - account.own[v]);
                }
                if step.formula == Formula::BackwardEuler {
                    return displacement[v].dot((after - before) * (mass * inv_effective_dt) - own);
                }
                let [way, middle] = [increment.middle_displacement[v], increment.middle_velocity[v]];
                let rest = displacement[v] - way;
                let inertia = 0.5 * (middle + before).dot(middle - before)
                    + rest.dot(after - middle) * (FRAC_1_SQRT_2 * inv_effective_dt);
                let first = account.earlier[v].dot(way * 0.5 + rest * (FRAC_1_SQRT_2 * (MIDDLE - 1.0)));
                mass * inertia - first - own.dot(rest) * FRAC_1_SQRT_2
            };
            let work = parallel::sum(vertices.len(), partials, work);
            let energy = if step.newton_iterations > 1 {
                evaluated_energy(elastic, partials)
            } else {
                energy(elastic, partials)
            };
            // By one law over the step it is stored, though dashpots have taken it; by those of two stages it would count as created.
            let relaxed = match step.formula {
                Formula::BackwardEuler => 0.0,
                _ => relaxation::dissipated(&vertices.position, triangles, frames.is_planar(), partials),
            };
            let more = energy - relaxed - start - work;
            let before = ledger.spurious_energy;
            if before == 0.0 && more <= 0.0 {
                return;
            }
            let most = SPURIOUS_SHARE * (start + slack_energy(triangles, |t| frames.stiffness(triangles, t)));
            let sum = before.min(most) + more;
            ledger.creates_energy = !(sum <= most);
            if ledger.creates_energy {
                *increment.creates_at = Some(most_stored(elastic, more));
            } else {
                ledger.spurious_energy = sum.max(0.0);
            }
        },
    )
}

fn motion(vertices: &Vertices, partials: &mut Vec<f64>) -> f64 {
    parallel::sum(vertices.len(), partials, |v| 0.5 * vertices.mass[v] * vertices.velocity[v].length_squared())
}

/// Energy of stress, bending and motion \[mJ\] where the body was last evaluated.
fn evaluated_energy(
    ((vertices, triangles, _, frames), (planar, pre_stretch, fibres), bending): Elastic<'_>,
    partials: &mut Vec<f64>,
) -> f64 {
    let fibres = fibre_law(fibres, pre_stretch);
    let law = law(planar, pre_stretch, fibres.as_ref());
    let stored = parallel::sum(triangles.len(), partials, |t| law.stored(triangles, t, &frames.state(t)));
    stored + bending.map_or(0.0, |(_, folds)| folds.energy()) + motion(vertices, partials)
}

fn law<'a>(planar: Option<&Planar>, pre_stretch: Option<&PreStretch>, fibres: Option<&'a FibreLaw>) -> BodyLaw<'a> {
    BodyLaw { is_planar: planar.is_some(), unstretched: PreStretch::unstretched(pre_stretch), fibres }
}

/// Energy \[mJ\] that a triangle stores where it is now.
fn stored_now((vertices, triangles): (&Vertices, &Triangles), law: BodyLaw<'_>, t: usize) -> f64 {
    law.element(triangles, t).energy(triangles.corners[t].map(|v| vertices.position[v as usize]))
}

/// The triangle that stores most where the body is now, as the place of energy that several iterations have created.
fn most_stored(elastic: Elastic<'_>, created: f64) -> GuardPlace {
    let ((vertices, triangles, ..), (planar, pre_stretch, fibres), _) = elastic;
    let fibres = fibre_law(fibres, pre_stretch);
    let law = law(planar, pre_stretch, fibres.as_ref());
    let stored = |t: usize| stored_now((vertices, triangles), law, t);
    let larger = |most: (usize, f64), t: usize| {
        let now = stored(t);
        if now > most.1 { (t, now) } else { most }
    };
    let (t, _) = (0..triangles.len()).fold((0, f64::NEG_INFINITY), larger);
    of_triangle(GuardCause::Iterations, (vertices, triangles), t, created)
}

/// Energy of stress, bending and motion \[mJ\] where the body is now.
fn energy(
    ((vertices, triangles, topology, _), (planar, pre_stretch, fibres), bending): Elastic<'_>,
    partials: &mut Vec<f64>,
) -> f64 {
    let fibres = fibre_law(fibres, pre_stretch);
    let law = law(planar, pre_stretch, fibres.as_ref());
    let stored = parallel::sum(triangles.len(), partials, |t| stored_now((vertices, triangles), law, t));
    let body = (vertices, triangles, topology);
    let bent = bending
        .map_or(0.0, |(bending, folds)| DihedralAngles::energy_at(body, bending, Some(folds), &vertices.position));
    stored + bent + motion(vertices, partials)
}

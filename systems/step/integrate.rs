//! Time integration: the start of a step or stage with its first guess, and its end, x = x_start + u with v by the step's formula
//! ([`context`](crate::systems::context)).

use crate::components::{
    Forces, GuardLedger, Guide, HoldGuides, Holds, Increment, OutputsMut, Planar, Sleeping, SolveResult, SolverScratch,
    TearDecisions, Tearing,
};
use crate::storage::{Tips, Vertices};
use crate::systems::context::SECOND_STAGE;
use crate::systems::forces::hold::{Prescription, behind, mark_axes};
use crate::systems::fracture::split::begin_glides;
use crate::systems::{StepContext, parallel};
use glam::DVec3;

/// Query of the components for the free axes and the initial guess of a stage.
type AxesQuery<'a> = (
    (&'a Vertices, &'a mut Increment, &'a SolveResult, &'a mut SolverScratch),
    (Prescription<'a>, Option<&'a Planar>, &'a mut GuardLedger),
);

/// Decides which bodies take part in the step: those that are awake.
pub fn begin(world: &mut hecs::World, step: &StepContext) -> usize {
    let mut count = 0;
    type Tears<'a> = (&'a Vertices, &'a Tearing, &'a Tips, &'a mut TearDecisions);
    type Query<'a> = (&'a mut SolveResult, Option<&'a Sleeping>, Option<Tears<'a>>);
    for (result, sleeping, tears) in world.query_mut::<Query>() {
        result.begin(sleeping.is_some_and(Sleeping::is_asleep));
        result.has_gliding_tips = tears.as_ref().is_some_and(|(_, tearing, ..)| tearing.glides(step.is_static));
        if let Some((vertices, _, tips, decisions)) = tears {
            decisions.correctors = 0;
            decisions.glides.clear();
            if result.has_gliding_tips {
                result.follows_glide = begin_glides(vertices, tips, decisions);
            }
        }
        count += usize::from(result.is_active());
    }
    count
}

/// Sizes the increment to the vertices, saves the start of the step, marks free axes and sets the first guess of the linear solve.
/// The guess is the last increment scaled to this step along free axes, the prescribed displacement along the others.
pub fn hold(world: &mut hecs::World, step: &StepContext) -> usize {
    type Begun<'a> = (&'a mut SolverScratch, &'a mut GuardLedger, OutputsMut<'a>);
    for (scratch, ledger, read) in world.query_mut::<hecs::With<Begun, &SolveResult>>() {
        scratch.begin(read, step.is_retried);
        ledger.begin(step.is_retried);
    }
    parallel::for_bodies::<AxesQuery>(
        world,
        |((vertices, _, result, _), _)| result.rows_to_solve(vertices.len()),
        |((vertices, increment, _, scratch), (prescription, planar, ledger))| {
            let n = vertices.len();
            increment.start.clone_from(&vertices.position);
            increment.start_velocity.clone_from(&vertices.velocity);
            increment.displacement.resize(n, DVec3::ZERO);
            let last_dt = increment.last.dt;
            let scale = if step.is_static || last_dt <= 0.0 { 0.0 } else { step.stage_dt() / last_dt };
            increment.delta.clear();
            increment.delta.extend(increment.displacement.iter().map(|&u| u * scale));
            increment.displacement.fill(DVec3::ZERO);
            increment.last.dt = step.dt;
            increment.last.begin();
            increment.unapplied = if step.is_static { 0.0 } else { 1.0 };

            if step.is_static {
                ledger.hold_pace = 0.0;
            }
            let held = (prescription.0, prescription.1.as_deref());
            let part = ledger.part_of_holds(|| behind(vertices, held, step.time));
            mark_axes(vertices, increment, scratch, prescription, planar, (step.time, part));
        },
    )
}

/// Keeps the acceleration of every vertex at the start of a step of two stages, by the forces just evaluated there.
pub fn start(world: &mut hecs::World, step: &StepContext) -> usize {
    type Query<'a> =
        (&'a Vertices, &'a Forces, &'a mut Increment, &'a SolveResult, Option<(&'a Holds, &'a HoldGuides)>);
    parallel::for_bodies::<Query>(
        world,
        |(vertices, _, _, result, _)| result.rows_to_solve(vertices.len()),
        |(vertices, forces, increment, _, guided)| {
            increment.start_acceleration.resize(vertices.len(), DVec3::ZERO);
            parallel::for_rows(&mut increment.start_acceleration, |v, a| *a = forces.nodal[v] / vertices.mass[v]);
            let Some((holds, guides)) = guided else { return };
            for (place, hold) in holds.groups.iter().enumerate() {
                let Some(Guide::Together { force, curve }) = guides.of(place) else { continue };
                let mass: f64 = hold.members.rows().iter().map(|&row| vertices.mass[row as usize]).sum();
                let held = DVec3::from_array(hold.axes.map(|axis| f64::from(u8::from(axis))));
                let gained = *force * held * (curve.at(step.time) / mass);
                hold.members.rows().iter().for_each(|&row| increment.start_acceleration[row as usize] += gained);
            }
        },
    )
}

/// Begins the second stage at the end of the first, whose displacement, extrapolated, is the initial guess.
pub fn second_stage(world: &mut hecs::World, step: &StepContext) -> usize {
    for result in world.query_mut::<&mut SolveResult>() {
        result.newton_iterations = 0;
        result.take_part(result.is_in_step);
    }
    parallel::for_bodies::<AxesQuery>(
        world,
        |((vertices, _, result, _), _)| result.rows_to_solve(vertices.len()),
        |((vertices, increment, _, scratch), (prescription, planar, ledger))| {
            increment.middle_displacement.clone_from(&increment.displacement);
            increment.middle_velocity.clone_from(&vertices.velocity);
            let Increment { displacement, delta, .. } = &mut *increment;
            parallel::for_rows(delta, |v, delta| *delta = displacement[v] * SECOND_STAGE);
            mark_axes(vertices, increment, scratch, prescription, planar, (step.time, ledger.rest_of_holds()));
        },
    )
}

/// Resumes the step for bodies whose tears may advance further: same start, torn mesh, displacement reached; of two stages the last.
/// All other bodies are done.
pub fn resume(world: &mut hecs::World, step: &StepContext) -> usize {
    let mut count = 0;
    type Query<'a> = (
        (&'a Vertices, &'a mut Increment, &'a mut SolveResult, &'a mut SolverScratch),
        (Prescription<'a>, Option<&'a Planar>, Option<&'a mut TearDecisions>, &'a GuardLedger),
    );
    for ((vertices, increment, result, scratch), (prescription, planar, decisions, ledger)) in
        world.query_mut::<Query>()
    {
        // The others keep the result of their last solve; the decisions on their tears have been carried out.
        let mut decisions = decisions;
        let may_advance = decisions.as_mut().is_some_and(|decisions| {
            decisions.correctors = 0;
            decisions.may_advance_further
        });
        if result.is_in_step && !may_advance {
            decisions.into_iter().for_each(TearDecisions::forget);
            result.is_in_step = false;
        }
        result.select(true);
        if !result.is_active() {
            continue;
        }
        count += 1;
        increment.delta.clear();
        increment.delta.resize(vertices.len(), DVec3::ZERO);
        mark_axes(vertices, increment, scratch, prescription, planar, (step.time, ledger.rest_of_holds()));
        (result.newton_iterations, result.has_converged) = (0, false);
    }
    count
}

/// Adds the last solve's change to the displacement of the step and updates positions and velocities. A static solve has
/// no velocities.
pub fn integrate(world: &mut hecs::World, step: &StepContext) -> usize {
    parallel::for_bodies::<(&mut Vertices, &mut Increment, &SolveResult)>(
        world,
        |(vertices, _, result)| result.rows_to_solve(vertices.len()),
        |(vertices, increment, _)| {
            let Increment { displacement, delta, .. } = &mut *increment;
            parallel::for_rows(displacement, |v, u| *u += delta[v]);
            increment.unapplied *= 1.0 - increment.applied;
            let Increment { start, displacement, .. } = &*increment;
            parallel::for_rows(&mut vertices.position, |v, x| *x = start[v] + displacement[v]);
            let inv_effective_dt = step.inv_effective_dt();
            parallel::for_rows(&mut vertices.velocity, |v, x| {
                *x = step.velocity_displacement(increment, v) * inv_effective_dt
            });
            if !step.is_static {
                increment.delta.fill(DVec3::ZERO);
            }
        },
    )
}

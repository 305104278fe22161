//! One step of the world: solves, tears, and what is done where it leaves no sound state.

use crate::components::{EnergyAudit, Increment, Sleeping, SolverScratch, TearDecisions, Tearing};
use crate::report::Report;
use crate::schedule::{Schedule, Stage};
use crate::settings::{LinearParams, Settings};
use crate::storage::{Tips, Topology, Triangles, Vertices};
use crate::systems::tearing::will_tear;
use crate::systems::{StepContext, contact};
use glam::DVec3;
use hecs::World;

/// The error of the stress before a tear advances, as part of that allowed in passing: an advance cannot be taken back, and
/// the error at a tip may be some times that in the body as a whole.
const DECISIVE: f64 = 0.2;

/// So often at the most a step is solved again because a solve has carried vertices into an obstacle.
const CONTACT_ROUNDS: u32 = 4;

/// What a step is run by, and where it is told what it did.
pub(super) struct Running<'a> {
    /// The systems.
    pub schedule: &'a mut Schedule,
    /// Their report.
    pub report: &'a mut Report,
}

impl Running<'_> {
    /// Runs the systems of one stage.
    pub fn stage(&mut self, world: &mut World, step: &StepContext, stage: Stage) {
        self.schedule.run_stage(world, step, stage, &mut self.report.systems);
    }
}

/// One dynamic step, in halves where the whole leaves no sound state; in the smallest of them bodies that would create energy are
/// held back. Returns the time \[ms\] that was done: all of `dt`, or less where even the smallest part failed.
pub(super) fn advance(
    world: &mut World,
    settings: &Settings,
    time: f64,
    dt: f64,
    halvings: u32,
    running: &mut Running,
) -> f64 {
    let step = StepContext::of_step(settings, dt, time + dt);
    if solve_and_tear(world, &step, settings.resumes, running) {
        return dt;
    }
    restore(world);
    running.report.rolled_back += 1;
    if halvings == 0 {
        let last_resort = StepContext { is_last_resort: true, ..step };
        if solve_and_tear(world, &last_resort, settings.resumes, running) {
            return dt;
        }
        restore(world);
        return 0.0;
    }
    let half = 0.5 * dt;
    let first = advance(world, settings, time, half, halvings - 1, running);
    if first < half {
        return first;
    }
    half + advance(world, settings, time + half, half, halvings - 1, running)
}

/// Solves the step and tears, and takes the step up again while tips may advance further. Whether every solve has left a sound state.
fn solve_and_tear(world: &mut World, step: &StepContext, resumes: u32, running: &mut Running) -> bool {
    for resumed in 0..=resumes {
        let step = StepContext { is_resumed: resumed > 0, ..*step };
        iterate(world, &step, running);
        if !is_sound(world) {
            return false;
        }
        for round in 0..=CONTACT_ROUNDS {
            if step.newton_iterations > 1 || !contact::take_up_again(world) {
                break;
            }
            if round == CONTACT_ROUNDS {
                contact::put_outside(world, &step);
                break;
            }
            run_iteration(world, &step, running);
            if !is_sound(world) {
                return false;
            }
        }
        running.stage(world, &step, Stage::Decide);
        if step.newton_iterations == 1 && take_up_again_for_tears(world, &step) {
            run_iteration(world, &decisive(step), running);
            if !is_sound(world) {
                return false;
            }
            running.stage(world, &step, Stage::Decide);
        }
        running.stage(world, &step, Stage::Account);
        running.stage(world, &step, Stage::Tear);
        if running.schedule.has_late_callers() && !is_finite(world) {
            return false;
        }
        if !world.query_mut::<&TearDecisions>().into_iter().any(|decisions| decisions.may_advance_further) {
            break;
        }
    }
    true
}

/// The step whose solve a tear's advance stands on.
fn decisive(step: StepContext) -> StepContext {
    let stress_tolerance = DECISIVE * step.linear.stress_tolerance;
    StepContext { linear: LinearParams { stress_tolerance, ..step.linear }, ..step }
}

/// A static solve.
pub(super) fn iterate_and_account(world: &mut World, step: &StepContext, running: &mut Running) {
    iterate(world, step, running);
    running.stage(world, step, Stage::Account);
}

/// Solves for all bodies, from the start of the step, stage by stage where it has two, or taken up again in its last stage. A first
/// stage that leaves what is not finite ends it.
pub(super) fn iterate(world: &mut World, step: &StepContext, running: &mut Running) {
    if step.is_resumed {
        running.stage(world, step, Stage::Resume);
    } else if let Some([start, first]) = step.before_last() {
        running.stage(world, &first, Stage::Begin);
        running.stage(world, &start, Stage::Evaluate);
        running.stage(world, &start, Stage::Start);
        solve_stage(world, &first, running);
        if !is_finite(world) {
            return;
        }
        running.stage(world, step, Stage::SecondStage);
    } else {
        running.stage(world, step, Stage::Begin);
    }
    solve_stage(world, step, running);
}

/// Newton's iteration of a step or a stage of it.
fn solve_stage(world: &mut World, step: &StepContext, running: &mut Running) {
    if step.newton_iterations == 1 {
        return run_iteration(world, step, running);
    }
    // The last one of a dynamic step only evaluates what the ones before have reached.
    for _ in 0..=step.newton_iterations {
        running.stage(world, step, Stage::Evaluate);
        running.stage(world, step, Stage::Solve);
        let is_done = |s: &SolverScratch| s.is_converged || s.linear_residual.is_nan();
        if world.query_mut::<&SolverScratch>().into_iter().all(is_done) {
            break;
        }
    }
}

/// The one iteration of a linearly implicit step.
fn run_iteration(world: &mut World, step: &StepContext, running: &mut Running) {
    running.stage(world, step, Stage::Evaluate);
    running.stage(world, step, Stage::Solve);
    for scratch in world.query_mut::<&mut SolverScratch>() {
        scratch.is_converged = scratch.linear_residual.is_finite();
    }
}

/// Leaves only those bodies to be iterated that are going to tear: their tissue asks to, and has not clearly to wait until its tips may
/// go far enough. One linear solve leaves the error of a linearisation over the whole step, or over an advance that springs open: the
/// path of `fig2-tear` then depends on the time step (0.83 mm between 10 and 5 ms); a second one, in the steps that tear, leaves
/// 0.03 mm.
fn take_up_again_for_tears(world: &mut World, step: &StepContext) -> bool {
    type Query<'a> = (
        &'a mut SolverScratch,
        Option<((&'a Vertices, &'a Triangles, &'a Topology), (&'a Tearing, &'a Tips, &'a TearDecisions))>,
    );
    let mut is_any = false;
    for (scratch, tearing) in world.query_mut::<Query>() {
        let tears = tearing.is_some_and(|(tables, tearing)| will_tear(tables, tearing, step));
        scratch.is_converged = !tears;
        is_any |= tears;
    }
    is_any
}

/// Whether every solve and every state is; what sleeps was when it fell asleep.
pub(super) fn is_finite(world: &mut World) -> bool {
    let query = world.query_mut::<(&Vertices, &SolverScratch, Option<&Sleeping>)>();
    query.into_iter().filter(|(.., sleeping)| !sleeping.is_some_and(Sleeping::is_asleep)).all(
        |(vertices, scratch, _)| {
            !scratch.linear_residual.is_nan()
                && vertices.position.iter().zip(&vertices.velocity).all(|(x, v)| x.is_finite() && v.is_finite())
        },
    )
}

/// Whether every state is finite and no solve has created energy.
fn is_sound(world: &mut World) -> bool {
    is_finite(world) && !world.query_mut::<&SolverScratch>().into_iter().any(|scratch| scratch.creates_energy)
}

/// Back to the start of the step.
pub(super) fn restore(world: &mut World) {
    for (vertices, increment, scratch) in world.query_mut::<(&mut Vertices, &mut Increment, &mut SolverScratch)>() {
        if increment.start.len() == vertices.len() {
            vertices.position.copy_from_slice(&increment.start);
            vertices.velocity.copy_from_slice(&increment.start_velocity);
        }
        increment.displacement.fill(DVec3::ZERO);
        scratch.linear_residual = 0.0;
        scratch.left_over = scratch.start_left_over;
        scratch.creates_energy = false;
    }
    world.query_mut::<&mut EnergyAudit>().into_iter().for_each(EnergyAudit::void_step);
}

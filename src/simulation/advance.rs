//! One step of the world: solves, tears, and what is done where it leaves no sound state.

use super::faults::{has_sound, tell_forceps};
use crate::components::{SolverScratch, TearDecisions, Tearing};
use crate::math::elementary;
use crate::report::Report;
use crate::settings::{LinearParams, Settings, Tangent};
use crate::storage::{Tips, Topology, Triangles, Vertices};
use crate::systems::fracture::will_tear;
use crate::systems::step::schedule::{Schedule, Stage};
use crate::systems::{StepContext, contact};
use hecs::{Entity, World};
use smallvec::SmallVec;

/// The error of the stress before a tear advances, as part of that allowed in passing: an advance cannot be taken back, and
/// the error at a tip may be some times that in the body as a whole.
const DECISIVE: f64 = 0.2;

/// So often at the most a step is solved again because a solve has carried vertices into an obstacle.
const CONTACT_ROUNDS: u32 = 4;

/// Parts of a step that are tried at the most for each level of halving: each takes two where it fails once. What is left is then
/// taken as dissipative as can be.
const TRIES: u32 = 3;

/// So many times shorter is the last resort of a body that was held back in the last step already: in a long one soft directions, held
/// by inertia alone, go so far that next to nothing of the way may be gone, of stiff ones neither, and crumpled tissue would stay so.
const SHORTER: f64 = 8.0;

/// So often at the most it is made shorter: to 3 µs of 100 ms.
const MOST_SHORTENINGS: u32 = 5;

/// What a step is run by, and where it is told what it did.
pub(super) struct Running<'a> {
    /// The systems.
    pub schedule: &'a mut Schedule,
    /// Their report.
    pub report: &'a mut Report,
    /// Lists of bodies put aside that are empty again.
    pub spare: &'a mut Vec<Aside>,
}

impl Running<'_> {
    /// Runs the systems of one stage.
    pub(super) fn stage(&mut self, world: &mut World, step: &StepContext, stage: Stage) {
        self.schedule.run_stage(world, step, stage, &mut self.report.systems);
    }

    /// An empty list of bodies.
    fn list(&mut self) -> Aside {
        self.spare.pop().unwrap_or_default()
    }

    /// Whether there are sound bodies to go on with; see [`has_sound`].
    fn may_go_on(&self, world: &mut World, failed: &mut Aside) -> bool {
        !self.schedule.has_refused() && has_sound(world, failed)
    }

    /// Gives the bodies of a list back what their solvers remember, and keeps the list.
    fn give_back(&mut self, world: &mut World, mut list: Aside) {
        for (body, scratch) in list.drain(..) {
            // The body is there: nothing has been despawned.
            let _ = world.insert_one(body, scratch);
        }
        self.spare.push(list);
    }
}

/// Bodies that no system runs on for a while, with the memory of their solvers: without it none does.
pub(super) type Aside = Vec<(Entity, SolverScratch)>;

/// One dynamic step of all bodies. One that it leaves in no sound state is retried by itself, [in halves](Settings::halvings), and the
/// others keep the step that they have taken. Returns the time \[ms\] that was done: all of `dt`, or less where no body has done all of it.
pub(super) fn advance(world: &mut World, settings: &Settings, time: f64, dt: f64, running: &mut Running) -> f64 {
    let step = StepContext::of_step(settings, dt, time + dt);
    let mut failed = running.list();
    let held_back = held_back(world);
    solve_and_tear(world, &step, settings.resumes, running, &mut failed);
    if running.schedule.has_refused() {
        running.give_back(world, failed);
        return 0.0;
    }
    if failed.is_empty() {
        running.spare.push(failed);
        return dt;
    }
    let mut done = running.list();
    put_all_aside(world, &mut done);
    let mut most = if done.is_empty() { 0.0 } else { dt };
    for (body, scratch) in failed.drain(..) {
        // As in `give_back`.
        let _ = world.insert_one(body, scratch);
        let mut retried = Retried { world, settings, running, tries: 0, is_last_resort: false };
        // What could not go all of its way even in the smallest part of the last step is not tried in parts again.
        let before = held_back.iter().find(|(held, _)| *held == body).map(|(_, shortenings)| *shortenings);
        let gone = match before {
            Some(shortenings) => retried.at_its_end(time, dt, shortenings),
            None => retried.in_halves(time, dt, settings.halvings),
        };
        most = gone.max(most);
        if let (Some(before), Ok(scratch)) = (before, world.query_one_mut::<&mut SolverScratch>(body)) {
            scratch.shortenings = if scratch.is_held_back { before + 1 } else { before.saturating_sub(1) };
        }
        put_all_aside(world, &mut done);
    }
    running.give_back(world, failed);
    running.give_back(world, done);
    // The parts have moved them too.
    contact::move_obstacles(world, &StepContext::of_step(settings, dt, time + most));
    tell_forceps(world);
    most
}

/// A body whose step has failed, while the others wait.
struct Retried<'a, 'b> {
    world: &'a mut World,
    settings: &'a Settings,
    running: &'a mut Running<'b>,
    /// Parts that have been tried.
    tries: u32,
    /// Whether the smallest part has had to be as dissipative as can be, or there have been tries enough: what is left of the step is
    /// so at once, in as few parts as there can be.
    is_last_resort: bool,
}

impl Retried<'_, '_> {
    /// Two halves of what has failed. Returns the time that was done.
    fn in_halves(&mut self, time: f64, dt: f64, halvings: u32) -> f64 {
        self.running.report.rolled_back += 1;
        if halvings == 0 || is_used_up(self.world, self.settings.budget) {
            self.is_last_resort = true;
            return self.part(time, dt, 0);
        }
        let half = 0.5 * dt;
        let first = self.part(time, half, halvings - 1);
        if first < half { first } else { half + self.part(time + half, half, halvings - 1) }
    }

    /// A last resort at the end of the step, before which the body stands. Returns the time that was done.
    fn at_its_end(&mut self, time: f64, dt: f64, shortenings: u32) -> f64 {
        self.running.report.rolled_back += 1;
        self.is_last_resort = true;
        let length = dt / elementary::powi(SHORTER, shortenings);
        if self.part(time + (dt - length), length, 0) > 0.0 { dt } else { 0.0 }
    }

    /// A part of the step. Returns the time that was done.
    fn part(&mut self, time: f64, dt: f64, halvings: u32) -> f64 {
        let step = StepContext { is_retried: true, ..StepContext::of_step(self.settings, dt, time + dt) };
        self.tries += 1;
        self.is_last_resort |= self.tries > TRIES * (self.settings.halvings + 1);
        let step = if self.is_last_resort { step.last_resort() } else { step };
        let mut failed = self.running.list();
        solve_and_tear(self.world, &step, self.settings.resumes, self.running, &mut failed);
        let is_sound = failed.is_empty();
        self.running.give_back(self.world, failed);
        if self.running.schedule.has_refused() {
            return 0.0;
        }
        if is_sound {
            return dt;
        }
        if self.is_last_resort { 0.0 } else { self.in_halves(time, dt, halvings) }
    }
}

/// The bodies that went only a part of their way in the last step, or a shorter one, with how often it was made shorter. That is taken
/// off them: of one that goes all of its way at once nothing is left.
fn held_back(world: &mut World) -> SmallVec<[(Entity, u32); 4]> {
    let bodies = world.query_mut::<(Entity, &mut SolverScratch)>().into_iter();
    let held_back = bodies.filter(|(_, scratch)| scratch.is_held_back || scratch.shortenings > 0);
    let shortenings = |scratch: &mut SolverScratch| std::mem::take(&mut scratch.shortenings).min(MOST_SHORTENINGS);
    held_back.map(|(body, scratch)| (body, shortenings(scratch))).collect()
}

/// Takes what solvers remember off all bodies.
fn put_all_aside(world: &mut World, list: &mut Aside) {
    let bodies = world.query_mut::<(Entity, &SolverScratch)>().into_iter();
    let bodies: SmallVec<[Entity; 16]> = bodies.map(|(body, _)| body).collect();
    list.extend(bodies.into_iter().filter_map(|body| Some((body, world.remove_one::<SolverScratch>(body).ok()?))));
}

/// Solves the step and tears, and takes the step up again while tips may advance further. Bodies that a solve leaves in no sound state
/// are set back and put aside.
fn solve_and_tear(world: &mut World, step: &StepContext, resumes: u32, running: &mut Running, failed: &mut Aside) {
    for resumed in 0..=resumes {
        let step = StepContext { is_resumed: resumed > 0, ..*step };
        iterate(world, &step, running, failed);
        if !running.may_go_on(world, failed) {
            return;
        }
        for round in 0..=CONTACT_ROUNDS {
            if step.newton_iterations > 1 || !contact::take_up_again(world, &step) {
                break;
            }
            if round == CONTACT_ROUNDS {
                contact::put_outside(world, &step);
                if !running.may_go_on(world, failed) {
                    return;
                }
                break;
            }
            run_iteration(world, &step, running);
            if !running.may_go_on(world, failed) {
                return;
            }
        }
        contact::keep_sides(world, &step);
        running.stage(world, &step, Stage::Decide);
        if step.newton_iterations == 1 && take_up_again_for_tears(world, &step) {
            run_iteration(world, &decisive(step), running);
            if !running.may_go_on(world, failed) {
                return;
            }
            contact::keep_sides(world, &step);
            running.stage(world, &step, Stage::Decide);
        }
        running.stage(world, &step, Stage::Account);
        running.stage(world, &step, Stage::Tear);
        if running.schedule.has_late_callers() && !running.may_go_on(world, failed) {
            return;
        }
        let mut decisions = world.query_mut::<(&TearDecisions, &SolverScratch)>().into_iter();
        if !decisions.any(|(decisions, _)| decisions.may_advance_further) || is_used_up(world, step.budget) {
            return;
        }
    }
}

/// Whether a body has used up what iterations it may take in the step.
fn is_used_up(world: &mut World, budget: Option<u32>) -> bool {
    budget.is_some_and(|budget| world.query_mut::<&SolverScratch>().into_iter().any(|scratch| scratch.work >= budget))
}

/// The step whose solve a tear's advance stands on.
fn decisive(step: StepContext) -> StepContext {
    let stress_tolerance = DECISIVE * step.linear.stress_tolerance;
    StepContext { linear: LinearParams { stress_tolerance, ..step.linear }, ..step }
}

/// A static solve.
pub(super) fn iterate_and_account(world: &mut World, step: &StepContext, running: &mut Running) {
    // Only a first stage puts bodies aside, and a static solve has none.
    iterate(world, step, running, &mut Aside::new());
    running.stage(world, step, Stage::Account);
}

/// Solves for all bodies, from the start of the step, stage by stage where it has two, or taken up again in its last stage. A first
/// stage that leaves bodies in no sound state puts them aside.
fn iterate(world: &mut World, step: &StepContext, running: &mut Running, failed: &mut Aside) {
    if step.is_resumed {
        running.stage(world, step, Stage::Resume);
    } else if let Some([start, first]) = step.before_last() {
        running.stage(world, &first, Stage::Begin);
        running.stage(world, &start, Stage::Evaluate);
        running.stage(world, &start, Stage::Start);
        solve_stage(world, &first, running);
        if !running.may_go_on(world, failed) {
            return;
        }
        running.stage(world, step, Stage::SecondStage);
    } else {
        running.stage(world, step, Stage::Begin);
    }
    solve_stage(world, step, running);
    running.stage(world, step, Stage::Judge);
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

/// The one iteration of a linearly implicit step, and further ones of bodies that it would let create energy.
fn run_iteration(world: &mut World, step: &StepContext, running: &mut Running) {
    running.stage(world, step, Stage::Evaluate);
    running.stage(world, step, Stage::Solve);
    for corrections in (0..step.corrections).rev() {
        let mut is_any = false;
        for scratch in world.query_mut::<&mut SolverScratch>() {
            scratch.is_converged = scratch.to_correct.is_none();
            is_any |= !scratch.is_converged;
        }
        if !is_any {
            break;
        }
        let step = StepContext { corrections, is_correction: true, tangent: Tangent::Projected, ..*step };
        running.stage(world, &step, Stage::Evaluate);
        running.stage(world, &step, Stage::Solve);
    }
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

//! Retry of a step: bodies left in no sound state repeat it in halves, and at last take a fallback sub-step.

use super::faults::report_to_forceps;
use super::phases::PHASES;
use super::run::{Excluded, Running};
use crate::components::{GuardLedger, SolveResult};
use crate::settings::Settings;
use crate::systems::forces;
use crate::systems::{StepContext, contact, work};
use hecs::{Entity, World};
use smallvec::SmallVec;

/// Factor on the levels of halving: the attempts at a step, in total, before fallback sub-steps take the rest.
const TRIES: u32 = 3;

/// One dynamic step of all bodies. One that it leaves in no sound state is retried by itself, [in halves](crate::settings::Advanced::max_step_halvings), and the
/// others keep the step that they have taken. Returns the time \[ms\] that the farthest body has done; one that
/// failed midway stays where its last good part ended.
pub fn advance(world: &mut World, settings: &Settings, time: f64, dt: f64, running: &mut Running) -> f64 {
    let mut failed = running.list();
    let step_limited = step_limited(world);
    let step = StepContext::of_step(settings, dt, time + dt);
    let step = if step_limited.is_empty() { step } else { step.before(1) };
    running.step(world, &step, PHASES, &mut failed);
    forces::end(world, !running.schedule.has_invalid_caller_data());
    if running.schedule.has_invalid_caller_data() {
        running.give_back(world, failed);
        running.report.rolled_back += contact::rigid::end(world, time);
        return 0.0;
    }
    if failed.is_empty() {
        running.spare.push(failed);
        running.report.rolled_back += contact::rigid::end(world, time + dt);
        return dt;
    }
    let mut done = running.list();
    exclude_all(world, &mut done);
    let mut most = if done.is_empty() { 0.0 } else { dt };
    let groups = contact::layers::lists(world);
    while !failed.is_empty() {
        let group = groups.iter().find(|group| group.contains(&failed[0].0));
        let first = failed[0].0;
        let is_of_group = |body: Entity| body == first || group.is_some_and(|group| group.contains(&body));
        let (mut bodies, mut place) = (SmallVec::<[Entity; 4]>::new(), 0);
        while place < failed.len() {
            if !is_of_group(failed[place].0) {
                place += 1;
                continue;
            }
            let (body, result) = failed.remove(place);
            bodies.push(body);
            // As in `give_back`.
            let _ = world.insert_one(body, result);
        }
        let mut retried =
            Retried { world, settings, running, tries: 0, reserved: 0, is_fallback: false, is_spent: false };
        // A body that was step-limited in the last step is not retried in halves.
        let gone = if bodies.iter().any(|body| step_limited.contains(body)) {
            retried.running.report.rolled_back += 1;
            retried.fallback(time, dt)
        } else {
            retried.in_halves(time, dt, settings.advanced.max_step_halvings)
        };
        most = gone.max(most);
        let is_spent = retried.is_spent;
        for body in bodies {
            if let Ok(ledger) = world.query_one_mut::<&mut GuardLedger>(body) {
                ledger.is_step_limited |= is_spent && gone == 0.0;
            }
        }
        exclude_all(world, &mut done);
    }
    running.give_back(world, failed);
    running.give_back(world, done);
    // Retried parts have moved the obstacles to other times.
    contact::move_obstacles(world, &StepContext::of_step(settings, dt, time + most));
    running.report.rolled_back += contact::rigid::end(world, time + most);
    report_to_forceps(world);
    most
}

/// Retry of one body whose step has failed; all others are excluded.
struct Retried<'a, 'b> {
    world: &'a mut World,
    settings: &'a Settings,
    running: &'a mut Running<'b>,
    /// Parts that have been tried.
    tries: u32,
    /// Later parts of the step, whose solves the budget reserves.
    reserved: u32,
    /// Whether the rest of the step is taken by fallback sub-steps: the smallest part needed one, or the attempts are used up.
    is_fallback: bool,
    /// Whether the budget has kept a part from being tried.
    is_spent: bool,
}

impl Retried<'_, '_> {
    /// Retries a failed step in two halves. Returns the time that was done.
    fn in_halves(&mut self, time: f64, dt: f64, halvings: u32) -> f64 {
        self.running.report.rolled_back += 1;
        let is_afforded = work::all_afford(self.world, &self.context(time, dt), 2);
        self.is_spent |= !is_afforded;
        if halvings == 0 || !is_afforded {
            return self.fallback(time, dt);
        }
        let half = 0.5 * dt;
        self.reserved += 1;
        let first = self.part(time, half, halvings - 1);
        self.reserved -= 1;
        if first < half { first } else { half + self.part(time + half, half, halvings - 1) }
    }

    /// A fallback sub-step, if the budget allows one. Returns the time that was done.
    fn fallback(&mut self, time: f64, dt: f64) -> f64 {
        self.is_fallback = true;
        if work::all_afford(self.world, &self.context(time, dt), 1) {
            return self.part(time, dt, 0);
        }
        self.is_spent = true;
        0.0
    }

    /// Context of a part of the step, with solves reserved for the parts after it.
    fn context(&self, time: f64, dt: f64) -> StepContext {
        StepContext { reserved: self.reserved, ..StepContext::of_step(self.settings, dt, time + dt) }
    }

    /// A part of the step. Returns the time that was done.
    fn part(&mut self, time: f64, dt: f64, halvings: u32) -> f64 {
        let step = StepContext { is_retried: true, ..self.context(time, dt) };
        self.tries += 1;
        self.is_fallback |= self.tries > TRIES * (self.settings.advanced.max_step_halvings + 1);
        let step = if self.is_fallback { step.fallback() } else { step };
        let mut failed = self.running.list();
        self.running.step(self.world, &step, PHASES, &mut failed);
        forces::end(self.world, !self.running.schedule.has_invalid_caller_data());
        let is_sound = failed.is_empty();
        self.running.give_back(self.world, failed);
        if self.running.schedule.has_invalid_caller_data() {
            return 0.0;
        }
        if is_sound {
            return dt;
        }
        if self.is_fallback { 0.0 } else { self.in_halves(time, dt, halvings) }
    }
}

/// Bodies that the last step has limited.
fn step_limited(world: &mut World) -> SmallVec<[Entity; 4]> {
    let bodies = world.query_mut::<(Entity, &GuardLedger)>().into_iter();
    bodies.filter(|(_, ledger)| ledger.is_step_limited).map(|(body, _)| body).collect()
}

/// Takes the result of their solves off all bodies, so that no system runs on them.
fn exclude_all(world: &mut World, list: &mut Excluded) {
    let bodies = world.query_mut::<(Entity, &SolveResult)>().into_iter();
    let bodies: SmallVec<[Entity; 16]> = bodies.map(|(body, _)| body).collect();
    list.extend(bodies.into_iter().filter_map(|body| Some((body, world.remove_one::<SolveResult>(body).ok()?))));
}

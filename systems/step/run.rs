//! Runs the phases of a step.

use super::faults::roll_back_unsound;
use super::phases::{Loop, Phase};
use super::schedule::{Schedule, Stage};
use crate::components::SolveResult;
use crate::report::Report;
use crate::systems::StepContext;
use hecs::{Entity, World};
use std::ops::ControlFlow;

/// Schedule, report and spare lists with which a step is run.
pub struct Running<'a> {
    /// Schedule of the systems.
    pub schedule: &'a mut Schedule,
    /// Report of the systems.
    pub report: &'a mut Report,
    /// Empty lists of excluded bodies, kept for reuse.
    pub spare: &'a mut Vec<Excluded>,
}

impl Running<'_> {
    /// Runs the systems of one stage. Returns the number of bodies that the engine's ran on.
    pub fn stage(&mut self, world: &mut World, step: &StepContext, stage: Stage) -> usize {
        self.schedule.run_stage(world, step, stage, &mut self.report.systems)
    }

    /// Runs a step. Bodies that a solve leaves in no sound state are set back and excluded into `failed`.
    pub fn step(&mut self, world: &mut World, step: &StepContext, phases: &[Phase], failed: &mut Excluded) {
        // Where it ended early, no sound body was left or a caller wrote invalid data.
        let _ = self.phases(world, step, phases, failed);
    }

    fn phases(
        &mut self,
        world: &mut World,
        step: &StepContext,
        phases: &[Phase],
        failed: &mut Excluded,
    ) -> ControlFlow<()> {
        for phase in phases {
            match phase {
                Phase::Run(stage) => _ = self.stage(world, step, *stage),
                Phase::Check => self.check(world, failed)?,
                Phase::CheckCallers if self.schedule.has_late_callers() => self.check(world, failed)?,
                Phase::Group(phases) => self.phases(world, step, phases, failed)?,
                Phase::When(asks, phases) if asks(step) => self.phases(world, step, phases, failed)?,
                Phase::With(context, phases) => self.phases(world, &context(step), phases, failed)?,
                Phase::While(rounds) => self.rounds(world, step, (rounds, 0), failed)?,
                Phase::AtLeastOnce(rounds) => {
                    self.phases(world, &(rounds.context)(step, 0), rounds.phases, failed)?;
                    self.rounds(world, step, (rounds, 1), failed)?;
                }
                Phase::CheckCallers | Phase::When(..) => {}
            }
        }
        ControlFlow::Continue(())
    }

    /// Runs a loop of which `made` rounds were made already.
    fn rounds(
        &mut self,
        world: &mut World,
        step: &StepContext,
        (rounds, made): (&Loop, u32),
        failed: &mut Excluded,
    ) -> ControlFlow<()> {
        let most = made + (rounds.most)(step);
        for round in made..most {
            if self.stage(world, step, rounds.needed) == 0 {
                return ControlFlow::Continue(());
            }
            self.phases(world, &(rounds.context)(step, round), rounds.phases, failed)?;
        }
        if !rounds.used_up.is_empty() && self.stage(world, step, rounds.needed) > 0 {
            self.phases(world, step, rounds.used_up, failed)?;
        }
        ControlFlow::Continue(())
    }

    /// Ends the step where no sound body is left or a caller's system has written invalid data.
    fn check(&self, world: &mut World, failed: &mut Excluded) -> ControlFlow<()> {
        let may_go_on = !self.schedule.has_invalid_caller_data() && roll_back_unsound(world, failed);
        if may_go_on { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    }

    /// An empty list of bodies.
    pub(super) fn list(&mut self) -> Excluded {
        self.spare.pop().unwrap_or_default()
    }

    /// Reinstates the excluded bodies of a list, and keeps the empty list.
    pub(super) fn give_back(&mut self, world: &mut World, mut list: Excluded) {
        for (body, result) in list.drain(..) {
            // The body is there: nothing has been despawned.
            let _ = world.insert_one(body, result);
        }
        self.spare.push(list);
    }
}

/// Excluded bodies with their solve results: no system runs on a body without one.
pub type Excluded = Vec<(Entity, SolveResult)>;

//! The systems of one simulation: those of [`STEP`], and the caller's own between them.

use super::{STEP, Stage};
use crate::clock::Moment;
use crate::registry::{Rejected, validate_all};
use crate::report::SystemReport;
use crate::systems::StepContext;
use hecs::World;
use std::time::Duration;

/// Place of a system of your own in the step: it runs in the stage of the system that is named.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place<'a> {
    /// Right before the system of this name.
    Before(&'a str),
    /// Right after the system of this name, and after the systems put there earlier.
    After(&'a str),
}

/// Reason why a system was not put in or taken out.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum BadPlace {
    /// No system has this name.
    #[error("there is no system `{name}`; did you mean `{nearest}`?")]
    NoSuchSystem {
        /// The name.
        name: String,
        /// The nearest name that there is.
        nearest: &'static str,
    },
    /// Two systems of one name could not be distinguished in reports and places.
    #[error("there is a system `{0}` already: give yours another name")]
    NameTaken(&'static str),
    /// The engine's own systems stay.
    #[error("`{0}` is one of the engine's systems, which stay; leave out the component that it works on")]
    OfTheEngine(&'static str),
}

type CallersRun = Box<dyn FnMut(&mut World, &StepContext) -> usize + Send + Sync>;

enum Run {
    Engines(fn(&mut World, &StepContext) -> usize),
    Callers(CallersRun),
}

struct Entry {
    name: &'static str,
    stage: Stage,
    run: Run,
}

/// The systems of a simulation in their order.
pub struct Schedule {
    entries: Vec<Entry>,
    /// Rejection of data written by a system of the caller's, and whether the step had begun to move by then.
    rejected: Option<(Rejected, bool)>,
}

impl Default for Schedule {
    /// [`STEP`].
    fn default() -> Self {
        let entry = |s: &super::System| Entry { name: s.name, stage: s.stage, run: Run::Engines(s.run) };
        Self { entries: STEP.iter().map(entry).collect(), rejected: None }
    }
}

impl Schedule {
    /// Puts a system in.
    ///
    /// # Errors
    /// If the name is taken, or the place does not exist.
    pub fn insert(
        &mut self,
        place: Place<'_>,
        name: &'static str,
        run: impl FnMut(&mut World, &StepContext) -> usize + Send + Sync + 'static,
    ) -> Result<(), BadPlace> {
        if self.entries.iter().any(|entry| entry.name == name) {
            return Err(BadPlace::NameTaken(name));
        }
        let (at, stage) = match place {
            Place::Before(named) => {
                let row = self.find(named)?;
                (row, self.entries[row].stage)
            }
            Place::After(named) => {
                let row = self.find(named)?;
                let stage = self.entries[row].stage;
                let is_callers = |entry: &&Entry| matches!(entry.run, Run::Callers(_)) && entry.stage == stage;
                (row + 1 + self.entries[row + 1..].iter().take_while(is_callers).count(), stage)
            }
        };
        self.entries.insert(at, Entry { name, stage, run: Run::Callers(Box::new(run)) });
        Ok(())
    }

    /// Takes a system out that was put in.
    ///
    /// # Errors
    /// If no system has the name, or it is a system of the engine.
    pub fn remove(&mut self, name: &str) -> Result<(), BadPlace> {
        let row = self.find(name)?;
        if matches!(self.entries[row].run, Run::Engines(_)) {
            return Err(BadPlace::OfTheEngine(self.entries[row].name));
        }
        self.entries.remove(row);
        Ok(())
    }

    /// Names and stages, in the order in which they run within a stage.
    pub fn systems(&self) -> impl Iterator<Item = (&'static str, Stage)> {
        self.entries.iter().map(|entry| (entry.name, entry.stage))
    }

    /// Whether a system of the caller runs after the fault check of the solve.
    pub(crate) fn has_late_callers(&self) -> bool {
        let is_late = |stage| {
            matches!(stage, Stage::Decide | Stage::Advancing | Stage::Account | Stage::Tear | Stage::Unfinished)
        };
        self.entries.iter().any(|entry| is_late(entry.stage) && matches!(entry.run, Run::Callers(_)))
    }

    /// Whether there are systems of the caller's.
    pub(crate) fn has_callers(&self) -> bool {
        self.entries.len() > STEP.len()
    }

    /// Whether a system of the caller's has written rejected data: no system runs any more until the rejection was taken.
    pub(crate) fn has_invalid_caller_data(&self) -> bool {
        self.rejected.is_some()
    }

    /// Takes the rejection, and whether the step had begun to move by then.
    pub(crate) fn take_rejected(&mut self) -> Option<(Rejected, bool)> {
        self.rejected.take()
    }

    /// Runs the systems of one stage in order and adds their times and counts to `reports`, which has one entry per system. Returns the
    /// number of bodies that the engine's own ran on.
    pub fn run_stage(
        &mut self,
        world: &mut World,
        step: &StepContext,
        stage: Stage,
        reports: &mut [SystemReport],
    ) -> usize {
        let (mut has_begun, mut count) = (stage != Stage::Begin, 0);
        for (entry, report) in self.entries.iter_mut().zip(reports).filter(|(entry, _)| entry.stage == stage) {
            if self.rejected.is_some() {
                return 0;
            }
            let start = Moment::now();
            has_begun |= entry.name == "hold";
            let bodies = match &mut entry.run {
                Run::Engines(run) => {
                    let bodies = run(world, step);
                    count += bodies;
                    bodies
                }
                Run::Callers(run) => {
                    let bodies = run(world, step);
                    self.rejected = validate_all(world).err().map(|rejected| (rejected, has_begun));
                    bodies
                }
            };
            if bodies > 0 {
                report.bodies += bodies;
                report.time += start.elapsed();
            }
        }
        count
    }

    /// Empties `reports` and gives it one entry per system.
    pub fn reset_reports(&self, reports: &mut Vec<SystemReport>) {
        reports.clear();
        let report = |(name, _)| SystemReport { name, bodies: 0, time: Duration::ZERO };
        reports.extend(self.systems().map(report));
    }

    fn find(&self, name: &str) -> Result<usize, BadPlace> {
        self.entries.iter().position(|entry| entry.name == name).ok_or_else(|| {
            let likeness = |entry: &&Entry| strsim::jaro_winkler(name, entry.name);
            let nearest = self.entries.iter().max_by(|a, b| likeness(a).total_cmp(&likeness(b)));
            BadPlace::NoSuchSystem { name: name.to_owned(), nearest: nearest.map_or("", |entry| entry.name) }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(schedule: &Schedule) -> Vec<&'static str> {
        schedule.systems().map(|(name, _)| name).collect()
    }

    #[test]
    fn systems_come_where_they_are_put_and_in_that_order() {
        let mut schedule = Schedule::default();
        let nothing = |_: &mut World, _: &StepContext| 0;
        schedule.insert(Place::After("contact"), "first", nothing).unwrap();
        schedule.insert(Place::After("contact"), "second", nothing).unwrap();
        schedule.insert(Place::Before("solve"), "last", nothing).unwrap();
        let all = names(&schedule);
        let at = all.iter().position(|name| *name == "contact").unwrap();
        assert_eq!(all[at..at + 4], ["contact", "first", "second", "layers: push apart"]);
        let solve = all.iter().position(|name| *name == "solve").unwrap();
        assert_eq!(all[solve - 1], "last");
        assert_eq!(schedule.entries[solve - 1].stage, Stage::Solve);
        schedule.remove("second").unwrap();
        assert_eq!(names(&schedule).len(), STEP.len() + 2);
    }

    #[test]
    fn what_is_not_there_is_named_with_the_nearest_that_is() {
        let mut schedule = Schedule::default();
        let nothing = |_: &mut World, _: &StepContext| 0;
        let unknown = schedule.insert(Place::Before("slove"), "mine", nothing).unwrap_err();
        assert_eq!(unknown.to_string(), "there is no system `slove`; did you mean `solve`?");
        assert_eq!(schedule.insert(Place::After("solve"), "grip", nothing), Err(BadPlace::NameTaken("grip")));
        assert_eq!(schedule.remove("solve"), Err(BadPlace::OfTheEngine("solve")));
        assert!(schedule.remove("mine").is_err() && names(&schedule).len() == STEP.len());
    }
}

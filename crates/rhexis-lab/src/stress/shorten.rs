//! Makes the recording of a failed case short: a later start, fewer inputs, fewer bodies, as long as it fails the same way.

use super::invariants::{self, Ledger};
use super::{Broken, FailureKind, again};
use rhexis::replay::{Input, Recording};
use rhexis::settings::Settings;
use rhexis::simulation::Simulation;
use rhexis::snapshot::{Snapshot, StateHash};
use rhexis::storage::BodyId;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// So many recordings are tried at the most.
const TRIES: u32 = 150;

/// So many steps are taken for that at the most, but for a last try.
const STEPS: u32 = 4000;

/// What is tried.
#[derive(Clone)]
struct Candidate {
    start: Snapshot,
    inputs: Vec<Input>,
}

/// How a candidate fails: with this input, and the hash then, which there is none of after a panic.
struct Failed {
    input: usize,
    hash: Option<StateHash>,
}

/// Tries shorter and shorter recordings.
struct Shortener {
    is_free: bool,
    kind: FailureKind,
    tries: u32,
    steps: u32,
}

/// A short recording that fails the same way; `None` where the whole one does not when it is repeated.
pub(super) fn shorten(recording: &Recording, is_free: bool, kind: FailureKind) -> Option<Recording> {
    let mut shortener = Shortener { is_free, kind, tries: 0, steps: 0 };
    let whole = Candidate { start: recording.start().clone(), inputs: recording.inputs().to_vec() };
    let (mut best, mut failed) = shortener.fails(whole)?;
    let mut take = |shortener: &mut Shortener, best: &mut Candidate, candidate: Candidate| {
        let found = shortener.fails(candidate);
        let is_shorter = found.is_some();
        if let Some(found) = found {
            (*best, failed) = found;
        }
        is_shorter
    };
    // From as late a state as there is that still leads there.
    let mut back = 1;
    while back < best.inputs.len() {
        let candidate = later(&best, best.inputs.len() - back);
        if candidate.is_some_and(|candidate| take(&mut shortener, &mut best, candidate)) {
            break;
        }
        back *= 2;
    }
    // Without inputs that it does not take; the last one, with which it fails, stays.
    let mut size = best.inputs.len() / 2;
    while size > 0 {
        let mut end = best.inputs.len() - 1;
        while end >= size {
            let mut candidate = best.clone();
            candidate.inputs.drain(end - size..end);
            take(&mut shortener, &mut best, candidate);
            end = (end - size).min(best.inputs.len() - 1);
        }
        size /= 2;
    }
    for body in best.start.bodies() {
        if let Some(candidate) = without(&best, body) {
            take(&mut shortener, &mut best, candidate);
        }
    }
    let end = failed.hash.unwrap_or_else(|| recording.end());
    Some(Recording::new(best.start, best.inputs, end))
}

impl Shortener {
    /// The candidate up to its failure, where it fails as it should.
    fn fails(&mut self, mut candidate: Candidate) -> Option<(Candidate, Failed)> {
        let steps = candidate.inputs.iter().filter(|input| matches!(input, Input::Step { .. })).count() as u32;
        if self.tries >= TRIES || self.tries > 0 && self.steps + steps > STEPS {
            return None;
        }
        (self.tries, self.steps) = (self.tries + 1, self.steps + steps);
        let failed = match self.kind {
            FailureKind::Threads => self.differs(&candidate),
            kind => judge(&candidate, self.is_free, kind),
        }?;
        candidate.inputs.truncate(failed.input + 1);
        Some((candidate, failed))
    }

    /// Whether one thread and two end in other states.
    fn differs(&self, candidate: &Candidate) -> Option<Failed> {
        let mut last = None;
        let [one, two] = [1, 2].map(|threads| {
            let mut simulation = Simulation::new(Settings { threads, ..*candidate.start.settings() }).ok()?;
            simulation.restore(&candidate.start).ok()?;
            candidate.inputs.iter().for_each(|input| simulation.repeat(input));
            last = candidate.inputs.len().checked_sub(1);
            Some(simulation.hash())
        });
        (one != two).then_some(Failed { input: last?, hash: one })
    }
}

/// Repeats a candidate and judges every step, up to the first failure of the kind.
fn judge(candidate: &Candidate, is_free: bool, kind: FailureKind) -> Option<Failed> {
    let mut at = 0;
    let course = catch_unwind(AssertUnwindSafe(|| {
        let mut simulation = Simulation::from_snapshot(&candidate.start).ok()?;
        let mut ledgers: Vec<(BodyId, Ledger)> =
            candidate.start.bodies().into_iter().map(|body| (body, Ledger::new(&simulation, body))).collect();
        for (i, input) in candidate.inputs.iter().enumerate() {
            at = i;
            let broken = repeat(&mut simulation, input, &mut ledgers, is_free, kind);
            if let Some((found, _)) = broken {
                return (found == kind).then(|| Failed { input: i, hash: Some(simulation.hash()) });
            }
        }
        None
    }));
    match course {
        Ok(failed) => failed,
        Err(_) => (kind == FailureKind::Panic).then_some(Failed { input: at, hash: None }),
    }
}

/// Repeats an input; what is broken then.
fn repeat(
    simulation: &mut Simulation,
    input: &Input,
    ledgers: &mut [(BodyId, Ledger)],
    is_free: bool,
    kind: FailureKind,
) -> Option<Broken> {
    let Input::Step { dt, .. } = input else {
        simulation.repeat(input);
        ledgers.iter_mut().for_each(|(_, ledger)| ledger.forget_energy());
        return None;
    };
    let is_kept = matches!(kind, FailureKind::Snapshot | FailureKind::Restore);
    let before = is_kept.then(|| simulation.snapshot());
    if let Err(error) = simulation.step(*dt) {
        return Some((FailureKind::Refused, error.to_string()));
    }
    let judged = ledgers.iter_mut().find_map(|(body, ledger)| invariants::broken(simulation, is_free, *body, ledger));
    judged.or_else(|| again(&before?, *dt, simulation.hash()).err())
}

/// The candidate from the state after so many inputs on.
fn later(candidate: &Candidate, first: usize) -> Option<Candidate> {
    let run = || {
        let mut simulation = Simulation::from_snapshot(&candidate.start).ok()?;
        candidate.inputs[..first].iter().for_each(|input| simulation.repeat(input));
        Some(Candidate { start: simulation.snapshot(), inputs: candidate.inputs[first..].to_vec() })
    };
    catch_unwind(AssertUnwindSafe(run)).ok().flatten()
}

/// The candidate without a body from the start on.
fn without(candidate: &Candidate, body: BodyId) -> Option<Candidate> {
    let mut simulation = Simulation::from_snapshot(&candidate.start).ok()?;
    simulation.despawn(body).ok()?;
    Some(Candidate { start: simulation.snapshot(), inputs: candidate.inputs.clone() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhexis::components::{Fibres, Material};
    use rhexis::generate;
    use rhexis::membrane::Membrane;

    #[test]
    fn a_recording_is_cut_down_to_what_fails() {
        let mut simulation = Simulation::new(Settings { threads: 1, ..Settings::default() }).unwrap();
        for name in ["one", "other"] {
            let sheet = Membrane::new(name, generate::grid(4.0, 4.0, 4, 4).unwrap(), Material::allard_2009());
            simulation.spawn(sheet.fibres(Fibres::at_degrees(0.0))).unwrap();
        }
        simulation.record();
        for _ in 0..20 {
            simulation.step(10.0).unwrap();
            simulation.set_velocity(simulation.bodies()[0], |x| x.cross(glam::DVec3::Z) * 0.01).unwrap();
        }
        // Stands for a fault: it is refused whatever comes before.
        simulation.step(-1.0).unwrap_err();
        let recording = simulation.end_recording().unwrap();
        assert!(shorten(&recording, false, FailureKind::Energy).is_none());
        let short = shorten(&recording, false, FailureKind::Refused).unwrap();
        assert_eq!((short.inputs().len(), short.start().bodies().len()), (1, 0));
        let read = Recording::from_bytes(&short.to_bytes().unwrap()).unwrap();
        assert!(read.replay().is_ok());
    }
}

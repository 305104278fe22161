//! Stress: hostile random tools on random scenes, and what must hold after every step.
//!
//! A case is made from a seed and its number alone, so that any can be repeated. It is a scene of sheets, caps, closed
//! surfaces or slivers with random tissue, loads and settings. Steps take 0.01 to 100 ms, and something hostile may happen at
//! each. It ends with its last step or with the first invariant that is broken. What a case has done up to a failure is a
//! [`Recording`]; of that a short one is made that fails the same way.

mod dice;
mod invariants;
mod scene;
mod shorten;
mod surface;
mod tools;

pub(crate) use dice::Dice;
use invariants::Ledger;
use rhexis::event::EventKind;
use rhexis::replay::Recording;
use rhexis::simulation::Simulation;
use rhexis::snapshot::{Snapshot, StateHash};
use rhexis::storage::Triangles;
use scene::{Scene, Traits};
use serde::Serialize;
use shorten::shorten;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;
use tools::Hand;

/// What is broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FailureKind {
    /// A panic.
    Panic,
    /// A position, velocity or energy that is not a finite number.
    NotFinite,
    /// The mesh is no oriented manifold, or tables contradict each other.
    Mesh,
    /// The area in the rest shape has changed.
    Area,
    /// The mass has changed.
    Mass,
    /// A rest angle is below 10° and below the least of the start.
    Angle,
    /// A body on which nothing acts has gained more energy than the engine promises.
    Energy,
    /// A sound call was refused.
    Refused,
    /// A snapshot's bytes were refused.
    Snapshot,
    /// After a snapshot was restored the next step ended in another state.
    Restore,
    /// Another number of threads ended in another state.
    Threads,
}

/// A case that has failed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Failure {
    /// The seed.
    pub seed: u64,
    /// The case's number.
    pub case: u64,
    /// Its step, from 1 on; 0 before the first.
    pub step: u64,
    /// What is broken.
    pub kind: FailureKind,
    /// Where, and how far.
    pub what: String,
}

/// What cases have done.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Counts {
    /// Cases run.
    pub cases: u64,
    /// Steps done.
    pub steps: u64,
    /// Advances of tears, and tears that began.
    pub tears: u64,
    /// Steps, or parts of steps, that were undone and retried.
    pub rollbacks: u64,
    /// Steps that failed, so that the last good state stayed.
    pub failed_steps: u64,
    /// Steps in which a body was step-limited.
    pub step_limited: u64,
    /// The longest step \[ms\].
    pub slowest_step: f64,
    /// The case with it.
    pub slowest_case: u64,
}

impl FailureKind {
    /// All there are.
    pub const ALL: [Self; 11] = [
        Self::Panic,
        Self::NotFinite,
        Self::Mesh,
        Self::Area,
        Self::Mass,
        Self::Angle,
        Self::Energy,
        Self::Refused,
        Self::Snapshot,
        Self::Restore,
        Self::Threads,
    ];
}

impl Counts {
    /// Adds those of another case.
    pub fn add(&mut self, other: &Self) {
        self.cases += other.cases;
        self.steps += other.steps;
        self.tears += other.tears;
        self.rollbacks += other.rollbacks;
        self.failed_steps += other.failed_steps;
        self.step_limited += other.step_limited;
        if other.slowest_step > self.slowest_step {
            (self.slowest_step, self.slowest_case) = (other.slowest_step, other.slowest_case);
        }
    }
}

/// A case that was run.
#[derive(Debug)]
pub struct Outcome {
    /// What it has done.
    pub counts: Counts,
    /// How it has failed.
    pub failure: Option<Failure>,
    /// The run up to the failure, where it was to be recorded.
    pub recording: Option<Recording>,
    /// A short one that fails the same way, from a state on the way there.
    pub short: Option<Recording>,
}

/// Every so many cases one is repeated on two threads.
const TWINS: u64 = 8;

/// Cases of so many triangles take few steps, lest they take most of the time.
const MANY: usize = 100;

/// A case ends at the latest when each of its triangles at each of its steps, added up, come to so many.
const WORK: usize = 3000;

/// No case ends before so many steps for its triangles' sake.
const LEAST: usize = 10;

/// Runs a case; one that fails is run again, recorded, and its recording made short.
pub fn run(seed: u64, case: u64) -> Outcome {
    let (mut outcome, hash, is_free) = run_once(seed, case, 1, false);
    if outcome.failure.is_none() && case.is_multiple_of(TWINS) {
        let (twin, twin_hash, _) = run_once(seed, case, 2, true);
        if twin_hash != hash {
            let what = format!("{hash:?} on one thread, {twin_hash:?} on two");
            let step = outcome.counts.steps;
            outcome.failure = Some(Failure { seed, case, step, kind: FailureKind::Threads, what });
            outcome.recording = twin.recording;
        }
    } else if outcome.failure.is_some() {
        outcome.recording = run_once(seed, case, 1, true).0.recording;
    }
    if let (Some(failure), Some(recording)) = (&outcome.failure, &outcome.recording) {
        outcome.short = shorten(recording, is_free, failure.kind);
    }
    outcome
}

/// Seeds from which on tips glide in most cases: cases of lower ones are named by tests.
const GLIDING: u64 = 10_000;

/// Seeds from which on bodies in space touch themselves.
const TOUCHING: u64 = 20_000;

/// Seeds from which on tissue pushes most obstacles.
const PUSHING: u64 = 30_000;

/// Seeds from which on bodies in space touch each other.
const MEETING: u64 = 40_000;

/// Seeds from which on half of the bodies lie on beds.
const STICKING: u64 = 50_000;

/// Runs a case on so many threads. A panic ends it.
fn run_once(seed: u64, case: u64, threads: usize, is_recorded: bool) -> (Outcome, Option<StateHash>, bool) {
    let mut dice = Dice::new(seed, case);
    let glides = seed >= GLIDING && dice.aside().chance(0.7);
    let mut counts = Counts { cases: 1, slowest_case: case, ..Counts::default() };
    let mut scene = None;
    let traits = Traits {
        glides,
        touches_itself: seed >= TOUCHING,
        pushes: seed >= PUSHING,
        meets: seed >= MEETING,
        sticks: seed >= STICKING,
    };
    let course = catch_unwind(AssertUnwindSafe(|| {
        let refused = |what| (FailureKind::Refused, what);
        let scene = scene.insert(scene::scene(&mut dice, threads, traits).map_err(refused)?);
        if is_recorded {
            scene.simulation.record();
        }
        play(scene, &mut dice, &mut counts)
    }));
    let broken = match course {
        Ok(Ok(())) => None,
        Ok(Err(broken)) => Some(broken),
        Err(payload) => Some((FailureKind::Panic, message(payload.as_ref()))),
    };
    let is_free = scene.as_ref().is_some_and(|scene| scene.is_free);
    let failure = broken.map(|(kind, what)| Failure { seed, case, step: counts.steps, kind, what });
    // After a panic the state may be any.
    let end = catch_unwind(AssertUnwindSafe(|| {
        scene.map(|Scene { mut simulation, .. }| (simulation.hash(), simulation.end_recording()))
    }));
    let (hash, recording) = end.ok().flatten().unzip();
    (Outcome { counts, failure, recording: recording.flatten(), short: None }, hash, is_free)
}

fn message(payload: &(dyn std::any::Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| payload.downcast_ref::<String>().cloned()).unwrap_or_else(|| "no message".to_owned())
}

type Broken = (FailureKind, String);

fn play(scene: &mut Scene, dice: &mut Dice, counts: &mut Counts) -> Result<(), Broken> {
    let mut ledgers: Vec<Ledger> =
        scene.bodies.iter().map(|actor| Ledger::new(&scene.simulation, actor.entity)).collect();
    let mut hand = Hand::default();
    for actor in scene.bodies.clone() {
        (0..dice.below(3)).for_each(|_| tools::cut(&mut scene.simulation, actor.entity, dice));
        let mut aside = dice.aside();
        if aside.chance(0.003) {
            tools::riddle(&mut scene.simulation, actor.entity, &mut aside);
        }
    }
    let is_long = dice.chance(0.05);
    let steps = match (triangle_count(scene), is_long) {
        (MANY.., _) => 10 + dice.below(10),
        (_, true) => 400,
        (_, false) => 10 + dice.below(90),
    };
    let violence = dice.between(0.0, 0.7);
    let mut work = 0;
    for done in 0..steps {
        work += triangle_count(scene);
        if work > WORK && done >= LEAST {
            break;
        }
        let dt = dice.decades(-2.0, 2.0);
        while dice.chance(violence) {
            hand.act(scene, dice, dt);
            ledgers.iter_mut().for_each(Ledger::forget_energy);
        }
        let before = dice.chance(0.1).then(|| scene.simulation.snapshot());
        step(&mut scene.simulation, dt, counts)?;
        for (actor, ledger) in scene.bodies.clone().into_iter().zip(&mut ledgers) {
            let Scene { simulation, is_free, .. } = &mut *scene;
            if let Some(broken) = invariants::broken(simulation, *is_free, actor.entity, ledger) {
                return Err(broken);
            }
        }
        if let Some(before) = before {
            again(&before, dt, scene.simulation.hash())?;
        }
    }
    Ok(())
}

fn triangle_count(scene: &Scene) -> usize {
    let count =
        |actor: &scene::Actor| scene.simulation.world().get::<&Triangles>(actor.entity.entity()).map_or(0, |t| t.len());
    scene.bodies.iter().map(count).sum()
}

fn step(simulation: &mut Simulation, dt: f64, counts: &mut Counts) -> Result<(), Broken> {
    counts.steps += 1;
    let start = Instant::now();
    let report = simulation.step(dt).map_err(|error| (FailureKind::Refused, error.to_string()))?;
    counts.slowest_step = counts.slowest_step.max(start.elapsed().as_secs_f64() * 1e3);
    counts.rollbacks += u64::from(report.rolled_back);
    counts.failed_steps += u64::from(report.has_failed);
    counts.step_limited += u64::from(report.bodies.iter().any(|body| body.is_step_limited));
    let is_tear = |kind: &EventKind| matches!(kind, EventKind::Started { .. } | EventKind::Advanced { .. });
    counts.tears += simulation.drain_events().filter(|event| is_tear(&event.kind)).count() as u64;
    Ok(())
}

/// The step that a state restored from the bytes of a snapshot takes ends where it did.
fn again(before: &Snapshot, dt: f64, expected: StateHash) -> Result<(), Broken> {
    let refused = |error: rhexis::snapshot::SnapshotError| (FailureKind::Snapshot, error.to_string());
    let bytes = before.to_bytes().map_err(refused)?;
    let read = Snapshot::from_bytes(&bytes).map_err(refused)?;
    let mut restored = Simulation::from_snapshot(&read).map_err(refused)?;
    restored.step(dt).map_err(|error| (FailureKind::Refused, error.to_string()))?;
    let found = restored.hash();
    let differs = || (FailureKind::Restore, format!("the next step of {dt} ms ends with {found}, not with {expected}"));
    (found == expected).then_some(()).ok_or_else(differs)
}

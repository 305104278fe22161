//! Soak: the capsulorhexis torn, taken back and begun anew again and again in one process, by a hand that errs.
//!
//! A round has two parts. In the first the hand errs: another place, pull and sway at every grasp, further forceps, punctures, states
//! that are kept and gone back to; every so many rounds the scene is built anew. The second is the same in every round: the state in
//! which the tear has just begun, restored, and the scene's steady hand. It must end in the same state to the bit, take as long and
//! leave as much memory in use as ever: what a round leaves behind, in lists, caches or time, is seen there.

mod hand;
mod verdict;

pub use verdict::{MOST_GROWTH, MOST_SLOWDOWN, Verdict};

use crate::bench::{BenchError, Stopwatch};
use crate::stress::Dice;
use hand::Hand;
use rhexis::event::EventKind;
use rhexis::simulation::Simulation;
use rhexis::snapshot::{Snapshot, StateHash};
use rhexis_scene::{Document, Instance, Scene};
use serde::Serialize;
use stats_alloc::INSTRUMENTED_SYSTEM;

/// Steps in which the tear must have begun.
const BEGINS_WITHIN: u64 = 400;

/// Steps of the second part of a round.
const STEADY: usize = 25;

/// Steps of the first part at the most.
const MOST_ERRING: usize = 80;

/// Every so many rounds the scene is built anew.
const RESTARTS: usize = 8;

/// What a round came to.
#[derive(Clone, Debug, Serialize)]
pub struct Round {
    /// Steps of both parts.
    pub steps: u64,
    /// Advances of tears in both parts.
    pub tears: u64,
    /// States restored.
    pub resets: u64,
    /// Whether the scene was built anew.
    pub is_restart: bool,
    /// The state at its end.
    #[serde(skip)]
    pub hash: StateHash,
    /// Processor time of every steady step \[ms\].
    #[serde(skip)]
    pub step_ms: [f32; STEADY],
    /// On the heap at its end \[bytes\], of the whole process but for the list of rounds; zero in a program whose allocator does not
    /// count.
    pub heap: u64,
    /// Resident at its end \[bytes\], for information, of the whole process; zero where the system does not tell.
    pub resident: u64,
}

/// A soak under way.
pub struct Soak {
    scene: Scene,
    instance: Instance,
    /// The tear has just begun.
    begun: Snapshot,
    progress: (u64, bool),
    dice: Dice,
    rounds: Vec<Round>,
}

impl Soak {
    /// Builds the scene, changed as by `rhexis run --set`, and runs it until its tear begins.
    ///
    /// # Errors
    /// For what is refused in the scene, and if its tear does not begin.
    pub fn new(sets: &[String], seed: u64) -> Result<Self, BenchError> {
        let mut document = Document::named("capsulorhexis")?;
        document.set("run.threads=1")?;
        sets.iter().try_for_each(|assignment| document.set(assignment))?;
        let scene = document.scene()?;
        let mut instance = scene.instantiate()?;
        while advances(&mut instance.simulation) == 0 {
            if instance.step() == BEGINS_WITHIN || instance.is_finished() {
                return Err(BenchError::State(format!("the tear has not begun after {} steps", instance.step())));
            }
            instance.advance()?;
        }
        let (begun, progress) = (instance.simulation.snapshot(), instance.progress());
        Ok(Self { scene, instance, begun, progress, dice: Dice::new(seed, 0), rounds: Vec::new() })
    }

    /// The rounds so far.
    pub fn rounds(&self) -> &[Round] {
        &self.rounds
    }

    /// One more round.
    ///
    /// # Errors
    /// If a sound call is refused.
    pub fn round(&mut self) -> Result<(), BenchError> {
        let mut round = Round {
            steps: 0,
            tears: 0,
            resets: 0,
            is_restart: self.rounds.len().is_multiple_of(RESTARTS),
            hash: StateHash(0),
            step_ms: [0.0; STEADY],
            heap: 0,
            resident: 0,
        };
        if round.is_restart {
            self.instance = self.scene.instantiate()?;
        }
        self.reset(&mut round)?;
        self.err(&mut round)?;
        self.reset(&mut round)?;
        for i in 0..STEADY {
            let watch = Stopwatch::start();
            self.instance.advance()?;
            round.step_ms[i] = watch.elapsed().thread as f32;
            round.steps += 1;
            round.tears += advances(&mut self.instance.simulation);
        }
        round.hash = self.instance.simulation.hash();
        self.rounds.reserve(1);
        let (stats, own) = (INSTRUMENTED_SYSTEM.stats(), self.rounds.capacity() * size_of::<Round>());
        round.heap = stats.bytes_allocated.saturating_sub(stats.bytes_deallocated + own) as u64;
        round.resident = resident().unwrap_or(0);
        self.rounds.push(round);
        Ok(())
    }

    fn reset(&mut self, round: &mut Round) -> Result<(), BenchError> {
        round.resets += 1;
        self.instance.resume(&self.begun, self.progress).map_err(|error| BenchError::State(error.to_string()))
    }

    /// The hand errs for some steps.
    fn err(&mut self, round: &mut Round) -> Result<(), BenchError> {
        let Self { instance, dice, .. } = self;
        let mut hand = Hand::new(instance, dice);
        for _ in 0..5 + dice.below(MOST_ERRING - 5) {
            if instance.is_finished() {
                break;
            }
            round.resets += hand.act(instance, dice);
            instance.advance()?;
            round.steps += 1;
            round.tears += advances(&mut instance.simulation);
        }
        Ok(())
    }
}

/// Advances of tears among the events since the last call.
fn advances(simulation: &mut Simulation) -> u64 {
    simulation.drain_events().filter(|event| matches!(event.kind, EventKind::Advanced { .. })).count() as u64
}

/// Memory of the process that is resident \[bytes\], where Linux tells.
fn resident() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    Some(1024 * line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?)
}

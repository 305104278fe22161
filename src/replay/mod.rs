//! Recordings of a host's calls to a simulation, repeated to the same bits.
//!
//! [`Simulation::record`](crate::simulation::Simulation::record) begins with a snapshot and writes down every call that changes
//! anything, in order:
//! - steps, static solves and cuts;
//! - bodies and obstacles that come and go;
//! - settings and materials;
//! - parameters, positions and velocities changed through [`entity_mut`](crate::simulation::Simulation::entity_mut) and
//!   [`world_mut`](crate::simulation::Simulation::world_mut).
//!
//! [`Recording::replay`] repeats them and compares the hash of the end. Steps whose solves have a limit of time stop where they
//! stopped, whatever the clock says.

#[cfg(feature = "snapshot")]
mod bytes;
mod input;

#[doc(hidden)]
pub use input::{Changes, Input, Materials, Spawned};

use crate::registry::Parameters;
use crate::snapshot::{Snapshot, SnapshotError, StateHash};
use hecs::Entity;

/// Why a recording was not repeated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ReplayError {
    /// The state with which it begins is refused.
    #[error(transparent)]
    Start(#[from] SnapshotError),
    /// The end has another hash: something has changed the simulation that is not recorded, or the arithmetic is another.
    #[error(
        "the replay ends with the hash {found}, the recording with {expected}: something that is not recorded has changed the run, or \
             the machine computes otherwise"
    )]
    Diverged {
        /// Of the recording.
        expected: StateHash,
        /// Of the replay.
        found: StateHash,
    },
}

/// Recorded run: its start, its inputs and its end.
#[derive(Clone)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Recording {
    start: Snapshot,
    inputs: Vec<Input>,
    end: StateHash,
}

impl Recording {
    /// Recording from a start, inputs and an end.
    pub fn new(start: Snapshot, inputs: Vec<Input>, end: StateHash) -> Self {
        Self { start, inputs, end }
    }

    /// The state with which it begins.
    pub fn start(&self) -> &Snapshot {
        &self.start
    }

    /// Inputs, in order.
    pub fn inputs(&self) -> &[Input] {
        &self.inputs
    }

    /// The hash of the state at its end.
    pub fn end(&self) -> StateHash {
        self.end
    }
}

impl std::fmt::Debug for Recording {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { start, inputs, end } = self;
        let mut shown = f.debug_struct("Recording");
        shown.field("start", start).field("inputs", &inputs.len()).field("end", end).finish()
    }
}

/// A recording that is being made.
pub(crate) struct Recorder {
    start: Snapshot,
    inputs: Vec<Input>,
    /// Parameters handed out to be changed, as they were before.
    dirty: Vec<(Entity, Parameters)>,
}

impl Recorder {
    pub(crate) fn new(start: Snapshot) -> Self {
        Self { start, inputs: Vec::new(), dirty: Vec::new() }
    }

    /// Writes an input down.
    pub(crate) fn note(&mut self, input: Input) {
        self.inputs.push(input);
    }

    /// Before an entity is handed out to be changed.
    pub(crate) fn lend(&mut self, entity: Entity, before: Parameters) {
        self.dirty.push((entity, before));
    }

    /// Parameters handed out since the last input, as they were before.
    pub(crate) fn take_lent(&mut self) -> Vec<(Entity, Parameters)> {
        std::mem::take(&mut self.dirty)
    }

    /// Where the solves of the step that was written down last have stopped.
    pub(crate) fn note_stops(&mut self, taken: Vec<Vec<u32>>) {
        if let Some(Input::Step { stops, .. }) = self.inputs.last_mut() {
            *stops = taken;
        }
    }

    pub(crate) fn finish(self, end: StateHash) -> Recording {
        Recording { start: self.start, inputs: self.inputs, end }
    }
}

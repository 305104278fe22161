//! The whole state of a simulation, to go back to and to go on from.
//!
//! [`Simulation::snapshot`](crate::simulation::Simulation::snapshot) takes one, in memory; clones of it share its contents. With
//! the crate's feature `snapshot` it has a form as bytes and as a file, versioned and guarded by a checksum. A simulation that
//! [goes back](crate::simulation::Simulation::restore) to a snapshot goes on from it to the same bits as the one it was taken of,
//! in the middle of a tear too. Handles and keys stay valid, and the solvers' memory from step to step is kept as well.
//! Of that memory, only data that do not follow from the rest are kept. Cholesky factors are rebuilt from their matrix, and multigrid
//! levels from the mesh, the choice of their nodes and the numbers of the finest one. Charts and discs at tips follow from the rest shape.
//!
//! Saved components are one list, in `src/registry/mod.rs`. Your own components are not in it: on entities that live on they stay as
//! they are, in bytes they are not.

#[cfg(feature = "snapshot")]
pub(crate) mod bytes;
#[cfg(feature = "snapshot")]
mod check;
mod error;
#[cfg(feature = "snapshot")]
mod factor;
pub(crate) mod hash;
#[cfg(feature = "snapshot")]
mod migrate;
mod saved;
#[cfg(feature = "snapshot")]
pub(crate) mod settings;
#[cfg(feature = "snapshot")]
mod solve;
mod tail;

#[cfg(feature = "snapshot")]
pub(crate) use check::check_spawned;
pub use error::SnapshotError;
pub use hash::StateHash;
pub(crate) use hash::hash_of;
pub(crate) use saved::{Saved, is_ours, strip};

use crate::event::Event;
use crate::report::Report;
use crate::settings::Settings;
use crate::storage::BodyId;
use hecs::Entity;
use std::sync::Arc;

/// The state of a simulation at one time. A clone costs nothing.
#[derive(Clone)]
pub struct Snapshot(pub(crate) Arc<Contents>);

/// Contents of a snapshot.
#[derive(Clone)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Contents {
    #[cfg_attr(feature = "snapshot", serde(with = "settings"))]
    pub settings: Settings,
    pub report: Report,
    pub events: Vec<Event>,
    pub next_order: u32,
    /// In the order in which systems meet them.
    pub entities: Vec<Saved>,
    /// Handles that the host has given to things of its own, and those that are free, the next one last.
    pub handles: Handles,
    /// Version of the crate that took it; empty where that is not known.
    pub writer: String,
}

/// Entities that are none of the engine's.
#[derive(Clone, Default)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Handles {
    pub others: Vec<u64>,
    pub free: Vec<u64>,
}

impl Snapshot {
    /// Time at which it was taken \[ms\].
    pub fn time(&self) -> f64 {
        self.0.report.time
    }

    /// Steps done by then.
    pub fn step(&self) -> u64 {
        self.0.report.step
    }

    /// The settings then.
    pub fn settings(&self) -> &Settings {
        &self.0.settings
    }

    /// Version of the crate that took it; empty where that is not known.
    pub fn writer(&self) -> &str {
        &self.0.writer
    }

    /// The bodies then, in order of spawning.
    pub fn bodies(&self) -> Vec<BodyId> {
        let bodies = self.0.entities.iter().filter_map(|saved| Some((saved.body.as_ref()?.order, saved.entity)));
        let mut bodies: Vec<(u32, Entity)> = bodies.collect();
        bodies.sort_unstable_by_key(|&(order, _)| order);
        bodies.into_iter().map(|(_, entity)| entity.into()).collect()
    }
}

impl std::fmt::Debug for Snapshot {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (step, time) = (self.step(), self.time());
        f.debug_struct("Snapshot").field("step", &step).field("time", &time).finish_non_exhaustive()
    }
}

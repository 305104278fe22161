//! The calls of a host that change a simulation. A new one is a variant here and an arm of `Simulation::repeat`.

use super::Parameters;
use crate::components::Obstacle;
use crate::settings::Settings;
use crate::snapshot::{Saved, Snapshot};
use glam::DVec3;
use hecs::Entity;

/// One call. Those that were refused are written down too: they are refused again.
#[derive(Clone)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Input {
    /// A dynamic step.
    Step {
        /// Time step \[ms\].
        dt: f64,
        /// Where a solve may take so long: per body in order of spawning, after how many iterations its rounds have stopped.
        stops: Vec<Vec<u32>>,
    },
    /// A static equilibrium.
    Settle {
        /// Time by which the loads move on \[ms\].
        dt: f64,
        /// Where Newton's method stops.
        tolerance: f64,
    },
    /// Static equilibria and tears.
    SettleAndTear {
        /// Time by which the loads move on \[ms\].
        dt: f64,
        /// Where Newton's method stops.
        tolerance: f64,
        /// How often tears advance at the most.
        rounds: u32,
    },
    /// A linear answer.
    LinearResponse {
        /// Time by which the loads move on \[ms\].
        dt: f64,
    },
    /// A cut.
    Cut {
        /// The body.
        #[cfg_attr(feature = "snapshot", serde(with = "crate::snapshot::handle"))]
        body: Entity,
        /// Its points \[mm, rest shape\].
        polyline: Vec<DVec3>,
    },
    /// A body was put into the world.
    Spawn(Spawned),
    /// An obstacle was put into the world.
    SpawnObstacle(Obstacle),
    /// A body or an obstacle was taken out.
    Despawn(#[cfg_attr(feature = "snapshot", serde(with = "crate::snapshot::handle"))] Entity),
    /// A body, or those that a changed obstacle touches, was woken.
    Wake(#[cfg_attr(feature = "snapshot", serde(with = "crate::snapshot::handle"))] Entity),
    /// All bodies were woken.
    WakeAll,
    /// A body's rows were sorted.
    Reorder(#[cfg_attr(feature = "snapshot", serde(with = "crate::snapshot::handle"))] Entity),
    /// Other settings.
    SetSettings(Settings),
    /// Components were changed from outside.
    Change {
        /// Of this body or obstacle.
        #[cfg_attr(feature = "snapshot", serde(with = "crate::snapshot::handle"))]
        entity: Entity,
        /// Those that were.
        to: Changes,
    },
    /// Back to a snapshot.
    Restore(Snapshot),
}

/// A body as it was put into the world.
#[derive(Clone)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Spawned(pub(crate) Box<Saved>);

/// Components as they are after a change.
#[derive(Clone)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Changes(pub(crate) Box<Parameters>);

impl From<Parameters> for Changes {
    fn from(changed: Parameters) -> Self {
        Self(Box::new(changed))
    }
}

//! A blade that is drawn through tissue.

use crate::components::BodyError;
use crate::components::check::{Check, Host, Owner, finite, positive};
use crate::storage::{BodyId, TipKey};
use glam::DVec3;

/// The edge of a blade in the world, an entity of its own, drawn by the host through the
/// [`Simulation`](crate::simulation::Simulation). *State.*
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Blade {
    /// Farthest from a surface \[mm\] at which the edge is still in it.
    pub reach: f64,
    /// Shortest cut \[mm, rest shape\]: strokes are saved up until they are as long. Half an edge of the mesh or more.
    pub least: f64,
    /// The body in which the edge is.
    pub body: Option<BodyId>,
    /// Where its next cut begins, in that body's rest shape \[mm\].
    pub from: DVec3,
    /// The tip that its last cut has left, of a body that can tear: where that has gone on, the blade goes on from there.
    pub tip: Option<TipKey>,
}

impl Check for Blade {
    const OWNER: Owner = Owner::Blade;

    fn check(&self, _: &Host<'_>) -> Result<(), BodyError> {
        positive("Blade", "reach", self.reach)?;
        positive("Blade", "the shortest cut", self.least)?;
        finite("Blade", "where its next cut begins", self.from.to_array())
    }
}

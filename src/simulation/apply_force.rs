//! A push on one vertex, for one step.

use super::Simulation;
use crate::components::StepForces;
use crate::event::WokenBy;
use crate::registry::Rejected;
use crate::replay::Input;
use crate::storage::{BodyId, VertexKey, Vertices};
use glam::DVec3;

/// Why a force was not applied; nothing has changed then.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ForceError {
    /// There is no such body.
    #[error("there is no such body")]
    NoSuchBody,
    /// A key of a vertex that does not live, or of another body.
    #[error("the body has no vertex {0:?}: it was removed, or belongs to another body")]
    NoSuchVertex(VertexKey),
    /// A force that is none.
    #[error("the force on vertex {vertex:?} is {force}: its parts, and the sum of all forces there, must be finite")]
    NotFinite {
        /// The vertex.
        vertex: VertexKey,
        /// The force \[N\].
        force: DVec3,
    },
    /// Something that was written past the calls is refused.
    #[error(transparent)]
    Written(#[from] Rejected),
}

impl Simulation {
    /// Pushes a vertex with a force \[N\] during the next step: constant in space through all of it, retries and tears included. Forces
    /// on one vertex add up. The next step uses them up, a failed one too; so does the next [`settle`](Self::settle),
    /// [`settle_and_tear`](Self::settle_and_tear) or [`linear_response`](Self::linear_response) that finds an answer. Until then
    /// they follow cuts, and go to snapshots. A held axis takes the force into its reaction.
    ///
    /// # Errors
    /// For a body or a vertex that there is not, and for a force that is not finite.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// let vertex = simulation.nearest(body, DVec3::new(5.0, 5.0, 0.0), 1.0).expect("tissue").corners[0];
    /// simulation.apply_force(body, vertex, DVec3::new(0.01, 0.0, 0.0))?;
    /// simulation.step(5.0)?;
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn apply_force(&mut self, body: BodyId, vertex: VertexKey, force: DVec3) -> Result<(), ForceError> {
        self.note(|| Input::ApplyForce { body, vertex, force });
        self.validate_dirty()?;
        let found = self.world.query_one_mut::<(&Vertices, Option<&StepForces>)>(body.entity());
        let (vertices, forces) = found.map_err(|_| ForceError::NoSuchBody)?;
        let row = vertices.row(vertex).ok_or(ForceError::NoSuchVertex(vertex))?;
        let there = forces.into_iter().flat_map(|forces| &forces.list).filter(|(other, _)| *other == row);
        let sum: DVec3 = there.map(|(_, force)| *force).sum::<DVec3>() + force;
        if !sum.is_finite() {
            return Err(ForceError::NotFinite { vertex, force });
        }
        if forces.is_none() {
            // The body is there.
            let _ = self.world.insert_one(body.entity(), StepForces::default());
        }
        if let Ok(forces) = self.world.query_one_mut::<&mut StepForces>(body.entity()) {
            forces.list.push((row, force));
        }
        self.wake_by(body, WokenBy::Caller);
        Ok(())
    }

    /// After a step.
    pub(super) fn use_forces_up(&mut self) {
        self.world.query_mut::<&mut StepForces>().into_iter().for_each(|forces| forces.list.clear());
    }
}

//! Sleeping bodies: waking and queries for the caller.

use super::{Simulation, SimulationError};
use crate::components::{Body, Sleeping, TearLog};
use crate::event::{EventKind, WokenBy};
use crate::replay::Input;
use crate::storage::BodyId;
use hecs::{Entity, Query, QueryOneError, World};

impl Simulation {
    /// The world, to change parameters or to add components of your own. Whatever sleeps is woken, as anything might be changed
    /// here; [`entity_mut`](Self::entity_mut) wakes one body only.
    pub fn world_mut(&mut self) -> &mut World {
        self.note(|| Input::WakeAll);
        for (sleeping, log) in self.world.query_mut::<(&mut Sleeping, &mut TearLog)>() {
            note_woken(sleeping, log, WokenBy::Caller);
        }
        self.lend(None);
        &mut self.world
    }

    /// Components of one body or obstacle, to be changed. A body that sleeps is woken, and so are those that a changed
    /// obstacle touches.
    ///
    /// # Errors
    /// If there is no such body or obstacle, or it does not carry all of the components.
    pub fn entity_mut<Q: Query>(&mut self, entity: impl Into<Entity>) -> Result<Q::Item<'_>, SimulationError> {
        let entity = entity.into();
        self.note(|| Input::Wake(entity));
        self.wake_by(entity, WokenBy::Caller);
        self.lend(Some(entity));
        self.world.query_one_mut::<Q>(entity).map_err(|error| match error {
            QueryOneError::NoSuchEntity => SimulationError::NoSuchBody,
            QueryOneError::Unsatisfied => SimulationError::NoSuchComponents,
        })
    }

    /// Wakes a body, should it be asleep.
    ///
    /// # Errors
    /// If there is no such body.
    pub fn wake(&mut self, body: BodyId) -> Result<(), SimulationError> {
        if !self.world.satisfies::<&Body>(body.entity()) {
            return Err(SimulationError::NoSuchBody);
        }
        self.note(|| Input::Wake(body.entity()));
        self.wake_by(body, WokenBy::Caller);
        Ok(())
    }

    /// Wakes a body that can sleep; others are awake.
    pub(super) fn wake_by(&mut self, body: impl Into<Entity>, by: WokenBy) {
        if let Ok((sleeping, log)) = self.world.query_one_mut::<(&mut Sleeping, &mut TearLog)>(body.into()) {
            note_woken(sleeping, log, by);
        }
    }
}

fn note_woken(sleeping: &mut Sleeping, log: &mut TearLog, by: WokenBy) {
    if sleeping.wake() {
        log.pending.push(EventKind::Woke { by });
    }
}

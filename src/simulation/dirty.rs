//! Validation of entities that the host may have changed through `world_mut`.

use super::Simulation;
use crate::registry::{Rejected, complete_in, validate, validate_tables};
use crate::storage::BodyId;
use crate::systems::StepContext;
use hecs::Entity;

/// From so many entities on all are judged.
const MANY: usize = 64;

/// Entities that may have been written past the calls since they were judged last.
#[derive(Default)]
pub(super) struct Dirty {
    are_all: bool,
    list: Vec<Entity>,
    /// Scratch that keeps its memory: systems of the caller's have every step completed.
    all: Vec<Entity>,
}

impl Dirty {
    /// Notes one, or all.
    pub(super) fn note(&mut self, entity: Option<Entity>) {
        match entity {
            Some(entity) if !self.are_all && self.list.len() < MANY => {
                if !self.list.contains(&entity) {
                    self.list.push(entity);
                }
            }
            _ => self.are_all = true,
        }
    }

    fn has(&self, entity: Entity) -> bool {
        self.are_all || self.list.contains(&entity)
    }
}

impl Simulation {
    /// Validates entities that were handed out and adds required components; a no-op where none was.
    pub(super) fn validate_dirty(&mut self) -> Result<(), Rejected> {
        if self.schedule.has_callers() {
            self.complete_all();
        }
        if !self.dirty.are_all && self.dirty.list.is_empty() {
            return Ok(());
        }
        let world = &self.world;
        if self.dirty.are_all {
            world.iter().try_for_each(|entity| validate(world, entity.entity()))?;
            self.complete_all();
        } else {
            self.dirty.list.iter().try_for_each(|&entity| validate(world, entity))?;
            self.dirty.list.iter().for_each(|&entity| complete_in(&mut self.world, entity));
        }
        self.dirty.are_all = false;
        self.dirty.list.clear();
        Ok(())
    }

    /// Validates a body that was handed out: code that reads all of it reads no others.
    pub(super) fn validate_if_dirty(&self, body: BodyId) -> Result<(), Rejected> {
        if self.dirty.has(body.entity()) { validate(&self.world, body.entity()) } else { Ok(()) }
    }

    /// Validates the tables of a body that was handed out: code that looks at it reads no others.
    pub(super) fn validate_tables_if_dirty(&self, body: BodyId) -> Result<(), Rejected> {
        if self.dirty.has(body.entity()) { validate_tables(&self.world, body.entity()) } else { Ok(()) }
    }

    fn complete_all(&mut self) {
        let Self { world, dirty: Dirty { all, .. }, .. } = self;
        all.clear();
        all.extend(world.iter().map(|entity| entity.entity()));
        all.iter().for_each(|&entity| complete_in(world, entity));
    }

    /// After the systems of a step: an error where one of the caller's has written a rejected value, with the step taken back.
    pub(super) fn check_callers(&mut self, step: &StepContext) -> Result<(), Rejected> {
        let Some((rejected, has_begun)) = self.schedule.take_rejected() else { return Ok(()) };
        if has_begun {
            crate::systems::step::faults::restore(&mut self.world, step, self.report.time);
        }
        self.report.has_failed = true;
        self.dirty.note(None);
        Err(rejected)
    }
}

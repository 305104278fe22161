//! Legacy of a step to the next one, beside its displacement: its length, and the friction in it.

use crate::storage::{EditRecord, ObstacleId};
use glam::DVec3;

/// Length of the last step, and friction with obstacles at its end.
#[derive(Clone, Debug, Default)]
pub struct LastStep {
    /// Time step \[ms\].
    pub dt: f64,
    /// Friction with obstacles; `None` before the body rubs on one.
    pub(crate) friction: Option<Box<Friction>>,
}

/// Friction of a body with obstacles.
#[derive(Clone, Debug, Default)]
pub(crate) struct Friction {
    /// Contacts at the start of the step, by obstacle and row.
    pub start: Vec<FrictionContact>,
    /// Contacts at the end of the step, by obstacle and row.
    pub end: Vec<FrictionContact>,
}

/// Friction of a vertex with an obstacle.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct FrictionContact {
    /// The obstacle.
    pub obstacle: ObstacleId,
    /// Row of the vertex.
    pub row: u32,
    /// Tangential way of the vertex from the place where it sticks \[mm\].
    pub offset: DVec3,
    /// Slip velocities in the last step and in the one before \[mm/ms\].
    pub slip: [DVec3; 2],
    /// Normal force at the end of the last step \[N\].
    pub normal_force: f64,
}

impl LastStep {
    /// Takes the contacts at the end of the last step as those at the start of the next one.
    pub(crate) fn begin(&mut self) {
        if let Some(friction) = &mut self.friction {
            friction.start.clone_from(&friction.end);
        }
    }

    /// Puts the contacts at the start of the step back.
    pub(crate) fn forget_attempt(&mut self) {
        if let Some(friction) = &mut self.friction {
            friction.end.clone_from(&friction.start);
        }
    }

    /// Update after an edit: copies of a vertex take over its contacts; moved and removed vertices lose theirs.
    pub(crate) fn follow(&mut self, record: &EditRecord) {
        let Some(friction) = &mut self.friction else { return };
        for contacts in [&mut friction.start, &mut friction.end] {
            let copies = record.created().filter(|(_, parents)| parents.is_duplicate());
            for (row, parents) in copies {
                let parent = parents.rows()[0];
                let found = contacts.iter().filter(|contact| contact.row == parent);
                let copies: Vec<FrictionContact> = found.map(|contact| FrictionContact { row, ..*contact }).collect();
                contacts.extend(copies);
            }
            let moved = record.moved().map(|(row, _)| row);
            contacts.retain_mut(|contact| {
                let is_same = Some(contact.row) != moved;
                let row = record.vertex_after(contact.row).filter(|_| is_same);
                contact.row = row.unwrap_or_default();
                row.is_some()
            });
            contacts.sort_unstable_by_key(FrictionContact::key);
        }
    }
}

impl Friction {
    /// Contact of a vertex with an obstacle at the start of the step.
    pub(crate) fn at_start(&self, obstacle: ObstacleId, row: u32) -> Option<&FrictionContact> {
        let found = self.start.binary_search_by_key(&(obstacle.entity(), row), FrictionContact::key);
        found.ok().map(|place| &self.start[place])
    }
}

impl FrictionContact {
    /// Obstacle and row, by which contacts are sorted.
    pub(crate) fn key(&self) -> (hecs::Entity, u32) {
        (self.obstacle.entity(), self.row)
    }
}

/// Bytes: the time step, negative where the contacts follow. Up to version 18 there were none.
#[cfg(feature = "snapshot")]
mod saved {
    use super::{Friction, FrictionContact, LastStep};
    use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Visitor};
    use serde::{Serialize, Serializer};
    use std::fmt;

    impl Serialize for LastStep {
        fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
            match &self.friction {
                Some(friction) if !friction.end.is_empty() => (-self.dt, &friction.end).serialize(to),
                _ => (self.dt.abs(),).serialize(to),
            }
        }
    }

    impl<'de> Deserialize<'de> for LastStep {
        fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
            from.deserialize_tuple(2, Reader)
        }
    }

    struct Reader;

    impl<'de> Visitor<'de> for Reader {
        type Value = LastStep;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a time step")
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut from: A) -> Result<LastStep, A::Error> {
            let none = || A::Error::custom("there is no time step");
            let dt: f64 = from.next_element()?.ok_or_else(none)?;
            let contacts: Option<Vec<FrictionContact>> =
                if dt.is_sign_negative() { from.next_element()? } else { None };
            let friction = contacts.map(|end| Box::new(Friction { start: Vec::new(), end }));
            Ok(LastStep { dt: dt.abs(), friction })
        }
    }
}

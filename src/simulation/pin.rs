//! Vertices held and let go while the simulation runs.

use super::Simulation;
use crate::components::{Body, Curve, Hold, Holds};
use crate::event::WokenBy;
use crate::registry::{Rejected, complete_in};
use crate::replay::Input;
use crate::storage::{Attached, BodyId, VertexKey, Vertices};
use glam::DVec3;
use std::ops::Deref;

/// Why vertices were not pinned, moved or let go; nothing has changed then.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PinError {
    /// There is no such body.
    #[error("there is no such body")]
    NoSuchBody,
    /// A key of a vertex that does not live, or of another body.
    #[error("the body has no vertex {0:?}: it was removed, or belongs to another body")]
    NoSuchVertex(VertexKey),
    /// The vertex is held already.
    #[error("vertex {vertex:?} is held by `{hold}` already: unpin it first")]
    AlreadyHeld {
        /// The vertex.
        vertex: VertexKey,
        /// Who holds it.
        hold: String,
    },
    /// A hold that the body was spawned with moves its vertices along a curve.
    #[error("`{0}` follows a curve or leaves axes free: pin its vertices under another name, or change its curve")]
    FollowsCurve(String),
    /// No hold has this name.
    #[error("the body has no hold `{0}`")]
    NoSuchHold(String),
    /// The vertex is not pinned.
    #[error("vertex {0:?} is not pinned")]
    NotPinned(VertexKey),
    /// A place that is not a point.
    #[error("the place of vertex {vertex:?} is {place}: its coordinates must be finite")]
    NotFinite {
        /// The vertex.
        vertex: VertexKey,
        /// The place.
        place: DVec3,
    },
    /// Something that was written past the calls is refused.
    #[error(transparent)]
    Written(#[from] Rejected),
}

/// A pinned vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pin {
    /// The vertex.
    pub vertex: VertexKey,
    /// Position of the vertex in the rest shape \[mm\]: by this, copies that a tear has made are moved like their originals.
    pub rest_position: DVec3,
    /// Position at which the vertex is held \[mm\].
    pub place: DVec3,
}

impl Hold {
    /// Whether this is a hold of [`Simulation::pin`]: all axes are held at rest position + offset.
    pub fn is_pin(&self) -> bool {
        self.axes == [true; 3] && self.curve.points() == [(0.0, 1.0)]
    }
}

impl Simulation {
    /// Holds vertices where they are now, on all axes: they are added to the pins of this name, which
    /// [reactions](Self::reactions) tell of and which follow tears as every hold does. Both copies of a vertex that is parted stay.
    ///
    /// # Errors
    /// For a vertex that there is not or that is held, and for the name of a hold that is no pin.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// let vertex = simulation.nearest(body, DVec3::new(5.0, 5.0, 0.0), 1.0).expect("tissue").corners[0];
    /// simulation.pin(body, "hand", &[vertex])?;
    /// assert_eq!(simulation.pins(body, "hand")?.len(), 1);
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn pin(&mut self, body: BodyId, name: &str, vertices: &[VertexKey]) -> Result<(), PinError> {
        self.note(|| Input::Pin { body, name: name.to_owned(), vertices: vertices.to_vec() });
        self.validate_dirty()?;
        if !self.world.satisfies::<&Body>(body.entity()) {
            return Err(PinError::NoSuchBody);
        }
        if !self.world.satisfies::<&Holds>(body.entity()) {
            // The body exists.
            let _ = self.world.insert_one(body.entity(), Holds::default());
            complete_in(&mut self.world, body.entity());
        }
        let found = self.world.query_one_mut::<(&Vertices, &mut Holds)>(body.entity());
        let (table, holds) = found.map_err(|_| PinError::NoSuchBody)?;
        if holds.groups.iter().any(|hold| hold.name == name && !hold.is_pin()) {
            return Err(PinError::FollowsCurve(name.to_owned()));
        }
        for &vertex in vertices {
            let row = table.row(vertex).ok_or(PinError::NoSuchVertex(vertex))?;
            let position = table.position[row as usize];
            if let Some(hold) = holds.groups.iter().find(|hold| hold.members.value(row).is_some()) {
                return Err(PinError::AlreadyHeld { vertex, hold: hold.name.clone() });
            }
            if !position.is_finite() {
                return Err(PinError::NotFinite { vertex, place: position });
            }
        }
        let group = holds.groups.iter().position(|hold| hold.name == name).unwrap_or_else(|| {
            let members = Attached::default();
            holds.groups.push(Hold { name: name.to_owned(), members, axes: [true; 3], curve: Curve::constant(1.0) });
            holds.groups.len() - 1
        });
        for row in vertices.iter().filter_map(|&vertex| table.row(vertex)) {
            let v = row as usize;
            holds.groups[group].members.insert(row, table.position[v] - table.rest_position[v]);
        }
        self.wake_by(body, WokenBy::Caller);
        Ok(())
    }

    /// Lets vertices go, whoever holds them. A hold that holds nothing any more stays listed.
    ///
    /// # Errors
    /// For a vertex that there is not or that nothing holds.
    pub fn unpin(&mut self, body: BodyId, vertices: &[VertexKey]) -> Result<(), PinError> {
        self.note(|| Input::Unpin { body, vertices: vertices.to_vec() });
        self.validate_dirty()?;
        let found = self.world.query_one_mut::<(&Vertices, Option<&mut Holds>)>(body.entity());
        let (table, mut holds) = found.map_err(|_| PinError::NoSuchBody)?;
        for &vertex in vertices {
            let row = table.row(vertex).ok_or(PinError::NoSuchVertex(vertex))?;
            let groups = holds.iter().flat_map(|holds| &holds.groups);
            if !groups.into_iter().any(|hold| hold.members.value(row).is_some()) {
                return Err(PinError::NotPinned(vertex));
            }
        }
        for hold in holds.iter_mut().flat_map(|holds| &mut holds.groups) {
            for row in vertices.iter().filter_map(|&vertex| table.row(vertex)) {
                hold.members.remove(row);
            }
        }
        self.wake_by(body, WokenBy::Caller);
        Ok(())
    }

    /// Releases the vertices pinned under a name, copies that tears have made included. The name stays listed.
    ///
    /// # Errors
    /// For a name that no hold has, and for that of a hold that is no pin.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// # let vertex = simulation.nearest(body, DVec3::new(5.0, 5.0, 0.0), 1.0).expect("tissue").corners[0];
    /// simulation.pin(body, "hand", &[vertex])?;
    /// simulation.unpin_all(body, "hand")?;
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn unpin_all(&mut self, body: BodyId, name: &str) -> Result<(), PinError> {
        self.note(|| Input::UnpinAll { body, name: name.to_owned() });
        self.validate_dirty()?;
        let (_, hold) = pins(&mut self.world, body, name)?;
        hold.members.clear();
        self.wake_by(body, WokenBy::Caller);
        Ok(())
    }

    /// Moves the vertices pinned under a name, copies that tears have made included: at the end of the next step every vertex is where
    /// `place` says \[mm\]. It is asked twice for each.
    ///
    /// # Errors
    /// For a name that no hold has, for that of a hold that is no pin, and for a place that is not finite.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// # let vertex = simulation.nearest(body, DVec3::new(5.0, 5.0, 0.0), 1.0).expect("tissue").corners[0];
    /// simulation.pin(body, "hand", &[vertex])?;
    /// simulation.move_pins(body, "hand", |pin| pin.rest_position + DVec3::new(0.2, 0.0, 0.0))?;
    /// simulation.step(5.0)?;
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn move_pins(&mut self, body: BodyId, name: &str, place: impl Fn(Pin) -> DVec3) -> Result<(), PinError> {
        self.note(|| Input::Wake(body.entity()));
        self.validate_dirty()?;
        self.keep_lent(Some(body.entity()));
        let (table, hold) = pins(&mut self.world, body, name)?;
        let pin = |row: u32, offset: DVec3| {
            let rest_position = table.rest_position[row as usize];
            // A row has a key.
            table.key(row).map(|vertex| Pin { vertex, rest_position, place: rest_position + offset })
        };
        for (&row, &offset) in hold.members.rows().iter().zip(hold.members.values()) {
            if let Some(pin) = pin(row, offset) {
                let place = place(pin);
                if !place.is_finite() {
                    return Err(PinError::NotFinite { vertex: pin.vertex, place });
                }
            }
        }
        hold.members.update(|row, offset| match pin(row, offset) {
            Some(pin) => place(pin) - pin.rest_position,
            None => offset,
        });
        self.wake_by(body, WokenBy::Caller);
        Ok(())
    }

    /// Pins under a name, in the order of rows.
    ///
    /// # Errors
    /// For a name that no hold has, and for that of a hold that is no pin.
    pub fn pins(&self, body: BodyId, name: &str) -> Result<Vec<Pin>, PinError> {
        self.validate_if_dirty(body)?;
        let mut query = self.world.query_one::<(&Vertices, Option<&Holds>)>(body.entity());
        let (table, holds) = query.get().map_err(|_| PinError::NoSuchBody)?;
        let hold = pinned(holds.into_iter().flat_map(|holds| &holds.groups), name)?;
        let members = hold.members.rows().iter().zip(hold.members.values());
        let pin = |(&row, &offset): (&u32, &DVec3)| {
            let rest_position = table.rest_position[row as usize];
            Some(Pin { vertex: table.key(row)?, rest_position, place: rest_position + offset })
        };
        Ok(members.filter_map(pin).collect())
    }
}

/// The vertices of a body, and the hold under a name.
fn pins<'a>(world: &'a mut hecs::World, body: BodyId, name: &str) -> Result<(&'a Vertices, &'a mut Hold), PinError> {
    let found =
        world.query_one_mut::<(&Vertices, Option<&mut Holds>)>(body.entity()).map_err(|_| PinError::NoSuchBody)?;
    let (vertices, holds) = found;
    let hold = pinned(holds.into_iter().flat_map(|holds| &mut holds.groups), name)?;
    Ok((vertices, hold))
}

/// The hold of this name, if it is one of pins.
fn pinned<H: Deref<Target = Hold>>(mut holds: impl Iterator<Item = H>, name: &str) -> Result<H, PinError> {
    let hold = holds.find(|hold| hold.name == name).ok_or_else(|| PinError::NoSuchHold(name.to_owned()))?;
    if hold.is_pin() { Ok(hold) } else { Err(PinError::FollowsCurve(name.to_owned())) }
}

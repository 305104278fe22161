//! A body set elsewhere, or thrown.

use super::Simulation;
use crate::components::{EnergyAudit, Hold, HoldGuides, HoldTurns, Holds, Increment, Planar};
use crate::event::WokenBy;
use crate::math::is_place;
use crate::registry::Rejected;
use crate::replay::Input;
use crate::storage::{BodyId, Vertices};
use glam::{DQuat, DVec3};

/// Why a body was not set elsewhere; nothing has changed then.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MotionError {
    /// There is no such body.
    #[error("there is no such body")]
    NoSuchBody,
    /// A rotation, translation or velocity that is not finite, a velocity whose energy is not, or a place beyond 1e75 mm.
    #[error("a rotation, translation or velocity, or its energy, is not finite, or the place is beyond 1e75 mm")]
    NotFinite,
    /// A hold that would draw the body back at once.
    #[error("`{0}` holds the body along a curve: let its vertices go, or pin them instead")]
    Held(String),
    /// A planar body stays in a plane z = const.
    #[error("a planar body turns about z only, and moves in its plane")]
    OutOfPlane,
    /// Something that was written past the calls is refused.
    #[error(transparent)]
    Written(#[from] Rejected),
}

impl Simulation {
    /// Sets a body elsewhere: turned about the origin, then shifted \[mm\], with its velocities turned and its pins taken along.
    /// Springs, grips and obstacles stay where they are.
    ///
    /// # Errors
    /// For numbers that are not finite, for a planar body that would leave its plane, and for one that a curve holds.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// # simulation.unset::<rhexis::components::Holds>(body)?;
    /// simulation.teleport(body, DQuat::IDENTITY, DVec3::new(20.0, 0.0, 0.0))?;
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn teleport(&mut self, body: BodyId, rotation: DQuat, shift: DVec3) -> Result<(), MotionError> {
        type Query<'a> = (
            (&'a mut Vertices, &'a mut Increment, Option<&'a mut Holds>),
            (Option<&'a Planar>, Option<&'a mut EnergyAudit>, Option<&'a HoldTurns>, Option<&'a HoldGuides>),
        );
        self.note(|| Input::Teleport { body, rotation, shift });
        self.validate_dirty()?;
        let found = self.world.query_one_mut::<Query>(body.entity()).map_err(|_| MotionError::NoSuchBody)?;
        let ((vertices, increment, mut holds), (planar, audit, turns, guides)) = found;
        // A square that is a normal number has a root that scales.
        if !(rotation.length_squared().is_normal() && is_place(shift)) {
            return Err(MotionError::NotFinite);
        }
        let rotation = rotation.normalize();
        // A turn about z has no other parts, and a quaternion of one has them exactly zero.
        if planar.is_some() && (rotation.x != 0.0 || rotation.y != 0.0 || shift.z != 0.0) {
            return Err(MotionError::OutOfPlane);
        }
        let is_turned = |place: usize| {
            turns.is_some_and(|turns| turns.of(place).is_some())
                || guides.is_some_and(|guides| guides.of(place).is_some())
        };
        let curved =
            |(place, hold): &(usize, &Hold)| !(hold.is_pin() && !is_turned(*place) || hold.members.rows().is_empty());
        let curved = holds.as_ref().and_then(|holds| holds.groups.iter().enumerate().find(curved));
        if let Some((_, hold)) = curved {
            return Err(MotionError::Held(hold.name.clone()));
        }
        let is_planar = planar.is_some();
        let moved = |x: DVec3| {
            let to = rotation * x + shift;
            // A turn about z may round z.
            if is_planar { to.with_z(x.z) } else { to }
        };
        if !vertices.position.iter().all(|&x| is_place(moved(x))) {
            return Err(MotionError::NotFinite);
        }
        vertices.position.iter_mut().for_each(|x| *x = moved(*x));
        vertices.velocity.iter_mut().for_each(|v| *v = rotation * *v);
        increment.displacement.iter_mut().for_each(|u| *u = rotation * *u);
        // Nothing lies between where it was and where it is.
        increment.start.clear();
        increment.start_velocity.clear();
        for hold in holds.iter_mut().flat_map(|holds| &mut holds.groups) {
            hold.members.update(|row, offset| {
                let rest = vertices.rest_position[row as usize];
                moved(rest + offset) - rest
            });
        }
        if let Some(audit) = audit {
            audit.forget_equilibrium();
        }
        self.wake_by(body, WokenBy::Caller);
        Ok(())
    }

    /// Sets the velocities \[mm/ms\] of a body from its positions \[mm\]. Held axes keep to their holds in the next step.
    ///
    /// # Errors
    /// For a velocity that is not finite, or whose energy is not; `velocity` is asked twice for each vertex.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// # simulation.unset::<rhexis::components::Holds>(body)?;
    /// simulation.set_velocity(body, |_| DVec3::new(0.1, 0.0, 0.0))?;
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn set_velocity(&mut self, body: BodyId, velocity: impl Fn(DVec3) -> DVec3) -> Result<(), MotionError> {
        self.note(|| Input::Wake(body.entity()));
        self.validate_dirty()?;
        self.keep_lent(Some(body.entity()));
        let before = self.audited_energies(body);
        let (vertices, planar) = self
            .world
            .query_one_mut::<(&mut Vertices, Option<&Planar>)>(body.entity())
            .map_err(|_| MotionError::NoSuchBody)?;
        let doubled: f64 =
            vertices.position.iter().zip(&vertices.mass).map(|(&x, m)| m * velocity(x).length_squared()).sum();
        if !doubled.is_finite() {
            return Err(MotionError::NotFinite);
        }
        if planar.is_some() && vertices.position.iter().any(|&x| velocity(x).z != 0.0) {
            return Err(MotionError::OutOfPlane);
        }
        vertices.velocity.iter_mut().zip(&vertices.position).for_each(|(v, &x)| *v = velocity(x));
        self.note_edited_energies(body, before);
        self.wake_by(body, WokenBy::Caller);
        Ok(())
    }
}

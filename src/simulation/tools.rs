//! Forceps while the simulation runs: the host sets their pose, closes and opens them, and reads their forces.

use super::Simulation;
use crate::components::{Body, Forceps, Grasp, Grips, Jaws, Motion, Pinch, Pose};
use crate::event::WokenBy;
use crate::math::is_place;
use crate::registry::{Rejected, complete_in};
use crate::replay::Input;
use crate::storage::{BodyId, ForcepsId, Topology, Triangles, Vertices};
use crate::systems::tools::PinchSelection;
use glam::DVec3;

/// Why a tool did nothing; everything is as it was.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ToolError {
    /// There is no such body.
    #[error("there is no such body")]
    NoSuchBody,
    /// The entity is not the tool that was asked for.
    #[error("there are no such forceps")]
    NoSuchForceps,
    /// The jaws hold something already.
    #[error("forceps `{name}` are closed: open them before they close again")]
    Closed {
        /// Their name.
        name: String,
    },
    /// There is no tissue where the jaws close.
    #[error("forceps `{name}` find no tissue to take: come nearer, or give more reach")]
    NothingThere {
        /// Their name.
        name: String,
    },
    /// A vertex that does not exist any more.
    #[error("forceps `{name}` are to take a vertex that the body does not have: take keys from its present mesh")]
    NoSuchVertex {
        /// Their name.
        name: String,
    },
    /// A pose or a duration that is not finite, or an orientation that is no rotation.
    #[error(
        "forceps `{name}` were given a pose that is no rigid motion: a place within 1e75 mm, a unit quaternion, and a duration of zero or more"
    )]
    BadPose {
        /// Their name.
        name: String,
    },
    /// A number of the jaws outside its range.
    #[error("forceps `{name}`: {what} is {value:?}: {must}")]
    OutOfRange {
        /// Their name.
        name: String,
        /// Which number.
        what: &'static str,
        /// Value given for the parameter.
        value: f64,
        /// Condition that the value must meet.
        must: &'static str,
    },
    /// Something that was written past the calls is refused.
    #[error(transparent)]
    Written(#[from] Rejected),
}

impl Simulation {
    /// Puts open forceps into the world.
    ///
    /// # Errors
    /// For a pose that is no rigid motion and for jaws with numbers out of range.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// let jaws = Jaws { radius: 1.5, stiffness: None, force_limit: None, slip: Slip::Slide };
    /// let forceps = simulation.spawn_forceps("forceps", jaws, Pose::at(DVec3::new(5.0, 5.0, 0.0)))?;
    /// assert_eq!(simulation.tools(), [forceps.entity()]);
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn spawn_forceps(&mut self, name: &str, jaws: Jaws, pose: Pose) -> Result<ForcepsId, ToolError> {
        self.note(|| Input::SpawnForceps { name: name.to_owned(), jaws, pose });
        let name = name.to_owned();
        if !(pose.is_sound() && is_place(pose.position)) {
            return Err(ToolError::BadPose { name });
        }
        if let Err((what, value, must)) = jaws.check() {
            return Err(ToolError::OutOfRange { name, what, value, must });
        }
        let motion = Motion::rest(pose);
        Ok(self.world.spawn((Forceps { name, jaws, motion, ..Forceps::default() },)).into())
    }

    /// Moves forceps from where they are now to a pose, evenly within a time \[ms\]: that of the step or of the frame that is
    /// about to be simulated. Held vertices move along.
    ///
    /// # Errors
    /// If there are no such forceps, and for a pose or a time that is no rigid motion.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// # let jaws = Jaws { radius: 1.5, stiffness: None, force_limit: None, slip: Slip::Slide };
    /// # let forceps = simulation.spawn_forceps("forceps", jaws, Pose::at(DVec3::new(5.0, 5.0, 0.0)))?;
    /// simulation.close_forceps(forceps, body, &Grasp::Nearest { reach: 1.0 })?;
    /// simulation.move_forceps(forceps, Pose::at(DVec3::new(5.1, 5.0, 0.0)), 16.0)?;
    /// simulation.step(16.0)?;
    /// assert!(simulation.forceps(forceps)?.force.x > 0.0);
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn move_forceps(&mut self, forceps: ForcepsId, pose: Pose, within: f64) -> Result<(), ToolError> {
        self.note(|| Input::MoveForceps { forceps, pose, within });
        let now = self.report.time;
        let tool = self.world.query_one_mut::<&mut Forceps>(forceps.entity()).map_err(|_| ToolError::NoSuchForceps)?;
        if !(pose.is_sound() && is_place(pose.position) && within >= 0.0 && (now + within).is_finite()) {
            return Err(ToolError::BadPose { name: tool.name.clone() });
        }
        let motion = Motion { from: tool.motion.at(now), to: pose, start: now, end: now + within };
        tool.motion = motion;
        if let Some(body) = tool.body
            && let Some(pinch) = self.pinch_mut(body, forceps)
        {
            pinch.motion = motion;
        }
        Ok(())
    }

    /// Closes forceps on a body: they hold the tissue in their jaws, where it is, until they open or it slips. Returns the number of
    /// vertices held.
    ///
    /// # Errors
    /// If there are no such forceps or body, if they are closed already, and if there is nothing to take.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// # let jaws = Jaws { radius: 1.5, stiffness: None, force_limit: None, slip: Slip::Slide };
    /// let forceps = simulation.spawn_forceps("forceps", jaws, Pose::at(DVec3::new(5.0, 5.0, 0.5)))?;
    /// let vertices = simulation.close_forceps(forceps, body, &Grasp::Nearest { reach: 1.0 })?;
    /// assert!(vertices > 0);
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn close_forceps(&mut self, forceps: ForcepsId, body: BodyId, grasp: &Grasp) -> Result<usize, ToolError> {
        self.note(|| Input::CloseForceps { forceps, body, grasp: grasp.clone() });
        self.validate_dirty()?;
        let now = self.report.time;
        let tool = self.world.query_one_mut::<&Forceps>(forceps.entity()).map_err(|_| ToolError::NoSuchForceps)?;
        let Forceps { name, jaws, motion, .. } = tool.clone();
        if tool.body.is_some_and(|held| self.pinch_mut(held, forceps).is_some()) {
            return Err(ToolError::Closed { name });
        }
        if !self.world.satisfies::<(&Body, &Vertices)>(body.entity()) {
            return Err(ToolError::NoSuchBody);
        }
        let pose = motion.at(now);
        let rows = self.rows_of(body, grasp, (&name, jaws.radius, &pose))?;
        // A body may be gripped that was not made for it.
        if !self.world.satisfies::<&Grips>(body.entity()) {
            let _ = self.world.insert_one(body.entity(), Grips::default());
            complete_in(&mut self.world, body.entity());
        }
        self.wake_by(body, WokenBy::Drive);
        let found = self.world.query_one_mut::<(&mut Grips, &Vertices)>(body.entity());
        let (grips, vertices) = found.map_err(|_| ToolError::NoSuchBody)?;
        let mut pinch = Pinch { name, forceps: Some(forceps), jaws, motion, ..Pinch::default() };
        pinch.close(vertices, rows, &pose);
        let count = pinch.held.rows().len();
        grips.grasp_count += 1;
        grips.pinches.push(pinch);
        if let Ok(tool) = self.world.query_one_mut::<&mut Forceps>(forceps.entity()) {
            tool.body = Some(body);
        }
        Ok(count)
    }

    /// Opens forceps. Returns whether they were closed; open ones stay so.
    ///
    /// # Errors
    /// If there are no such forceps.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// # let jaws = Jaws { radius: 1.5, stiffness: None, force_limit: None, slip: Slip::Slide };
    /// # let forceps = simulation.spawn_forceps("forceps", jaws, Pose::at(DVec3::new(5.0, 5.0, 0.0)))?;
    /// simulation.close_forceps(forceps, body, &Grasp::Nearest { reach: 1.0 })?;
    /// assert!(simulation.open_forceps(forceps)?);
    /// assert_eq!(simulation.forceps(forceps)?.body, None);
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn open_forceps(&mut self, forceps: ForcepsId) -> Result<bool, ToolError> {
        self.note(|| Input::OpenForceps(forceps));
        self.release(forceps)
    }

    /// Opens forceps, should these be any. Returns whether they were closed.
    pub(super) fn release(&mut self, forceps: ForcepsId) -> Result<bool, ToolError> {
        let tool = self.world.query_one_mut::<&mut Forceps>(forceps.entity()).map_err(|_| ToolError::NoSuchForceps)?;
        (tool.force, tool.torque) = (DVec3::ZERO, DVec3::ZERO);
        let Some(body) = tool.body.take() else { return Ok(false) };
        self.wake_by(body, WokenBy::Drive);
        if let Ok(grips) = self.world.query_one_mut::<&mut Grips>(body.entity()) {
            grips.pinches.retain(|pinch| pinch.forceps != Some(forceps));
        }
        Ok(true)
    }

    /// Forceps as they are: where, whether closed, and force and torque on the tissue at the last step.
    ///
    /// # Errors
    /// If there are no such forceps.
    pub fn forceps(&self, forceps: ForcepsId) -> Result<Forceps, ToolError> {
        self.world.get::<&Forceps>(forceps.entity()).map(|tool| (*tool).clone()).map_err(|_| ToolError::NoSuchForceps)
    }

    /// Distance \[mm\] of forceps from where their jaws draw the tissue to, for the held vertex that is farthest from its place: above zero where
    /// steps were limited. Open forceps have none.
    ///
    /// # Errors
    /// If there are no such forceps.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// # let jaws = Jaws { radius: 1.5, stiffness: Some(0.2), force_limit: None, slip: Slip::Slide };
    /// # let forceps = simulation.spawn_forceps("forceps", jaws, Pose::at(DVec3::new(5.0, 5.0, 0.0)))?;
    /// simulation.close_forceps(forceps, body, &Grasp::Nearest { reach: 1.0 })?;
    /// simulation.move_forceps(forceps, Pose::at(DVec3::new(5.1, 5.0, 0.0)), 16.0)?;
    /// simulation.step(16.0)?;
    /// assert_eq!(simulation.hand_ahead(forceps)?, 0.0);
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn hand_ahead(&self, forceps: ForcepsId) -> Result<f64, ToolError> {
        let body = self.world.get::<&Forceps>(forceps.entity()).map_err(|_| ToolError::NoSuchForceps)?.body;
        let grips = body.and_then(|body| self.world.get::<&Grips>(body.entity()).ok());
        let pinch = grips.as_ref().and_then(|grips| grips.pinches.iter().find(|pinch| pinch.forceps == Some(forceps)));
        Ok(pinch.map_or(0.0, |pinch| pinch.hand_ahead(self.report.time)))
    }

    fn pinch_mut(&mut self, body: BodyId, forceps: ForcepsId) -> Option<&mut Pinch> {
        let grips = self.world.query_one_mut::<&mut Grips>(body.entity()).ok()?;
        grips.pinches.iter_mut().find(|pinch| pinch.forceps == Some(forceps))
    }

    /// The vertices that jaws of this name, radius and pose take.
    fn rows_of(
        &self,
        body: BodyId,
        grasp: &Grasp,
        (name, radius, pose): (&str, f64, &Pose),
    ) -> Result<Vec<u32>, ToolError> {
        type Query<'a> = (&'a Vertices, &'a Triangles, &'a Topology);
        let coordinates = match grasp {
            Grasp::Ray { origin, direction, .. } => [*origin, *direction],
            Grasp::Point(place) => [*place; 2],
            Grasp::Nearest { .. } | Grasp::Vertices(_) => [DVec3::ZERO; 2],
        };
        if let Some(&value) = coordinates.iter().flat_map(DVec3::as_ref).find(|number| !number.is_finite()) {
            let (what, must) = ("a coordinate of the grasp", "it must be finite");
            return Err(ToolError::OutOfRange { name: name.to_owned(), what, value, must });
        }
        let hit = match grasp {
            Grasp::Nearest { reach } => self.nearest(body, pose.position, *reach),
            Grasp::Ray { origin, direction, reach } => self.cast_ray(body, *origin, *direction, *reach),
            Grasp::Point(_) | Grasp::Vertices(_) => None,
        };
        let mut query = self.world.query_one::<Query>(body.entity());
        let (vertices, triangles, topology) = query.get().map_err(|_| ToolError::NoSuchBody)?;
        let place = match (grasp, hit) {
            (Grasp::Point(place), _) => Some((*place, None)),
            (_, Some(hit)) => Some((hit.rest_position, triangles.row(hit.triangle))),
            _ => None,
        };
        let rows: Vec<u32> = match (grasp, place) {
            (Grasp::Vertices(keys), _) => {
                let no_such = || ToolError::NoSuchVertex { name: name.to_owned() };
                keys.iter().map(|&key| vertices.row(key).ok_or_else(no_such)).collect::<Result<_, _>>()?
            }
            (_, Some(place)) => {
                let selection = PinchSelection::about((vertices, triangles, topology), place, radius);
                selection.map_or(Vec::new(), |selection| selection.rows.to_vec())
            }
            (_, None) => Vec::new(),
        };
        if rows.is_empty() { Err(ToolError::NothingThere { name: name.to_owned() }) } else { Ok(rows) }
    }
}

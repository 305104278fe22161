//! Forceps: a rigid hand whose jaws take hold of tissue, carry it along and let go; the same whether the host moves it or a script.
//!
//! Held tissue has its place in the frame of the jaws, so that it follows their translation and rotation. Jaws without a stiffness
//! prescribe where the tissue is: a constraint, whose force is the reaction. Jaws with one draw by springs that are implicit in the
//! step, so that none is too stiff.

use crate::components::check::{Check, Host, Owner};
use crate::components::{BodyError, Jaws};
use crate::math::elementary;
use crate::storage::{Attached, BodyId, ForcepsId, VertexKey, Vertices};
use glam::{DQuat, DVec3};

/// Where the jaws are and how they are turned.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Pose {
    /// \[mm\].
    pub position: DVec3,
    /// From the jaws' frame to space.
    pub orientation: DQuat,
}

impl Pose {
    /// At a place, not turned.
    pub fn at(position: DVec3) -> Self {
        Self { position, orientation: DQuat::IDENTITY }
    }

    /// A place in the jaws' frame, in space \[mm\].
    pub fn carry(&self, place: DVec3) -> DVec3 {
        self.position + self.orientation * place
    }

    /// A point of space in the jaws' frame \[mm\].
    pub fn place(&self, point: DVec3) -> DVec3 {
        self.orientation.inverse() * (point - self.position)
    }

    /// A part of the way to another pose: straight, and about one axis the shorter way round.
    pub fn towards(&self, end: &Self, part: f64) -> Self {
        if part >= 1.0 {
            return *end;
        }
        Self {
            position: self.position.lerp(end.position, part),
            orientation: elementary::slerp(self.orientation, end.orientation, part),
        }
    }

    /// Whether all of it is finite and the orientation is a rotation.
    pub fn is_sound(&self) -> bool {
        self.position.is_finite() && self.orientation.is_finite() && self.orientation.is_normalized()
    }
}

/// A hand's motion from one pose to another, at rest before and after.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Motion {
    /// Until `start`.
    pub from: Pose,
    /// From `end` on.
    pub to: Pose,
    /// \[ms\].
    pub start: f64,
    /// \[ms\], not before `start`.
    pub end: f64,
}

impl Motion {
    /// At rest.
    pub fn rest(pose: Pose) -> Self {
        Self { from: pose, to: pose, start: 0.0, end: 0.0 }
    }

    /// The pose at a time \[ms\].
    pub fn at(&self, time: f64) -> Pose {
        match time {
            time if time >= self.end => self.to,
            time if time <= self.start => self.from,
            time => self.from.towards(&self.to, (time - self.start) / (self.end - self.start)),
        }
    }
}

/// Forceps in the world, an entity of their own, moved and closed by the host through the
/// [`Simulation`](crate::simulation::Simulation). *State.*
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Forceps {
    /// Name in events.
    pub name: String,
    /// How they hold.
    pub jaws: Jaws,
    /// Where they are and where they go.
    pub motion: Motion,
    /// The body of which they hold a part.
    pub body: Option<BodyId>,
    /// Force of the jaws on the tissue \[N\] at the last step; the hand feels the opposite.
    pub force: DVec3,
    /// Torque of the jaws on the tissue about their position \[N·mm\] at the last step.
    pub torque: DVec3,
}

/// Place where jaws close. Their radius in the rest shape counts from the point found.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub enum Grasp {
    /// The point of the surface nearest to the jaws' position, no farther away than this \[mm\].
    Nearest {
        /// \[mm\], above zero.
        reach: f64,
    },
    /// The first point of the surface on a ray.
    Ray {
        /// Where the ray begins \[mm\].
        origin: DVec3,
        /// Direction of the ray, of any length.
        direction: DVec3,
        /// How far it goes \[mm\].
        reach: f64,
    },
    /// A point of the tissue, in the rest shape \[mm\].
    Point(DVec3),
    /// These vertices, and no others: a region that the host has chosen.
    Vertices(Vec<VertexKey>),
}

/// Tissue of a body that closed jaws hold. *State*, but for values that the step computes.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Pinch {
    /// Name in events.
    pub name: String,
    /// The forceps in the world that hold it; `None` for a grip.
    pub forceps: Option<ForcepsId>,
    /// How they hold.
    pub jaws: Jaws,
    /// The jaws' motion, of a script that of this step.
    pub motion: Motion,
    /// Pose of a script's jaws when they closed, by which the path is turned.
    pub origin: Pose,
    /// The vertices held and their places in the jaws' frame \[mm\]; none where the jaws are open.
    pub held: Attached<DVec3>,
    /// *Derived*: 1 along the axes that the pinch prescribes, per vertex held; none where it draws by springs.
    pub prescribed: Vec<DVec3>,
    /// Force on the tissue \[N\] at the last step.
    pub force: DVec3,
    /// Torque on the tissue about the jaws' position \[N·mm\] at the last step.
    pub torque: DVec3,
    /// Whether the tissue is sliding, or has been let go of.
    pub has_slipped: bool,
    /// *Derived*: force \[N\] on each vertex held, of jaws that prescribe, at the last step.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub forces: Vec<DVec3>,
}

impl Pinch {
    /// Whether the jaws hold anything.
    pub fn is_closed(&self) -> bool {
        !self.held.rows().is_empty()
    }

    /// Whether the jaws prescribe where the tissue is.
    pub fn is_constraint(&self) -> bool {
        self.is_closed() && self.jaws.stiffness.is_none()
    }

    /// Where the jaws want the vertices that they hold at a time \[ms\]: rows and points \[mm\].
    pub fn targets(&self, time: f64) -> impl Iterator<Item = (u32, DVec3)> + '_ {
        let pose = self.motion.at(time);
        self.held.rows().iter().zip(self.held.values()).map(move |(&row, &place)| (row, pose.carry(place)))
    }

    /// Sums up the forces \[N\] on the vertices held, each given with its point of space \[mm\], at a time \[ms\].
    pub fn record(&mut self, time: f64, forces: impl Fn(usize, u32, DVec3) -> (DVec3, DVec3)) {
        let centre = self.motion.at(time).position;
        let (mut sum, mut torque) = (DVec3::ZERO, DVec3::ZERO);
        for (place, (row, target)) in self.targets(time).enumerate() {
            let (point, force) = forces(place, row, target);
            sum += force;
            torque += (point - centre).cross(force);
        }
        (self.force, self.torque) = (sum, torque);
    }

    /// Takes hold of vertices where they are, with the jaws in this pose.
    pub fn close(&mut self, vertices: &Vertices, rows: impl IntoIterator<Item = u32>, pose: &Pose) {
        let place = |row: u32| pose.place(vertices.position[row as usize]);
        self.held.replace(rows.into_iter().map(|row| (row, place(row))));
        self.has_slipped = false;
    }

    /// Opens the jaws.
    pub fn release(&mut self) {
        self.held.replace([]);
        self.prescribed.clear();
        self.forces.clear();
        (self.force, self.torque) = (DVec3::ZERO, DVec3::ZERO);
    }
}

impl Motion {
    /// Judges the poses and times as a part of a component.
    pub(crate) fn validate(&self, component: &'static str) -> Result<(), BodyError> {
        let are_times = self.start.is_finite() && self.end.is_finite() && self.start <= self.end;
        let what = "a motion needs finite times in their order, and poses of finite numbers with a unit quaternion";
        let is_right = are_times && self.from.is_sound() && self.to.is_sound();
        is_right.then_some(()).ok_or(BodyError::Contradiction { component, what })
    }
}

impl Check for Forceps {
    const OWNER: Owner = Owner::Forceps;

    fn check(&self, _: &Host<'_>) -> Result<(), BodyError> {
        self.jaws.validate("Forceps")?;
        self.motion.validate("Forceps")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_motion_goes_from_pose_to_pose() {
        let turned = Pose { position: DVec3::new(2.0, 0.0, 4.0), orientation: DQuat::from_rotation_z(1.0) };
        let motion = Motion { from: Pose::default(), to: turned, start: 10.0, end: 20.0 };
        assert_eq!((motion.at(5.0), motion.at(10.0), motion.at(20.0)), (Pose::default(), Pose::default(), turned));
        let half = motion.at(15.0);
        assert_eq!(half.position, DVec3::new(1.0, 0.0, 2.0));
        // Roundings of a slerp.
        assert!(half.orientation.angle_between(DQuat::from_rotation_z(0.5)) < 1e-7);
        let point = DVec3::new(0.3, -0.7, 1.1);
        assert!(half.carry(half.place(point)).distance(point) < 1e-15);
    }
}

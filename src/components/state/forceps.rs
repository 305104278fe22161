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

/// Least way of a target in a step, as a fraction of the way to the hand (`examples/play`, seeds 1 to 5).
pub(super) const LEAST_PACE: f64 = 0.1;

/// Growth of the pace in a step that nothing else limits (`examples/play`, seeds 1 to 5).
pub(super) const PACE_GROWTH: f64 = 2.0;

/// Place to which jaws with a stiffness draw the tissue: the hand's pose, or behind it after steps that were limited.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct JawsTarget {
    /// Pose of the jaws for which the springs are at rest.
    pub pose: Pose,
    /// Longest way of a held vertex in a step \[mm\]; infinite where the target goes with the hand.
    pub pace: f64,
}

impl JawsTarget {
    /// A target that goes with the hand.
    pub fn with_hand(pose: Pose) -> Self {
        Self { pose, pace: f64::INFINITY }
    }
}

/// Tissue of a body that closed jaws hold. *State*, but for values that the step computes.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "snapshot", serde(from = "super::saved_pinch::Bytes", into = "super::saved_pinch::Bytes"))]
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
    /// Where the jaws draw the tissue to; `None` of open ones, and where a snapshot of an earlier version is without.
    pub target: Option<JawsTarget>,
    /// *Derived*: `target` at the start of the step.
    pub start: Option<JawsTarget>,
    /// *Derived*: longest way of the target in this step \[mm\]; infinite for any.
    pub pace: f64,
    /// *Derived*: force \[N\] on each vertex held, of jaws that prescribe, at the last step.
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

    /// Whether the jaws draw by springs.
    pub fn is_elastic(&self) -> bool {
        self.is_closed() && self.jaws.stiffness.is_some()
    }

    /// Points \[mm\] to which jaws in a pose want the vertices that they hold, with their rows.
    pub fn targets(&self, pose: Pose) -> impl Iterator<Item = (u32, DVec3)> + '_ {
        self.held.rows().iter().zip(self.held.values()).map(move |(&row, &place)| (row, pose.carry(place)))
    }

    /// Begins a step, or a part of one that is retried, at a time \[ms\]. A static solve has no pace.
    pub(crate) fn begin(&mut self, time: f64, is_static: bool) {
        let target = self.target.unwrap_or_else(|| JawsTarget::with_hand(self.motion.at(time)));
        self.target = self.is_closed().then_some(target);
        self.start = self.target;
        self.pace = if is_static { f64::INFINITY } else { target.pace };
    }

    /// Whether the target goes no farther than a pace in this step.
    pub(crate) fn is_paced(&self) -> bool {
        self.is_elastic() && self.pace < f64::INFINITY
    }

    /// Pose that the step aims at, at a time \[ms\] in it: the hand's, or as far towards it as the pace allows.
    pub fn aim(&self, time: f64) -> Pose {
        let hand = self.motion.at(time);
        let Some(start) = self.start.filter(|_| self.is_paced()) else { return hand };
        let way = self.way(&start.pose, &hand);
        let most = self.pace.max(LEAST_PACE * way);
        if way <= most { hand } else { start.pose.towards(&hand, most / way) }
    }

    /// Pose of the jaws between steps, at the time reached \[ms\]: that of the target where it is behind the hand.
    pub fn pose(&self, time: f64) -> Pose {
        self.paced().map_or_else(|| self.motion.at(time), |target| target.pose)
    }

    /// Target of the jaws, if it is behind the hand after a limited step.
    pub fn paced(&self) -> Option<&JawsTarget> {
        self.target.as_ref().filter(|target| target.pace < f64::INFINITY)
    }

    /// Distance \[mm\] of the hand from the target of its jaws, for the held vertex that is farthest from its place.
    pub fn hand_ahead(&self, time: f64) -> f64 {
        self.target.map_or(0.0, |target| self.way(&target.pose, &self.motion.at(time)))
    }

    /// Longest way \[mm\] of a held vertex from one pose to another.
    pub(crate) fn way(&self, from: &Pose, to: &Pose) -> f64 {
        if from == to {
            return 0.0;
        }
        let ways = self.held.values().iter().map(|&place| from.carry(place).distance(to.carry(place)));
        ways.fold(0.0, f64::max)
    }

    /// Moves the target a part of the way to where the step has aimed at a time \[ms\], and gives its pose.
    pub(crate) fn follow(&mut self, time: f64, part: f64) -> Pose {
        let aim = self.aim(time);
        let target = match self.start.filter(|_| self.is_elastic()) {
            Some(start) if part < 1.0 => {
                JawsTarget { pose: start.pose.towards(&aim, part), pace: part * self.way(&start.pose, &aim) }
            }
            Some(start) if aim != self.motion.at(time) => {
                JawsTarget { pose: aim, pace: PACE_GROWTH * self.way(&start.pose, &aim) }
            }
            _ => JawsTarget::with_hand(aim),
        };
        self.target = Some(target);
        target.pose
    }

    /// Sums up the forces \[N\] of jaws in a pose on the vertices held, each given with its point of space \[mm\].
    pub fn record(&mut self, pose: Pose, forces: impl Fn(usize, u32, DVec3) -> (DVec3, DVec3)) {
        let centre = pose.position;
        let (mut sum, mut torque) = (DVec3::ZERO, DVec3::ZERO);
        for (place, (row, target)) in self.targets(pose).enumerate() {
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
        self.target = Some(JawsTarget::with_hand(*pose));
        (self.start, self.pace) = (self.target, f64::INFINITY);
    }

    /// Opens the jaws.
    pub fn release(&mut self) {
        self.held.replace([]);
        (self.target, self.start) = (None, None);
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

impl JawsTarget {
    /// Judges pose and pace as a part of a component.
    pub(crate) fn validate(&self, component: &'static str) -> Result<(), BodyError> {
        let what = "a target of jaws needs a pose of finite numbers with a unit quaternion, and a pace of zero or more";
        let is_right = self.pose.is_sound() && self.pace >= 0.0;
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

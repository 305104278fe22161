//! Grips of a body: forceps by script, which close at one time, follow a hand path and open.

use crate::components::BodyError;
use crate::components::check::{Check, Host, MOST_COUNTED, at_row, finite, number, place};
use crate::components::{Jaws, Pinch, Pose};
use crate::math::elementary;
use glam::{DQuat, DVec3};

/// Vertices for which every grip has room from the start: jaws are small, and close in the middle of a course.
const USUAL_PINCH: usize = 64;

/// A polyline through space over time, at rest before its first and after its last point.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Path {
    /// (time \[ms\], position \[mm\]), times ascending.
    pub points: Vec<(f64, DVec3)>,
}

impl Path {
    /// Position at a time \[ms\]; the origin for a path without points.
    pub fn at(&self, time: f64) -> DVec3 {
        let after = self.points.partition_point(|p| p.0 <= time);
        match (after.checked_sub(1).map(|i| self.points[i]), self.points.get(after)) {
            (Some((t0, a)), Some(&(t1, b))) => a.lerp(b, (time - t0) / (t1 - t0)),
            (Some((_, p)), None) | (None, Some(&(_, p))) => p,
            (None, None) => DVec3::ZERO,
        }
    }
}

/// Takes the tissue beside the tear instead of at a fixed point, as a surgeon re-grasps the flap near the tip.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct NearTip {
    /// How far behind the tip, against its last direction \[mm\].
    pub behind: f64,
    /// How far to the left of it, seen against the normal \[mm\]; negative to the right.
    pub left: f64,
    /// Axis about which the hand's path is turned, from the heading below to the tip's last direction.
    pub axis: DVec3,
    /// The tear's direction for which the path is given.
    pub heading: DVec3,
}

/// Forceps by script. In the steps that begin between `from` and `until` the jaws hold every vertex whose rest
/// position lies within their radius of `material_point`, on the surface that hangs together with it there. They carry it by the hand's
/// displacement and turn. Vertices that edits add between the held ones are held as well. Tissue that has slipped out is not taken again.
#[derive(Clone, Debug, PartialEq)]
pub struct Grip {
    /// Name in reports.
    pub name: String,
    /// Time of the grasp \[ms\].
    pub from: f64,
    /// Time at which the jaws open \[ms\].
    pub until: f64,
    /// Where the tissue is taken, in the rest shape \[mm\].
    pub material_point: DVec3,
    /// With this, the place beside the tip with the largest criterion at the time of the grasp, while there is a tip.
    pub near_tip: Option<NearTip>,
    /// How the tissue is held.
    pub jaws: Jaws,
    /// The hand's path.
    pub path: Path,
    /// Rotation vectors of the hand \[rad\] about where the jaws are: along the axis, as long as the angle. No points for a hand that does not
    /// turn.
    pub turns: Path,
}

impl Grip {
    /// Where the jaws are at a time \[ms\], if they closed at `origin`, by whose orientation path and turns are turned.
    pub fn pose(&self, origin: &Pose, time: f64) -> Pose {
        let position = origin.carry(self.path.at(time) - self.path.at(self.from));
        if self.turns.points.is_empty() {
            return Pose::at(position);
        }
        let turn = rotation(self.turns.at(time)) * rotation(self.turns.at(self.from)).inverse();
        let orientation = origin.orientation * turn * origin.orientation.inverse();
        Pose { position, orientation: orientation.normalize() }
    }
}

/// The rotation of a vector along its axis, as long as its angle \[rad\].
fn rotation(vector: DVec3) -> DQuat {
    vector.try_normalize().map_or(DQuat::IDENTITY, |axis| elementary::rotation(axis, vector.length()))
}

/// The grips of a body. *Parameter* `list`; the rest follows from it and from the forceps in the world.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Grips {
    /// The grips.
    pub list: Vec<Grip>,
    /// Pinches of the grips, one for each in their order, then those of forceps, in the order in which they closed.
    pub pinches: Vec<Pinch>,
    /// How often jaws have closed.
    pub grasp_count: u32,
}

impl Grips {
    /// The given grips, with open jaws.
    pub fn new(list: Vec<Grip>) -> Self {
        let pinch = |grip: &Grip| {
            let mut pinch = Pinch { name: grip.name.clone(), jaws: grip.jaws, ..Pinch::default() };
            pinch.held.reserve(USUAL_PINCH);
            pinch.prescribed.reserve(USUAL_PINCH);
            pinch.forces.reserve(USUAL_PINCH);
            pinch
        };
        Self { pinches: list.iter().map(pinch).collect(), list, grasp_count: 0 }
    }

    /// Whether closed jaws have hold of a vertex.
    pub fn hold(&self, vertex: u32) -> bool {
        self.pinches.iter().any(|pinch| pinch.held.value(vertex).is_some())
    }

    /// Takes down the forces \[N\] of jaws that prescribe, from those that keep the prescribed axes of each vertex where they are
    /// at the end of a step \[ms\].
    pub(crate) fn record_constraints(&mut self, time: f64, force: impl Fn(usize) -> DVec3) {
        for pinch in self.pinches.iter_mut().filter(|pinch| pinch.is_constraint()) {
            let mut forces = std::mem::take(&mut pinch.forces);
            forces.clear();
            forces.extend(
                pinch.held.rows().iter().zip(&pinch.prescribed).map(|(&row, axes)| force(row as usize) * *axes),
            );
            pinch.record(pinch.motion.at(time), |place, _, target| {
                (target, forces.get(place).copied().unwrap_or_default())
            });
            pinch.forces = forces;
        }
    }
}

impl Path {
    /// Judges it as a part of a component.
    pub(crate) fn check(&self, component: &'static str) -> Result<(), BodyError> {
        for (time, position) in &self.points {
            finite(component, "a time of the path", [*time])?;
            place(component, "a point of the path", position.to_array())?;
        }
        let descends = |pair: &&[(f64, DVec3)]| pair[1].0 < pair[0].0;
        self.points.windows(2).find(descends).map_or(Ok(()), |pair| {
            number(
                component,
                "a time of the path",
                pair[1].0,
                (false, "it must not be before that of the point before"),
            )
        })
    }
}

impl Grip {
    fn check(&self) -> Result<(), BodyError> {
        self.jaws.validate("Grips")?;
        for (what, time) in [("time of a grasp", self.from), ("time of a release", self.until)] {
            number("Grips", what, time, (!time.is_nan(), "it must be a time, or infinite"))?;
        }
        place("Grips", "material point", self.material_point.to_array())?;
        if let Some(near) = &self.near_tip {
            place("Grips", "distance from the tip", [near.behind, near.left])?;
            let directions = near.axis.to_array().into_iter().chain(near.heading.to_array());
            place("Grips", "axis or heading at the tip", directions)?;
        }
        self.path.check("Grips")?;
        self.turns.check("Grips")
    }
}

impl Check for Grips {
    fn check(&self, host: &Host<'_>) -> Result<(), BodyError> {
        self.list.iter().try_for_each(Grip::check)?;
        let wrong = |what| Err(BodyError::Contradiction { component: "Grips", what });
        if self.pinches.len() < self.list.len() {
            return wrong("there must be a pinch for each grip of the list: make them with Grips::new");
        }
        if u64::from(self.grasp_count) > MOST_COUNTED {
            return wrong("the grasps count what no run can do: they must be at most 1073741824");
        }
        for pinch in &self.pinches {
            host.rows("Grips", || format!("grip `{}`", pinch.name), pinch.held.rows())?;
            for (&row, held) in pinch.held.rows().iter().zip(pinch.held.values()) {
                finite("Grips", "place in the jaws", held.to_array()).map_err(at_row(row))?;
            }
            pinch.jaws.validate("Grips")?;
            pinch.motion.validate("Grips")?;
            if let Some(target) = &pinch.target {
                target.validate("Grips")?;
            }
            if !pinch.origin.is_sound() {
                return wrong("where jaws closed is no pose: finite numbers, and a unit quaternion");
            }
        }
        Ok(())
    }
}

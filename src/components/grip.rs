//! Forceps: a pinch that takes hold of the tissue at one time, follows a hand path and lets go.

use crate::storage::Attached;
use glam::{DQuat, DVec3};

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

/// Takes the tissue beside the tear instead of at a fixed point: what a surgeon does who re-grasps the flap near the tip.
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

/// One grasp. Between `from` and `until` every vertex whose rest position lies within `radius` of `material_point` is drawn
/// by a spring towards where the hand has carried it: its position at the grasp plus the hand's displacement since. What edits
/// add between the held vertices is held as well.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Grip {
    /// Name in reports.
    pub name: String,
    /// Time of the grasp \[ms\].
    pub from: f64,
    /// Time of the release \[ms\].
    pub until: f64,
    /// Where the tissue is taken, in the rest shape \[mm\].
    pub material_point: DVec3,
    /// With this, the place beside the tip with the largest criterion at the time of the grasp, while there is a tip.
    pub near_tip: Option<NearTip>,
    /// Pinch radius \[mm\]; the nearest vertex is always taken.
    pub radius: f64,
    /// Stiffness of the whole pinch \[N/mm\], shared by rest area (a third of a vertex's triangles'): a finer mesh, or a tear
    /// between the jaws, does not make it stiffer.
    pub stiffness: f64,
    /// The hand's path.
    pub path: Path,
}

/// The grasps of a body and what each holds. *Parameter* `list`; the rest follows from it.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Grips {
    /// The grasps.
    pub list: Vec<Grip>,
    /// Per grasp: the vertices held and their positions \[mm\] when taken; empty before and after.
    pub held: Vec<Attached<DVec3>>,
    /// Per grasp: by which its path is turned.
    pub turn: Vec<DQuat>,
    /// Per grasp: force of the hand on the tissue \[N\] at the last step.
    pub force: Vec<DVec3>,
}

impl Grips {
    /// The given grasps, none taken yet.
    pub fn new(list: Vec<Grip>) -> Self {
        Self {
            held: vec![Attached::default(); list.len()],
            turn: vec![DQuat::IDENTITY; list.len()],
            force: vec![DVec3::ZERO; list.len()],
            list,
        }
    }
}

//! Plain data that C and Rust exchange. Lengths are mm, times ms, forces N, stresses MPa.

use crate::pointer::{Array, Text};
use glam::{DMat3, DQuat, DVec3};
use rhexis::components::{Pose, Rigid};
use rhexis::simulation::{Cut, HapticModel, Hit};
use slotmap::Key;
use std::ffi::c_char;

/// Handle of a world. All bits zero: none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct RhexisWorld {
    /// Kind and serial number.
    pub bits: u64,
}

/// Handle of a body, an obstacle or a tool of one world. All bits zero: none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct RhexisEntity {
    /// Tag of the world, generation, index.
    pub bits: u64,
}

/// Handle of a snapshot. All bits zero: none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct RhexisSnapshot {
    /// Kind and serial number.
    pub bits: u64,
}

/// Handle of a recording. All bits zero: none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct RhexisRecording {
    /// Kind and serial number.
    pub bits: u64,
}

/// Handle of a maker of haptic models. All bits zero: none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct RhexisHaptics {
    /// Kind and serial number.
    pub bits: u64,
}

/// Handle of the haptic thread's end of a feed. All bits zero: none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct RhexisReceiver {
    /// Kind and serial number.
    pub bits: u64,
}

/// A point, a direction or a force.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct RhexisVec3 {
    /// Along x.
    pub x: f64,
    /// Along y.
    pub y: f64,
    /// Along z.
    pub z: f64,
}

impl RhexisVec3 {
    pub(crate) fn vector(self) -> DVec3 {
        DVec3::new(self.x, self.y, self.z)
    }
}

impl From<DVec3> for RhexisVec3 {
    fn from(v: DVec3) -> Self {
        Self { x: v.x, y: v.y, z: v.z }
    }
}

/// A unit quaternion x·i + y·j + z·k + w.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct RhexisQuat {
    /// Of i.
    pub x: f64,
    /// Of j.
    pub y: f64,
    /// Of k.
    pub z: f64,
    /// The real part; 1 for no rotation.
    pub w: f64,
}

/// Where a tool is and how it is turned.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct RhexisPose {
    /// \[mm\].
    pub position: RhexisVec3,
    /// From the tool's frame to space; a unit quaternion.
    pub orientation: RhexisQuat,
}

impl RhexisPose {
    pub(crate) fn pose(self) -> Pose {
        let RhexisQuat { x, y, z, w } = self.orientation;
        Pose { position: self.position.vector(), orientation: DQuat::from_xyzw(x, y, z, w) }
    }
}

impl From<Pose> for RhexisPose {
    fn from(pose: Pose) -> Self {
        let [x, y, z, w] = pose.orientation.to_array();
        Self { position: pose.position.into(), orientation: RhexisQuat { x, y, z, w } }
    }
}

/// Settings of a world; start from `rhexis_settings_init`. All others by `rhexis_settings_set`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct RhexisSettings {
    /// One of `RHEXIS_ACCURACY_FAST` and the others.
    pub accuracy: u32,
    /// Threads of a step; 0 for one per core. Results have the same bits for any number.
    pub threads: u32,
    /// Iterations that a body may take in one step; 0 for what the accuracy says.
    pub budget: u32,
    /// Not 0: only instructions that every processor of the family has.
    pub portable_instructions: u8,
}

/// A body from arrays; start from `rhexis_body_init`.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct RhexisBodyDesc {
    /// Its name; NULL for "body".
    pub name: Text,
    /// Rest positions \[mm\], three numbers per vertex.
    pub positions: Array<f64>,
    /// Number of vertices.
    pub vertex_count: usize,
    /// Rows of the corners, three per triangle, counter-clockwise seen from outside.
    pub triangles: Array<u32>,
    /// Number of triangles.
    pub triangle_count: usize,
    /// Fibre directions, three numbers per triangle, not zero; NULL for `fibre`.
    pub fibres: Array<f64>,
    /// Fibre direction everywhere, where `fibres` is NULL.
    pub fibre: RhexisVec3,
    /// Young's modulus along the fibres \[MPa\], > 0.
    pub young_fibre: f64,
    /// Young's modulus across the fibres \[MPa\], > 0.
    pub young_transverse: f64,
    /// Poisson's ratio: strain across from stress along the fibres.
    pub poisson_major: f64,
    /// In-plane shear modulus \[MPa\]; 0 for Huber's from the others.
    pub shear_modulus: f64,
    /// Thickness \[mm\], > 0.
    pub thickness: f64,
    /// Density \[g/mm³\], > 0.
    pub density: f64,
    /// Not 0: the body stays in its plane z = const.
    pub planar: u8,
}

/// What a step did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct RhexisReport {
    /// Steps done so far.
    pub step: u64,
    /// Time reached \[ms\].
    pub time: f64,
    /// Iterations of linear solves, of all bodies.
    pub iterations: u64,
    /// Tear tips that are alive, of all bodies.
    pub tip_count: u64,
    /// Steps of bodies, or parts of them, that were undone and retried.
    pub rolled_back: u32,
    /// 1 where a body's step was given up: its last good state stands, and an event says why.
    pub has_failed: u8,
    /// 1 where a solve has stopped because its time was up: the step would not be the same on every run.
    pub is_late: u8,
    /// 1 where tears were due that the limits of the step have left to the next one.
    pub is_cut_short: u8,
}

/// How jaws hold; start from `rhexis_jaws_init`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct RhexisJaws {
    /// Radius \[mm, rest shape\] of what is taken about the point.
    pub radius: f64,
    /// Stiffness of the pinch \[N/mm\]; 0 for a constraint.
    pub stiffness: f64,
    /// Most force \[N\] that they hold; 0 for no limit.
    pub force_limit: f64,
    /// Not 0: beyond the limit the tissue slides; 0: they let go.
    pub slides: u8,
}

/// What jaws close about; start from `rhexis_grasp_init`.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct RhexisGrasp {
    /// One of `RHEXIS_GRASP_NEAREST` and the others.
    pub kind: u32,
    /// How far the tissue may be \[mm\]: of NEAREST and RAY.
    pub reach: f64,
    /// The point in the rest shape of POINT, the origin of RAY \[mm\].
    pub point: RhexisVec3,
    /// Direction of RAY, of any length.
    pub direction: RhexisVec3,
    /// Keys of the vertices of VERTICES.
    pub vertices: Array<u64>,
    /// Their number.
    pub vertex_count: usize,
}

/// Forceps as they are.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct RhexisForcepsState {
    /// Where they are now.
    pub pose: RhexisPose,
    /// Force of the jaws on the tissue at the last step \[N\].
    pub force: RhexisVec3,
    /// Torque about their position \[N mm\].
    pub torque: RhexisVec3,
    /// The body that they hold; none where they are open.
    pub body: RhexisEntity,
    /// Distance of the hand from where the jaws draw the tissue to \[mm\]: above zero after steps that were limited.
    pub hand_ahead: f64,
}

/// A rigid body that tissue pushes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct RhexisRigid {
    /// Mass \[g\].
    pub mass: f64,
    /// Centre of mass \[mm\].
    pub centre: RhexisVec3,
    /// Velocity of the centre \[mm/ms\].
    pub velocity: RhexisVec3,
    /// Angular velocity \[rad/ms\].
    pub spin: RhexisVec3,
    /// Impulse of tissue in the last step \[N ms\].
    pub impulse: RhexisVec3,
    /// Moment of the impulse about the centre \[N mm ms\].
    pub angular_impulse: RhexisVec3,
}

impl From<Rigid> for RhexisRigid {
    fn from(rigid: Rigid) -> Self {
        let Rigid { mass, centre, velocity, spin, impulse, angular_impulse, .. } = rigid;
        Self {
            mass,
            centre: centre.into(),
            velocity: velocity.into(),
            spin: spin.into(),
            impulse: impulse.into(),
            angular_impulse: angular_impulse.into(),
        }
    }
}

/// A vertex that is pinned.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct RhexisPin {
    /// Its key.
    pub vertex: u64,
    /// Where it is in the rest shape \[mm\].
    pub rest_position: RhexisVec3,
    /// Where it is held \[mm\].
    pub place: RhexisVec3,
}

/// What a cut has done.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct RhexisCut {
    /// Length asked for \[mm\].
    pub asked: f64,
    /// Length cut \[mm, rest shape\]; 0 where a blade has cut nothing yet.
    pub made: f64,
    /// Largest distance \[mm\] of the cut from the line asked for.
    pub off_line: f64,
    /// Smallest rest angle \[rad\] of the triangles touched.
    pub smallest_angle: f64,
    /// Number of strokes.
    pub strokes: u64,
    /// Number of tips left inside the tissue.
    pub tips: u64,
    /// Number of fragments that came free.
    pub fragments: u64,
}

impl From<&Cut> for RhexisCut {
    fn from(cut: &Cut) -> Self {
        let Cut { asked, made, off_line, smallest_angle, .. } = *cut;
        let (strokes, tips, fragments) = (cut.strokes.len() as u64, cut.tips.len() as u64, cut.fragment_count as u64);
        Self { asked, made, off_line, smallest_angle, strokes, tips, fragments }
    }
}

/// A point of a body's surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct RhexisHit {
    /// Key of the triangle.
    pub triangle: u64,
    /// Keys of its corners.
    pub corners: [u64; 3],
    /// Weights of the corners, with sum 1.
    pub weights: [f64; 3],
    /// The point \[mm\].
    pub position: RhexisVec3,
    /// The same point of the tissue in the rest shape \[mm\].
    pub rest_position: RhexisVec3,
    /// Unit normal of the triangle.
    pub normal: RhexisVec3,
    /// From the ray's origin along the ray, or from the point \[mm\].
    pub distance: f64,
}

impl From<Hit> for RhexisHit {
    fn from(hit: Hit) -> Self {
        Self {
            triangle: hit.triangle.data().as_ffi(),
            corners: hit.corners.map(|key| key.data().as_ffi()),
            weights: hit.barycentric,
            position: hit.position.into(),
            rest_position: hit.rest_position.into(),
            normal: hit.normal.into(),
            distance: hit.distance,
        }
    }
}

/// Something that has happened. Which fields are used depends on the kind; the others are zero. Places are in the rest shape.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct RhexisEvent {
    /// One of `RHEXIS_EVENT_STARTED` and the others; `RHEXIS_EVENT_NONE` where there are no more.
    pub kind: u32,
    /// 1 where the criterion's margin is so small that another run could have gone the other way.
    pub is_ambiguous: u8,
    /// Step in which it happened.
    pub step: u64,
    /// Time at the end of that step \[ms\].
    pub time: f64,
    /// The body.
    pub body: RhexisEntity,
    /// Key of the tip; 0 for none.
    pub tip: u64,
    /// Where \[mm\]: of an advance, from where.
    pub at: RhexisVec3,
    /// To where \[mm\]: of an advance.
    pub to: RhexisVec3,
    /// The direction that the criterion chose: of an advance.
    pub direction: RhexisVec3,
    /// The number that the kind names.
    pub value: f64,
    /// Length \[mm\]: of a cut and a release.
    pub length: f64,
    /// The count that the kind names.
    pub count: u64,
    /// UTF-8: a reason or a name; empty where there is none. Valid until the next call of `rhexis_next_event` with this world.
    pub text: *const c_char,
}

/// The tissue at a tool, to first order.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct RhexisHapticModel {
    /// When it was made \[ms\].
    pub time: f64,
    /// The tool's position then \[mm\].
    pub position: RhexisVec3,
    /// Force of the tool on the tissue then \[N\]; the hand feels the opposite.
    pub force: RhexisVec3,
    /// By how much the force grows along a motion of the tool \[N/mm\], column after column: symmetric, positive semidefinite.
    pub stiffness: [f64; 9],
}

impl From<HapticModel> for RhexisHapticModel {
    fn from(model: HapticModel) -> Self {
        let HapticModel { time, position, force, stiffness } = model;
        Self { time, position: position.into(), force: force.into(), stiffness: stiffness.to_cols_array() }
    }
}

impl RhexisHapticModel {
    pub(crate) fn model(&self) -> HapticModel {
        let stiffness = DMat3::from_cols_array(&self.stiffness);
        HapticModel { time: self.time, position: self.position.vector(), force: self.force.vector(), stiffness }
    }
}

/// Borrowed numbers in double precision, valid until the next call that changes the world, or asks for the same again.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct RhexisViewF64 {
    /// The first number; not to be read where `count` is 0.
    pub data: *const f64,
    /// Number of numbers: three per point.
    pub count: usize,
}

/// Borrowed numbers in single precision, valid until the next call that changes the world, or asks for the same again.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct RhexisViewF32 {
    /// The first number; not to be read where `count` is 0.
    pub data: *const f32,
    /// Number of numbers: three per point.
    pub count: usize,
}

/// Borrowed rows, valid until the next call that changes the world, or asks for the same again.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct RhexisViewU32 {
    /// The first row; not to be read where `count` is 0.
    pub data: *const u32,
    /// Number of rows.
    pub count: usize,
}

/// Borrowed keys, valid until the next call that changes the world, or asks for the same again.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct RhexisViewU64 {
    /// The first key; not to be read where `count` is 0.
    pub data: *const u64,
    /// Number of keys.
    pub count: usize,
}

/// Borrowed bytes, valid as long as the object that holds them.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct RhexisViewU8 {
    /// The first byte; not to be read where `count` is 0.
    pub data: *const u8,
    /// Number of bytes.
    pub count: usize,
}

/// What has changed in a body's mesh since it was last asked. Positions change everywhere in every step.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct RhexisChanges {
    /// 1 where the whole mesh is new: the ranges span all rows.
    pub is_whole: u8,
    /// Number of vertices now: a copy is cut or extended to it.
    pub vertex_count: u32,
    /// Number of triangles now.
    pub triangle_count: u32,
    /// First row and row after the last, pair after pair, ascending: vertices that are new, have moved in the rest shape, or are now what
    /// another row was.
    pub vertices: RhexisViewU32,
    /// The same of triangles that are new, have other corners, or are now what another row was.
    pub triangles: RhexisViewU32,
}

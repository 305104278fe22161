//! Where the engine's space, in mm, lies in Bevy's world.

use bevy::math::{Quat, Vec3};
use bevy::transform::components::{GlobalTransform, Transform};
use rhexis::components::Pose;
use rhexis::glam::{DQuat, DVec3};

/// The engine's space in Bevy's world: a place, a rotation and one scale, the world's units per mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Space {
    place: DVec3,
    rotation: DQuat,
    scale: f64,
    transform: Transform,
}

impl Default for Space {
    /// One unit of the world is one millimetre.
    fn default() -> Self {
        Self { place: DVec3::ZERO, rotation: DQuat::IDENTITY, scale: 1.0, transform: Transform::IDENTITY }
    }
}

impl Space {
    /// The space that lies as a transform says; `None` unless it is finite, with a rotation and one positive scale.
    ///
    /// ```
    /// use bevy::transform::components::Transform;
    /// use bevy::math::Vec3;
    /// // A millimetre is a thousandth of a unit: the world counts in metres.
    /// assert!(bevy_rhexis::Space::new(Transform::from_scale(Vec3::splat(1e-3))).is_some());
    /// assert!(bevy_rhexis::Space::new(Transform::from_xyz(f32::NAN, 0.0, 0.0)).is_none());
    /// ```
    pub fn new(transform: Transform) -> Option<Self> {
        let Transform { translation, rotation, scale } = transform;
        let is_one = scale.x == scale.y && scale.y == scale.z;
        let is_sound = translation.is_finite() && rotation.is_finite() && rotation.is_normalized();
        if !(is_sound && is_one && scale.x > 0.0 && scale.x.is_finite()) {
            return None;
        }
        let rotation = double_rotation(rotation)?;
        Some(Self { place: double(translation), rotation, scale: f64::from(scale.x), transform })
    }

    /// The transform of what is given in mm, such as a tissue's mesh.
    pub fn transform(&self) -> Transform {
        self.transform
    }

    /// A point of the engine's space \[mm\], in the world.
    pub fn to_world(&self, point: DVec3) -> Vec3 {
        single(self.rotation * (point * self.scale) + self.place)
    }

    /// A point of the world, in the engine's space \[mm\].
    pub fn to_engine(&self, point: Vec3) -> DVec3 {
        self.rotation.inverse() * (double(point) - self.place) / self.scale
    }

    /// A direction of the world, in the engine's space.
    pub fn direction_to_engine(&self, direction: Vec3) -> DVec3 {
        self.rotation.inverse() * double(direction)
    }

    /// The pose of an entity in the engine's space; `None` where its transform is no rigid motion of finite numbers.
    pub fn pose(&self, of: &GlobalTransform) -> Option<Pose> {
        if !of.affine().is_finite() {
            return None;
        }
        let (_, rotation, place) = of.to_scale_rotation_translation();
        let orientation = (self.rotation.inverse() * double_rotation(rotation)?).normalize();
        let pose = Pose { position: self.to_engine(place), orientation };
        pose.is_sound().then_some(pose)
    }
}

fn double(v: Vec3) -> DVec3 {
    DVec3::from_array(v.to_array().map(f64::from))
}

fn single(v: DVec3) -> Vec3 {
    Vec3::from_array(v.as_vec3().to_array())
}

fn double_rotation(rotation: Quat) -> Option<DQuat> {
    let rotation = DQuat::from_array(rotation.to_array().map(f64::from));
    (rotation.is_finite() && rotation.length_squared() > 0.5).then(|| rotation.normalize())
}

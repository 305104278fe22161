//! The mouse leads the hand.

use crate::play::Capsule;
use crate::play::course::Course;
use crate::play::hand::{Hand, LIFT, met};
use bevy::input::mouse::AccumulatedMouseScroll;
use bevy::prelude::*;
use bevy_rhexis::RhexisWorld;

/// Press to grip, drag to tear, release to let go; the wheel lifts.
pub fn lead(
    mut last: Local<Option<Vec2>>,
    mut hand: ResMut<Hand>,
    mut course: ResMut<Course>,
    (world, capsule): (Res<RhexisWorld>, Res<Capsule>),
    (buttons, wheel): (Res<ButtonInput<MouseButton>>, Res<AccumulatedMouseScroll>),
    window: Single<&Window>,
    camera: Single<(&Camera, &GlobalTransform)>,
) {
    let (camera, eye) = *camera;
    hand.lift = (hand.lift + 0.1 * wheel.delta.y.signum() * f32::from(wheel.delta.y != 0.0)).clamp(0.0, LIFT.1);
    if buttons.just_released(MouseButton::Left) {
        hand.is_closed = false;
    }
    let cursor = window.cursor_position();
    let Some(ray) = cursor.and_then(|cursor| camera.viewport_to_world(eye, cursor).ok()) else { return };
    let has_moved = *last != cursor || wheel.delta.y != 0.0 || buttons.get_just_pressed().next().is_some();
    *last = cursor;
    if !has_moved {
        return;
    }
    if hand.is_closed {
        let plane = InfinitePlane3d::new(Vec3::Z);
        let height = Vec3::Z * (hand.grip.z + hand.lift);
        if let Some(target) = ray.plane_intersection_point(height, plane) {
            hand.target = target;
        }
    } else if let Some(place) = met(&world, &capsule, ray.origin, *ray.direction) {
        hand.target = place;
        if buttons.just_pressed(MouseButton::Left) {
            hand.close(place, &mut course, &world);
        }
    }
}

//! The hand: where the forceps go, and when they close; led by a gamepad, or by what calls it.

use super::Capsule;
use super::course::Course;
use bevy::prelude::*;
use bevy_rhexis::rhexis::glam::DVec3;
use bevy_rhexis::{Forceps, RhexisWorld};

/// How fast closed forceps go at the most [mm/s].
const PACE: f32 = 4.0;
/// How fast the stick draws them [mm/s].
const STICK: f32 = 3.0;
/// From this part of its way on a stick counts.
const DEAD: f32 = 0.15;
/// How high the flap is lifted at first, and at the most [mm].
pub const LIFT: (f32, f32) = (0.5, 1.5);

/// Where the hand wants the forceps.
#[derive(Resource)]
pub struct Hand {
    /// Where they are to go [mm].
    pub target: Vec3,
    /// Whether they are to be closed.
    pub is_closed: bool,
    /// How high above its grip what they hold is drawn [mm].
    pub lift: f32,
    /// Where they have closed [mm].
    pub grip: Vec3,
    is_drawing: bool,
}

impl Default for Hand {
    fn default() -> Self {
        let start = Vec3::new(2.2, 1.0, 0.0);
        Self { target: start, is_closed: false, lift: LIFT.0, grip: start, is_drawing: false }
    }
}

impl Hand {
    /// Closes at a place, and keeps the state before.
    pub fn close(&mut self, place: Vec3, course: &mut Course, world: &RhexisWorld) {
        (self.target, self.grip, self.is_closed, self.lift) = (place, place, true, LIFT.0);
        course.keep(world);
    }
}

/// The place where a ray meets the capsule.
pub fn met(world: &RhexisWorld, capsule: &Capsule, origin: Vec3, way: Vec3) -> Option<Vec3> {
    let [origin, way] = [origin, way].map(|v| DVec3::from_array(v.to_array().map(f64::from)));
    let hit = world.simulation().cast_ray(capsule.body, origin, way, 1e3)?;
    Some(Vec3::from_array(hit.position.as_vec3().to_array()))
}

/// The left stick moves, the right one lifts, the right trigger or the lower button grips.
pub fn gamepad(
    mut hand: ResMut<Hand>,
    mut course: ResMut<Course>,
    (world, capsule): (Res<RhexisWorld>, Res<Capsule>),
    time: Res<Time>,
    pads: Query<&Gamepad>,
) {
    const GRIP: [GamepadButton; 2] = [GamepadButton::RightTrigger2, GamepadButton::South];
    for pad in &pads {
        let (way, up) = (pad.left_stick(), pad.right_stick().y);
        if way.length() > DEAD {
            hand.target += (way * STICK * time.delta_secs()).extend(0.0);
        }
        if up.abs() > DEAD && hand.is_closed {
            hand.lift = (hand.lift + up * time.delta_secs()).clamp(0.0, LIFT.1);
        }
        if hand.is_closed {
            hand.target.z = hand.grip.z + hand.lift;
        } else if way.length() > DEAD
            && let Some(place) = met(&world, &capsule, hand.target.with_z(30.0), Vec3::NEG_Z)
        {
            hand.target = place;
        }
        if pad.any_just_pressed(GRIP) {
            let place = hand.target;
            hand.close(place, &mut course, &world);
        }
        if pad.any_just_released(GRIP) {
            hand.is_closed = false;
        }
    }
}

/// Brings the forceps to where the hand wants them, closed ones by their pace.
pub fn follow(mut hand: ResMut<Hand>, time: Res<Time>, forceps: Single<(&mut Transform, &mut Forceps)>) {
    let (mut transform, mut forceps) = forceps.into_inner();
    if hand.is_drawing && !forceps.is_closed {
        // They have slipped or found nothing: another press takes the tissue anew.
        hand.is_closed = false;
    }
    if hand.is_closed && hand.is_drawing {
        let way = hand.target - transform.translation;
        transform.translation += way.clamp_length_max(PACE * time.delta_secs());
    } else {
        transform.translation = hand.target;
        forceps.is_closed = hand.is_closed;
    }
    hand.is_drawing = hand.is_closed;
}

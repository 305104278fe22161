//! Back before the last grasp, and to the beginning.

use super::course::Course;
use super::hand::Hand;
use super::{Capsule, Said};
use bevy::prelude::*;
use bevy_rhexis::{Forceps, RhexisWorld};

/// R or the pad's start begins anew; Z or its east button goes back before the last grasp.
pub fn keys(
    keys: Res<ButtonInput<KeyCode>>,
    pads: Query<&Gamepad>,
    (mut world, capsule): (ResMut<RhexisWorld>, Res<Capsule>),
    (mut course, mut hand, mut said): (ResMut<Course>, ResMut<Hand>, ResMut<Said>),
    mut forceps: Single<&mut Forceps>,
) {
    let is_pressed = |button| pads.iter().any(|pad| pad.just_pressed(button));
    let is_anew = keys.just_pressed(KeyCode::KeyR) || is_pressed(GamepadButton::Start);
    let is_back = keys.just_pressed(KeyCode::KeyZ) || is_pressed(GamepadButton::East);
    if is_anew || is_back {
        (hand.is_closed, forceps.is_closed) = (false, false);
    }
    if is_anew {
        said.0 = match world.simulation_mut().restore(&capsule.start) {
            Ok(()) => {
                world.simulation_mut().record();
                *course = Course::new(&world, capsule.body);
                "Anew.".to_owned()
            }
            Err(error) => error.to_string(),
        };
    } else if is_back {
        let is_done = course.undo(&mut world);
        said.0 = if is_done { "Back before the last grasp." } else { "There is no grasp to take back." }.to_owned();
    }
}

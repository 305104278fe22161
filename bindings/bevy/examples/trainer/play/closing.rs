//! A hand that closes the tear by itself: after every grasp it takes the flap beside the tip, lifts it and draws it over along a
//! circle about the pole.

use super::Capsule;
use super::course::Course;
use super::hand::{Hand, met};
use bevy::prelude::*;
use bevy_rhexis::RhexisWorld;
use rhexis_scene::measures::Outcome;

/// Frames: the pause between grasps, the lift, the arc.
const PAUSE: u32 = 20;
const LIFT: u32 = 45;
const ARC: u32 = 405;
/// From the tip to the place of the grasp [mm], and where that is [degrees]: from inwards to backwards, the first that has tissue.
const REACH: f32 = 0.5;
const WAYS: [f32; 5] = [45.0, 22.0, 0.0, -22.0, -45.0];
/// How high [mm] and how far [degrees] the flap is drawn.
const HEIGHT: f32 = 0.5;
const ANGLE: f32 = 210.0;
/// The most grasps.
const GRASPS: u32 = 8;

/// What the hand does, by the frames that it has done so.
#[derive(Clone, Copy, Debug)]
pub enum Phase {
    Rest(u32),
    Draw { place: Vec3, frame: u32 },
    Done(u32),
}

/// The hand that plays.
#[derive(Resource, Debug)]
pub struct Closing {
    pub phase: Phase,
    pub grasps: u32,
    tip: Option<Vec3>,
}

impl Default for Closing {
    fn default() -> Self {
        Self { phase: Phase::Rest(0), grasps: 0, tip: None }
    }
}

/// Goes on by a frame of one step.
pub fn lead(
    mut closing: ResMut<Closing>,
    (mut hand, mut course): (ResMut<Hand>, ResMut<Course>),
    (world, capsule): (Res<RhexisWorld>, Res<Capsule>),
) {
    closing.phase = match closing.phase {
        Phase::Rest(frame) if frame < PAUSE => Phase::Rest(frame + 1),
        Phase::Rest(_) => {
            closing.tip = next_tip(&world, &capsule, closing.tip);
            let place = closing.tip.and_then(|tip| grasp(&world, &capsule, tip));
            match place.filter(|_| closing.grasps < GRASPS) {
                Some(place) => {
                    closing.grasps += 1;
                    hand.close(place, &mut course, &world);
                    Phase::Draw { place, frame: 0 }
                }
                None => Phase::Done(0),
            }
        }
        Phase::Draw { .. } if course.outcome() != Outcome::Unfinished => Phase::Done(0),
        Phase::Draw { frame, .. } if frame == LIFT + ARC => {
            hand.is_closed = false;
            Phase::Rest(0)
        }
        Phase::Draw { place, frame } => {
            let frame = frame + 1;
            let (up, round) = ((frame as f32 / LIFT as f32).min(1.0), frame.saturating_sub(LIFT) as f32 / ARC as f32);
            let turn = Quat::from_rotation_z((ANGLE * round).to_radians());
            hand.target = turn * (place + Vec3::Z * (HEIGHT * up));
            if frame % 10 == 0 {
                closing.tip = next_tip(&world, &capsule, closing.tip).or(closing.tip);
            }
            Phase::Draw { place, frame }
        }
        Phase::Done(frame) => Phase::Done(frame + 1),
    };
}

/// The tip that is followed: at first the one farthest from the pole, then the nearest to where it was.
fn next_tip(world: &RhexisWorld, capsule: &Capsule, before: Option<Vec3>) -> Option<Vec3> {
    let tips = world.simulation().tips(capsule.body).unwrap_or_default();
    let tips = tips.iter().map(|tip| Vec3::from_array(tip.position.as_vec3().to_array()));
    let order = |tip: &Vec3| before.map_or(-tip.xy().length(), |before| tip.distance(before));
    tips.min_by(|a, b| order(a).total_cmp(&order(b)))
}

/// Where there is tissue to take beside a tip, seen from above.
fn grasp(world: &RhexisWorld, capsule: &Capsule, tip: Vec3) -> Option<Vec3> {
    let inwards = -tip.xy().normalize_or_zero();
    WAYS.iter().find_map(|degrees| {
        let place = tip.xy() + Vec2::from_angle(degrees.to_radians()).rotate(inwards) * REACH;
        met(world, capsule, place.extend(30.0), Vec3::NEG_Z)
    })
}

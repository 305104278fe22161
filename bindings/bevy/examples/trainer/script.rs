//! A hand that closes the tear by itself: after every grasp it takes the flap beside the tip, lifts it and draws it over along a
//! circle about the pole. Pictures are taken meanwhile, and at the end the recording is repeated.

use crate::Capsule;
use crate::course::Course;
use crate::hand::{Hand, met};
use crate::screen;
use bevy::prelude::*;
use bevy::render::view::screenshot::{Screenshot, save_to_disk};
use bevy_rhexis::rhexis::report::Outcome;
use bevy_rhexis::{RhexisGizmos, RhexisWorld};
use std::path::PathBuf;

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
/// Frames from the tear's end to the last picture, and to the end.
const LAST: (u32, u32) = (30, 60);

/// What the hand does.
#[derive(Clone, Copy)]
enum Phase {
    Rest(u32),
    Draw { place: Vec3, frame: u32 },
    Done(u32),
}

/// The script, and where its pictures go.
#[derive(Resource)]
pub struct Script {
    directory: PathBuf,
    phase: Phase,
    tip: Option<Vec3>,
    grasps: u32,
}

impl Script {
    pub fn new(directory: PathBuf) -> Self {
        Self { directory, phase: Phase::Rest(0), tip: None, grasps: 0 }
    }

    fn picture(&self, commands: &mut Commands, name: &str) {
        commands.spawn(Screenshot::primary_window()).observe(save_to_disk(self.directory.join(name)));
    }
}

/// Goes on by a frame.
pub fn play(
    mut commands: Commands,
    mut script: ResMut<Script>,
    (mut hand, mut course, mut gizmos): (ResMut<Hand>, ResMut<Course>, ResMut<RhexisGizmos>),
    (mut world, capsule): (ResMut<RhexisWorld>, Res<Capsule>),
    mut exit: MessageWriter<AppExit>,
) {
    let phase = script.phase;
    script.phase = match phase {
        Phase::Rest(frame) if frame < PAUSE => Phase::Rest(frame + 1),
        Phase::Rest(_) => {
            let tip = next_tip(&world, &capsule, script.tip);
            script.tip = tip;
            let place = tip.and_then(|tip| grasp(&world, &capsule, tip));
            match place.filter(|_| script.grasps < GRASPS) {
                Some(place) => {
                    script.grasps += 1;
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
                script.tip = next_tip(&world, &capsule, script.tip).or(script.tip);
            }
            match (script.grasps, frame) {
                (2, 250) => script.picture(&mut commands, "tear.png"),
                (3, 200) => *gizmos = RhexisGizmos { stress: Some(2.0), tips: true, ..RhexisGizmos::default() },
                (3, 220) => script.picture(&mut commands, "stress.png"),
                (3, 240) => *gizmos = RhexisGizmos::default(),
                _ => {}
            }
            Phase::Draw { place, frame }
        }
        Phase::Done(frame) => {
            if frame == LAST.0 {
                script.picture(&mut commands, "end.png");
            } else if frame == LAST.1 {
                exit.write(finish(&mut world, &course));
            }
            Phase::Done(frame + 1)
        }
    };
}

/// Whether the tear has closed, and the recording repeats it.
fn finish(world: &mut RhexisWorld, course: &Course) -> AppExit {
    let outcome = course.outcome();
    println!("trainer: {outcome:?} after {:.1} s", world.simulation().time() * 1e-3);
    let kept = screen::keep(world);
    let repeated = kept.and_then(|(recording, bytes)| {
        let again = recording.replay().map_err(|error| error.to_string())?;
        Ok((recording.inputs().len(), bytes, again.hash()))
    });
    match repeated {
        Ok((inputs, bytes, hash)) => {
            println!("trainer: {inputs} inputs in {} kB repeated to the same hash {hash}", bytes / 1000);
            if outcome == Outcome::Closed { AppExit::Success } else { AppExit::error() }
        }
        Err(error) => {
            eprintln!("trainer: {error}");
            AppExit::error()
        }
    }
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

//! Pictures of the tear that the hand of `closing` makes, and at the end its recording, repeated.

use crate::play::closing::{Closing, Phase};
use crate::play::course::Course;
use crate::screen;
use bevy::prelude::*;
use bevy::render::view::screenshot::{Screenshot, save_to_disk};
use bevy::time::TimeReceiver;
use bevy_rhexis::{RhexisGizmos, RhexisWorld};
use rhexis_scene::measures::Outcome;
use std::path::PathBuf;

/// Frames from the tear's end to the last picture, and to the end.
const LAST: (u32, u32) = (30, 60);
/// Frames between two pictures of the film, and those of them that are drawn: in software drawing takes much longer than the steps.
const FILM: u32 = 40;
const DRAWN: u32 = 2;
/// Frames that are drawn on either side of a picture.
const AROUND: u32 = 4;

/// Grasp and frame of it in which a picture is taken, and whether with stress.
const PICTURES: [(u32, u32, &str, bool); 2] = [(2, 250, "tear.png", false), (3, 220, "stress.png", true)];

/// Where the pictures go, the frames so far, and whether this one is to be drawn.
#[derive(Resource)]
pub struct Script {
    directory: PathBuf,
    frames: u32,
    is_drawn: bool,
}

impl Script {
    /// Makes the directory, and `film` in it.
    ///
    /// # Errors
    /// Where it cannot be made.
    pub fn new(directory: PathBuf) -> Result<Self, String> {
        let film = directory.join("film");
        std::fs::create_dir_all(&film)
            .map_err(|error| format!("{}: {error}; give a directory that can be written", film.display()))?;
        Ok(Self { directory, frames: 0, is_drawn: true })
    }
}

/// Goes on by the frames that are not drawn.
pub fn hasten(world: &mut World) {
    // Frames have a length of their own here; Bevy warns where time comes from drawing and none is drawn.
    world.remove_resource::<TimeReceiver>();
    while !world.resource::<Script>().is_drawn {
        world.run_schedule(First);
        world.run_schedule(PreUpdate);
        world.run_schedule(Update);
        world.run_schedule(PostUpdate);
    }
}

/// Takes the pictures, says what is drawn, and ends the run.
pub fn play(
    mut commands: Commands,
    (mut script, closing, course): (ResMut<Script>, Res<Closing>, Res<Course>),
    (mut world, mut gizmos): (ResMut<RhexisWorld>, ResMut<RhexisGizmos>),
    mut exit: MessageWriter<AppExit>,
) {
    let (frame, next) = match closing.phase {
        Phase::Rest(frame) => (frame, None),
        Phase::Draw { frame, .. } => (frame, PICTURES.into_iter().find(|next| next.0 == closing.grasps)),
        Phase::Done(frame) => (frame, Some((closing.grasps, LAST.0, "end.png", false))),
    };
    let soon = next.filter(|&(_, at, ..)| at.abs_diff(frame) <= AROUND);
    // The window's first frame is black: the film begins later.
    script.frames += 1;
    let (number, of_film) = (script.frames / FILM, script.frames % FILM);
    script.is_drawn = soon.is_some() || of_film < DRAWN;
    let mut take = |path: PathBuf| {
        commands.spawn(Screenshot::primary_window()).observe(save_to_disk(path));
    };
    let has_lines = matches!(soon, Some((.., true)));
    if of_film == 0 && !has_lines {
        take(script.directory.join(format!("film/{number:03}.png")));
    }
    *gizmos = if has_lines {
        RhexisGizmos { stress: Some(2.0), tips: true, ..RhexisGizmos::default() }
    } else {
        RhexisGizmos::default()
    };
    if let Some((_, at, name, _)) = soon
        && at == frame
    {
        take(script.directory.join(name));
    }
    if matches!(closing.phase, Phase::Done(frame) if frame == LAST.1) {
        script.is_drawn = true;
        exit.write(finish(&mut world, &course));
    }
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

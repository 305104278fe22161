//! A capsulorhexis to be torn by hand: the lens capsule is drawn by forceps that follow mouse or gamepad.
//! `cargo run --release --features trainer --example trainer`; with `-- --script DIR` a scripted hand plays, and pictures are taken.

mod course;
mod eye;
mod hand;
mod screen;
mod script;

use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy::window::{PresentMode, WindowResolution};
use bevy::winit::WinitSettings;
use bevy_rhexis::rhexis::hecs;
use bevy_rhexis::rhexis::snapshot::Snapshot;
use bevy_rhexis::{RhexisPlugin, RhexisSystems, RhexisWorld};
use rhexis_scene::Document;
use std::path::PathBuf;
use std::time::Duration;

/// The most steps in a frame: what takes longer goes in slow motion.
const MOST_STEPS: u32 = 3;

/// The capsule's body, and its state before the first touch.
#[derive(Resource)]
struct Capsule {
    body: hecs::Entity,
    start: Snapshot,
}

fn main() -> AppExit {
    let mut arguments = std::env::args().skip(1);
    let pictures = match (arguments.next().as_deref(), arguments.next()) {
        (None, _) => None,
        (Some("--script"), Some(directory)) => Some(PathBuf::from(directory)),
        _ => {
            eprintln!("trainer: the arguments are none, or --script DIR");
            return AppExit::from_code(2);
        }
    };
    let (world, capsule) = match scene() {
        Ok(made) => made,
        Err(error) => {
            eprintln!("trainer: {error}");
            return AppExit::error();
        }
    };
    let mut app = App::new();
    let window = Window {
        title: "Rhexis: tear a round opening into the lens capsule".to_owned(),
        resolution: WindowResolution::new(960, 640),
        present_mode: if pictures.is_some() { PresentMode::AutoNoVsync } else { PresentMode::AutoVsync },
        ..default()
    };
    app.add_plugins(DefaultPlugins.set(WindowPlugin { primary_window: Some(window), ..default() }));
    let course = course::Course::new(&world, capsule.body);
    app.insert_resource(world).insert_resource(capsule).insert_resource(course).add_plugins(RhexisPlugin::default());
    app.init_resource::<hand::Hand>();
    app.add_systems(Startup, (eye::spawn, screen::spawn));
    app.add_systems(Update, (screen::keys, screen::view, eye::circle));
    app.add_systems(PostUpdate, (course::note, screen::show).chain().after(RhexisSystems::Show));
    match pictures {
        Some(directory) => {
            // A step in each frame, however long the picture takes.
            app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(10)));
            app.insert_resource(WinitSettings::continuous());
            app.insert_resource(script::Script::new(directory));
            app.add_systems(Update, (script::play, hand::follow).chain().before(screen::keys));
        }
        None => {
            app.add_systems(Update, (hand::mouse, hand::gamepad, hand::follow).chain().before(screen::keys));
        }
    }
    app.run()
}

/// The capsule of the catalog, coarse enough to keep pace with a hand, without the motions of its own.
fn scene() -> Result<(RhexisWorld, Capsule), Box<dyn std::error::Error>> {
    let mut document = Document::named("capsulorhexis")?;
    for change in ["bodies.0.mesh.cap.triangles=1500", "bodies.0.refinement.budget=3", "bodies.0.grips=[]"] {
        document.set(change)?;
    }
    let instance = document.scene()?.instantiate()?;
    let body = *instance.bodies.first().ok_or("the scene has no body")?;
    let mut simulation = instance.simulation;
    let start = simulation.snapshot();
    simulation.record();
    let world = RhexisWorld::new(simulation, instance.run.dt, MOST_STEPS)?;
    Ok((world, Capsule { body, start }))
}

//! A capsulorhexis to be torn by hand: the lens capsule is drawn by forceps that follow mouse or gamepad.
//! `cargo run --release --features trainer --example trainer`; with `-- --script DIR` a scripted hand plays, and pictures are taken.

mod eye;
mod mouse;
mod play;
mod screen;
mod script;

use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::time::TimeUpdateStrategy;
use bevy::window::{PresentMode, WindowResolution};
use bevy::winit::WinitSettings;
use bevy_rhexis::RhexisSystems;
use std::path::PathBuf;
use std::time::Duration;

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
    let script = match pictures.map(script::Script::new).transpose() {
        Ok(script) => script,
        Err(error) => {
            eprintln!("trainer: {error}");
            return AppExit::error();
        }
    };
    let mut app = App::new();
    let window = Window {
        title: "Rhexis: tear a round opening into the lens capsule".to_owned(),
        resolution: WindowResolution::new(960, 640),
        present_mode: if script.is_some() { PresentMode::AutoNoVsync } else { PresentMode::AutoVsync },
        ..default()
    };
    // Pictures wait for what they are drawn by, which would be made beside the first steps.
    let rendering = RenderPlugin { synchronous_pipeline_compilation: script.is_some(), ..default() };
    app.add_plugins(DefaultPlugins.set(WindowPlugin { primary_window: Some(window), ..default() }).set(rendering));
    if let Err(error) = play::play(&mut app) {
        eprintln!("trainer: {error}");
        return AppExit::error();
    }
    app.add_systems(Startup, screen::spawn).add_systems(PostStartup, eye::spawn);
    app.add_systems(Update, (screen::keys, screen::view, eye::circle).after(play::back::keys));
    app.add_systems(PostUpdate, screen::show.after(play::course::note).after(RhexisSystems::Show));
    match script {
        Some(script) => {
            // A step in each frame, however long its drawing takes.
            app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(10)));
            app.insert_resource(WinitSettings::continuous());
            app.insert_resource(script).init_resource::<play::closing::Closing>();
            app.add_systems(Update, (play::closing::lead, script::play).chain().before(play::hand::follow));
            app.add_systems(Last, script::hasten);
        }
        None => {
            app.add_systems(Update, (mouse::lead, play::hand::gamepad).chain().before(play::hand::follow));
        }
    }
    app.run()
}

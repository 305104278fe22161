//! One scene and one script in Rust, C and C#, to the hash of `script/hash.txt`; Python's tests play them too. `RHEXIS_UPDATE=1` writes it.

mod build;
use build::*;

use glam::DVec3;
use rhexis::components::{Jaws, Pose};
use rhexis::event::EventKind;
use rhexis::simulation::Grasp;
use rhexis_scene::Scene;
use std::path::PathBuf;
use std::process::Command;

fn path(file: &str) -> PathBuf {
    root().join("tests/script").join(file)
}

/// The script through the engine: the hash at the end, and how often a tip has moved on.
fn in_rust() -> String {
    let mut instance = Scene::load(&path("sheet.toml")).unwrap().instantiate().unwrap();
    let body = instance.bodies[0];
    let world = &mut instance.simulation;
    let pinned = [0, 7, 14].map(|row: usize| world.view(body).unwrap().vertex_keys[row]);
    world.pin(body, "left", &pinned).unwrap();
    world.cut(body, &[DVec3::new(3.0, 0.0, 0.0), DVec3::new(3.0, 2.0, 0.0)]).unwrap();
    let jaws = Jaws { radius: 0.2, stiffness: Some(0.2), ..Jaws::default() };
    let forceps = world.spawn_forceps("forceps", jaws, Pose::at(DVec3::new(5.0, 1.0, 0.3))).unwrap();
    world.close_forceps(forceps, body, &Grasp::Nearest { reach: 1.0 }).unwrap();
    let (mut step, mut advances) = (0.0, 0);
    while !instance.is_finished() {
        step += 1.0;
        let world = &mut instance.simulation;
        world.move_forceps(forceps, Pose::at(DVec3::new(5.0 + 0.05 * step, 1.0, 0.3 + 0.05 * step)), 5.0).unwrap();
        world.move_pins(body, "left", |pin| pin.place + DVec3::new(-0.01, 0.0, 0.0)).unwrap();
        instance.advance().unwrap();
        let events = instance.simulation.drain_events();
        advances += events.filter(|event| matches!(event.kind, EventKind::Advanced { .. })).count();
    }
    format!("{} {advances}", instance.simulation.hash())
}

#[test]
fn one_script_has_one_hash_in_rust_c_and_cs() {
    let hash = in_rust();
    if std::env::var_os("RHEXIS_UPDATE").is_some() {
        std::fs::write(path("hash.txt"), format!("{hash}\n")).unwrap();
    }
    let known = std::fs::read_to_string(path("hash.txt")).unwrap();
    assert_eq!(
        hash,
        known.trim(),
        "if the change of the numbers is meant: RHEXIS_UPDATE=1 cargo test --release -p rhexis-c --test script"
    );
    if !cfg!(unix) {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    if is_there("cc", "the script in C") {
        let (standard, source) = ("-std=c11", "tests/script/script.c");
        let build = Build { compiler: "cc", standard, source, more: &[], is_static: false };
        assert_eq!(said("script.c", Command::new(build.program(folder)).arg(path("sheet.toml"))), hash);
    }
    if has_cs("the script in C#") {
        assert_eq!(said("Script.cs", in_cs("tests/script/Script.cs", folder).arg(path("sheet.toml"))), hash);
    }
}

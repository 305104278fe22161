//! The examples are tests: each asserts a number at its end.

#[path = "../../examples/fibre_angle.rs"]
mod fibre_angle;
#[path = "../../examples/haptics_thread.rs"]
mod haptics_thread;
#[path = "../../examples/hello_tear.rs"]
mod hello_tear;
// Its main function reads the command line, which here is the test's.
#[allow(dead_code)]
#[path = "../../examples/own_mesh.rs"]
mod own_mesh;
#[path = "../../examples/own_system.rs"]
mod own_system;
#[path = "../../examples/trainer_loop.rs"]
mod trainer_loop;

#[cfg(feature = "snapshot")]
#[path = "../../examples/replay.rs"]
mod replay;

use rhexis::scene::{generate, mesh_file};
use std::fmt::Write;

#[test]
fn hello_tear_follows_the_fibres() {
    hello_tear::main().unwrap();
}

#[cfg(feature = "snapshot")]
#[test]
fn replay_ends_with_the_same_hash() {
    replay::main().unwrap();
}

#[test]
fn own_mesh_tears_a_cap_and_a_file() {
    let cap = generate::cap(10.0, 9.8, 1500).unwrap();
    let mut text = String::new();
    for p in &cap.positions {
        writeln!(text, "v {} {} {}", p.x, p.y, p.z).unwrap();
    }
    for [a, b, c] in &cap.triangles {
        writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1).unwrap();
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cap.obj");
    std::fs::write(&path, text).unwrap();
    own_mesh::tear(cap).unwrap();
    own_mesh::tear(mesh_file::read(&path).unwrap()).unwrap();
}

#[test]
fn fibre_angle_turns_the_tear() {
    fibre_angle::main().unwrap();
}

#[test]
fn trainer_loop_keeps_a_copy_for_the_renderer() {
    trainer_loop::main().unwrap();
}

#[test]
fn own_system_adds_a_force() {
    own_system::main().unwrap();
}

#[test]
fn haptics_thread_feels_what_the_simulation_feels() {
    haptics_thread::main().unwrap();
}

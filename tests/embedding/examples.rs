//! The examples are tests: each asserts a number at its end.

#[path = "../../examples/fibre_angle.rs"]
mod fibre_angle;
#[path = "../../examples/haptics_thread.rs"]
mod haptics_thread;
#[path = "../../examples/hello_tear.rs"]
mod hello_tear;
#[path = "../../examples/own_system.rs"]
mod own_system;
#[path = "../../examples/trainer_loop.rs"]
mod trainer_loop;

#[cfg(feature = "snapshot")]
#[path = "../../examples/replay.rs"]
mod replay;

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

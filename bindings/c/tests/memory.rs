//! Worlds that come and go leave no memory behind; and what a step through C costs.

#![allow(unsafe_code, reason = "pointers are handed over as C does")]

mod common;
use common::*;

use rhexis_c::pointer::Out;
use rhexis_c::saved::*;
use rhexis_c::shown::*;
use rhexis_c::types::*;
use rhexis_c::world::*;
use rhexis_scene::Scene;

/// Resident memory of this process \[bytes\], where the system tells it.
fn resident() -> Option<u64> {
    let pages: u64 = std::fs::read_to_string("/proc/self/statm").ok()?.split_whitespace().nth(1)?.parse().ok()?;
    Some(pages * 4096)
}

fn come_and_go() {
    let world = world();
    let body = sheet(world, 8);
    set(world, body, c"Tearing", c"");
    let mut forces = RhexisViewF32 { data: std::ptr::null(), count: 0 };
    let mut snapshot = RhexisSnapshot::default();
    for _ in 0..3 {
        ok(rhexis_step(world, 5.0, Out::NULL));
        ok(rhexis_normals_f32(world, body, out(&mut forces)));
    }
    ok(rhexis_snapshot_take(world, out(&mut snapshot)));
    ok(rhexis_snapshot_destroy(snapshot));
    ok(rhexis_world_destroy(world));
}

/// A world of 128 triangles is 100 kB and more: one in a hundred that stayed would be seen.
fn leaves_nothing(rounds: usize) {
    (0..50).for_each(|_| come_and_go());
    let Some(before) = resident() else { return };
    (0..rounds).for_each(|_| come_and_go());
    let grown = resident().unwrap_or(before).saturating_sub(before);
    println!("{rounds} worlds: resident memory has grown by {grown} bytes");
    // The allocator keeps pages for later: some, whatever the number of rounds.
    assert!(grown < 2 << 20, "{grown} bytes");
}

#[test]
fn worlds_leave_no_memory_behind() {
    leaves_nothing(2_000);
}

#[test]
#[ignore = "minutes: cargo test --release -p rhexis-c --test memory -- --ignored thousand"]
fn a_hundred_thousand_worlds_leave_no_memory_behind() {
    leaves_nothing(100_000);
}

/// Processor time of `fig2-tear` (1,500 triangles) through C over that through Rust, step by step in turn.
#[test]
#[ignore = "tells a time: cargo test --release -p rhexis-c --test memory -- --ignored --nocapture overhead"]
fn overhead_of_a_step() {
    let (mut rust_time, mut c_time, mut steps) = (0.0, 0.0, 0);
    let timed = |total: &mut f64, work: &mut dyn FnMut()| {
        let start = cpu_time::ProcessTime::now();
        work();
        *total += start.elapsed().as_secs_f64();
    };
    for round in 0..4 {
        let mut rust = Scene::named("fig2-tear").unwrap().instantiate().unwrap();
        let mut c = RhexisWorld::default();
        ok(rhexis_world_from_catalog(text(c"fig2-tear"), out(&mut c)));
        let mut bodies = [RhexisEntity::default()];
        ok(rhexis_bodies(c, buffer(&mut bodies), 1, out(&mut 0)));
        let mut positions = RhexisViewF64 { data: std::ptr::null(), count: 0 };
        let mut indices = RhexisViewU32 { data: std::ptr::null(), count: 0 };
        while !rust.is_finished() {
            let mut in_rust = || {
                rust.advance().unwrap();
                let view = rust.simulation.view(rust.bodies[0]).unwrap();
                std::hint::black_box((view.positions, view.triangles));
            };
            let mut in_c = || {
                ok(rhexis_advance(c, Out::NULL));
                ok(rhexis_positions(c, bodies[0], out(&mut positions)));
                ok(rhexis_indices(c, bodies[0], out(&mut indices)));
            };
            // Each goes first every other round: the first to touch a cache pays for it.
            if round % 2 == 0 {
                timed(&mut rust_time, &mut in_rust);
                timed(&mut c_time, &mut in_c);
            } else {
                timed(&mut c_time, &mut in_c);
                timed(&mut rust_time, &mut in_rust);
            }
            steps += 1;
        }
        assert_eq!(hash(c), rust.simulation.hash().0);
        ok(rhexis_world_destroy(c));
    }
    let [rust, c] = [rust_time, c_time].map(|time| time / f64::from(steps) * 1e6);
    println!("{steps} steps: {rust:.1} µs in Rust, {c:.1} µs through C, ratio {:.4}", c / rust);
}

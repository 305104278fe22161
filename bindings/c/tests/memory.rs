//! Worlds that come and go leave no memory behind; and the steps by which `overhead.sh` tells what a step through C costs.

#![allow(unsafe_code, reason = "pointers are handed over as C does")]

mod common;
use common::*;

use rhexis_c::pointer::Out;
use rhexis_c::saved::*;
use rhexis_c::shown::*;
use rhexis_c::types::*;
use rhexis_c::world::*;
use rhexis_scene::{Document, Scene};
use std::ffi::CString;

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

/// A world of 128 triangles is 100 kB and more: one in fifty that stayed would be seen.
fn leaves_nothing(rounds: usize) {
    (0..200).for_each(|_| come_and_go());
    let Some(before) = resident() else { return };
    (0..rounds).for_each(|_| come_and_go());
    let grown = resident().unwrap_or(before).saturating_sub(before);
    println!("{rounds} worlds: resident memory has grown by {grown} bytes");
    // The allocator keeps pages for later: some, whatever the number of rounds; 0.1 to 2 MB were seen.
    assert!(grown < 8 << 20, "{grown} bytes");
}

#[test]
fn worlds_leave_no_memory_behind() {
    leaves_nothing(5_000);
}

#[test]
#[ignore = "minutes: cargo test --release -p rhexis-c --test memory -- --ignored thousand"]
fn a_hundred_thousand_worlds_leave_no_memory_behind() {
    leaves_nothing(100_000);
}

/// As many steps as `overhead.sh` asks for.
fn counted_steps() -> u32 {
    std::env::var("RHEXIS_STEPS").unwrap().parse().unwrap()
}

/// 1,500 triangles on one thread: what is counted does not depend on the machine's load.
fn counted_scene() -> String {
    let mut document = Document::named("fig2-tear").unwrap();
    document.set("run.threads=1").unwrap();
    document.text().to_owned()
}

#[test]
#[ignore = "its instructions are counted: bindings/c/overhead.sh"]
fn counted_in_rust() {
    let mut rust = Scene::parse(&counted_scene(), "scene").unwrap().instantiate().unwrap();
    for _ in 0..counted_steps() {
        rust.advance().unwrap();
        let view = rust.simulation.view(rust.bodies[0]).unwrap();
        std::hint::black_box((view.positions, view.triangles));
    }
    println!("hash {}", rust.simulation.hash());
}

#[test]
#[ignore = "its instructions are counted: bindings/c/overhead.sh"]
fn counted_through_c() {
    let (scene, mut world) = (CString::new(counted_scene()).unwrap(), RhexisWorld::default());
    ok(rhexis_world_from_scene(text(&scene), text(c"scene"), out(&mut world)));
    let mut bodies = [RhexisEntity::default()];
    ok(rhexis_bodies(world, buffer(&mut bodies), 1, out(&mut 0)));
    let mut report = RhexisReport::default();
    let mut positions = RhexisViewF64 { data: std::ptr::null(), count: 0 };
    let mut indices = RhexisViewU32 { data: std::ptr::null(), count: 0 };
    for _ in 0..counted_steps() {
        ok(rhexis_advance(world, out(&mut report)));
        ok(rhexis_positions(world, bodies[0], out(&mut positions)));
        ok(rhexis_indices(world, bodies[0], out(&mut indices)));
        std::hint::black_box((&positions, &indices));
    }
    println!("hash {:016x}", hash(world));
}

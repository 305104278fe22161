//! What calls refuse, and why.

#![allow(unsafe_code, reason = "pointers are handed over as C does")]

mod common;
use common::*;

use rhexis_c::abi::*;
use rhexis_c::body::*;
use rhexis_c::component::*;
use rhexis_c::pointer::{Array, In, Out, Text};
use rhexis_c::saved::*;
use rhexis_c::shown::*;
use rhexis_c::status::*;
use rhexis_c::tools::*;
use rhexis_c::types::*;
use rhexis_c::world::*;
use std::ffi::CStr;

const NO_WORLD: RhexisWorld = RhexisWorld { bits: 0 };
const UP: RhexisVec3 = RhexisVec3 { x: 0.0, y: 0.0, z: 1.0 };

#[test]
fn stale_foreign_and_wrong_handles_are_refused() {
    let (here, there) = (world(), world());
    let (body, other) = (sheet(here, 2), sheet(there, 2));
    let mut view = RhexisViewF64 { data: std::ptr::null(), count: 0 };
    refused(rhexis_positions(here, other, out(&mut view)), RhexisStatus::InvalidHandle, "belongs to another world");
    refused(rhexis_positions(here, RhexisEntity { bits: 0 }, out(&mut view)), RhexisStatus::InvalidHandle, "is none");
    let mut blade = RhexisEntity::default();
    ok(rhexis_blade_create(here, 0.5, 0.1, out(&mut blade)));
    refused(rhexis_positions(here, blade, out(&mut view)), RhexisStatus::InvalidHandle, "is no body");
    ok(rhexis_entity_destroy(here, body));
    refused(rhexis_positions(here, body, out(&mut view)), RhexisStatus::InvalidHandle, "is destroyed");
    // Another body in its place has another handle.
    assert_ne!(sheet(here, 2), body);
    refused(rhexis_positions(here, body, out(&mut view)), RhexisStatus::InvalidHandle, "is destroyed");
    ok(rhexis_world_destroy(here));
    refused(rhexis_world_destroy(here), RhexisStatus::InvalidHandle, "is destroyed");
    refused(rhexis_step(here, 1.0, Out::NULL), RhexisStatus::InvalidHandle, "is destroyed");
    refused(rhexis_step(NO_WORLD, 1.0, Out::NULL), RhexisStatus::InvalidHandle, "is no handle of a world");
    let snapshot = RhexisSnapshot { bits: there.bits };
    refused(rhexis_restore(there, snapshot), RhexisStatus::InvalidHandle, "is no handle of a snapshot");
    ok(rhexis_world_destroy(there));
}

#[test]
fn bad_arguments_are_refused_and_say_why() {
    let world = world();
    let body = sheet(world, 2);
    let invalid = RhexisStatus::InvalidArgument;
    refused(rhexis_time(world, Out::NULL), invalid, "time is a null pointer");
    refused(rhexis_world_from_scene(Text::NULL, Text::NULL, Out::NULL), invalid, "world is a null pointer");
    let mut time = [0.0; 2];
    // SAFETY: within the array, if not aligned: it is refused.
    let askew = unsafe { Out::new(time.as_mut_ptr().byte_add(1)) };
    refused(rhexis_time(world, askew), invalid, "time is not aligned to 8 bytes");
    let answer = rhexis_set(world, body, text(c"\xff"), text(c""));
    refused(answer, invalid, "the component's name is not UTF-8");
    refused(rhexis_cut(world, body, Array::NULL, 2, Out::NULL), invalid, "the points is a null pointer");
    refused(rhexis_cut(world, body, Array::NULL, usize::MAX, Out::NULL), invalid, "too many points");
    let answer = rhexis_cut(world, body, array(&[0.0]), usize::MAX / 4, Out::NULL);
    refused(answer, invalid, "more than memory holds");
    refused(rhexis_cut(world, body, Array::NULL, 0, Out::NULL), RhexisStatus::Refused, "");
    refused(rhexis_step(world, f64::NAN, Out::NULL), RhexisStatus::Refused, "NaN");
    refused(rhexis_advance(world, Out::NULL), RhexisStatus::Refused, "not from a scene");
    refused(rhexis_world_create(input(&blank_settings()), out(&mut { NO_WORLD })), invalid, "no accuracy 9");
    let answer = rhexis_world_from_scene(text(c"[scene]\nnam = 1"), text(c"my.toml"), out(&mut { NO_WORLD }));
    refused(answer, RhexisStatus::Scene, "my.toml:2:1");
    let answer = rhexis_find_body(world, text(c"nobody"), out(&mut { body }));
    refused(answer, RhexisStatus::NotFound, "there is no body `nobody`");
    refused(rhexis_body_create(world, In::NULL, out(&mut { body })), invalid, "the description is a null pointer");
    let answer = rhexis_obstacle_create(world, text(c"shape = { Ball = 1 }"), out(&mut { body }));
    refused(answer, RhexisStatus::Scene, "Obstacle");
    let far = RhexisVec3 { x: 99.0, y: 0.0, z: 0.0 };
    // SAFETY: all numbers, which may be zero.
    let mut hit: RhexisHit = unsafe { std::mem::zeroed() };
    refused(rhexis_nearest(world, body, far, 1.0, out(&mut hit)), RhexisStatus::NotFound, "no tissue within reach");
    ok(rhexis_nearest(world, body, RhexisVec3 { x: 1.1, y: 0.4, z: 0.5 }, 1.0, out(&mut hit)));
    assert_eq!(hit.distance, 0.5);
    refused(rhexis_apply_force(world, body, 7, UP), invalid, "0x7 is no key of a vertex");
    refused(rhexis_apply_force(world, body, u64::MAX, UP), RhexisStatus::Refused, "no vertex");
    ok(rhexis_world_destroy(world));
}

#[test]
fn versions_and_names_are_told() {
    refused(rhexis_check_abi(RHEXIS_ABI_VERSION + 1, 0), RhexisStatus::AbiMismatch, "build the host with");
    refused(rhexis_check_abi(RHEXIS_ABI_VERSION, 1 << 40), RhexisStatus::AbiMismatch, "lacks the features");
    let answer = rhexis_check_abi(RHEXIS_ABI_VERSION, RHEXIS_FEATURE_DIRECT);
    if answer != RhexisStatus::Ok {
        refused(answer, RhexisStatus::AbiMismatch, "--features direct");
    }
    // SAFETY: all numbers and pointers, which may be zero.
    let mut info: RhexisBuildInfo = unsafe { std::mem::zeroed() };
    ok(rhexis_build_info(out(&mut info)));
    ok(rhexis_check_abi(info.abi_version, info.features));
    // SAFETY: a text of the library.
    assert_eq!(unsafe { CStr::from_ptr(info.version) }.to_str(), Ok(env!("CARGO_PKG_VERSION")));
    for (status, name) in RhexisStatus::ALL {
        // SAFETY: a text of the library.
        assert_eq!(unsafe { CStr::from_ptr(rhexis_status_name(status as i32)) }, name);
    }
    // SAFETY: a text of the library.
    assert_eq!(unsafe { CStr::from_ptr(rhexis_status_name(99)) }, c"UNKNOWN");
    // SAFETY: a text of the library.
    assert_eq!(unsafe { CStr::from_ptr(rhexis_component_name(0)) }, c"Attributes");
    assert!(rhexis_component_name(usize::MAX).is_null());
}

/// Two threads step one world: one of them is told that it is busy, and the steps that were made are those of one thread.
#[test]
fn two_threads_at_one_world() {
    let shared = world();
    let body = sheet(shared, 8);
    set(shared, body, c"Gravity", c"acceleration = [0, 0, -9.81e-3]");
    let work = move || {
        let steps = (0..200).map(|_| rhexis_step(shared, 1.0, Out::NULL));
        steps.filter(|status| matches!(status, RhexisStatus::Ok) || *status != RhexisStatus::Busy).map(ok).count()
    };
    let threads = [std::thread::spawn(work), std::thread::spawn(work)];
    let done: usize = threads.into_iter().map(|thread| thread.join().unwrap()).sum();
    let alone = world();
    let body = sheet(alone, 8);
    set(alone, body, c"Gravity", c"acceleration = [0, 0, -9.81e-3]");
    (0..done).for_each(|_| ok(rhexis_step(alone, 1.0, Out::NULL)));
    assert_eq!(hash(shared), hash(alone));
    ok(rhexis_world_destroy(shared));
    ok(rhexis_world_destroy(alone));
}

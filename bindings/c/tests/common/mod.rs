//! What tests hand to C functions, and a small sheet.

#![allow(dead_code, reason = "each test takes what it needs")]

use rhexis_c::abi::*;
use rhexis_c::body::*;
use rhexis_c::component::*;
use rhexis_c::pointer::{Array, Buffer, In, Out, Text};
use rhexis_c::status::*;
use rhexis_c::types::*;
use rhexis_c::world::*;
use std::ffi::CStr;

pub fn out<T>(value: &mut T) -> Out<T> {
    // SAFETY: a reference may be written to, and calls do not keep what they are given.
    unsafe { Out::new(value) }
}

pub fn input<T>(value: &T) -> In<T> {
    // SAFETY: a reference may be read, and calls do not keep what they are given.
    unsafe { In::new(value) }
}

pub fn array<T>(values: &[T]) -> Array<T> {
    // SAFETY: a slice may be read; tests pass its length or less beside.
    unsafe { Array::new(values.as_ptr()) }
}

pub fn buffer<T>(values: &mut [T]) -> Buffer<T> {
    // SAFETY: a slice may be written to; tests pass its length or less beside.
    unsafe { Buffer::new(values.as_mut_ptr()) }
}

pub fn text(text: &CStr) -> Text {
    // SAFETY: it ends with a zero.
    unsafe { Text::new(text.as_ptr()) }
}

pub fn message() -> String {
    // SAFETY: the library's own text, copied before the next call.
    unsafe { CStr::from_ptr(rhexis_last_error_message()) }.to_string_lossy().into_owned()
}

/// What a view shows; nothing for an empty one.
pub fn seen<T: Copy>(data: *const T, count: usize) -> Vec<T> {
    if count == 0 {
        return Vec::new();
    }
    // SAFETY: a view of the last call on this world.
    unsafe { std::slice::from_raw_parts(data, count) }.to_vec()
}

#[track_caller]
pub fn ok(status: RhexisStatus) {
    assert_eq!(status, RhexisStatus::Ok, "{}", message());
}

/// Refused with this status, and a message that says so.
#[track_caller]
pub fn refused(status: RhexisStatus, expected: RhexisStatus, part: &str) {
    let message = message();
    assert_eq!(status, expected, "{message}");
    assert!(message.contains(part), "{message}");
}

/// An empty world of one thread: tests run beside each other.
pub fn world() -> RhexisWorld {
    let (mut settings, mut world) = (blank_settings(), RhexisWorld::default());
    ok(rhexis_settings_init(out(&mut settings)));
    settings.threads = 1;
    ok(rhexis_world_create(input(&settings), out(&mut world)));
    world
}

pub fn blank_settings() -> RhexisSettings {
    RhexisSettings { accuracy: 9, threads: 9, budget: 9, portable_instructions: 9 }
}

/// A grid of `n` × `n` squares of 1 mm in the plane z = 0: positions and corners.
pub fn grid(n: u32) -> (Vec<f64>, Vec<u32>) {
    let line = || 0..=n;
    let positions = line().flat_map(|y| line().flat_map(move |x| [f64::from(x), f64::from(y), 0.0])).collect();
    let square = |x: u32, y: u32| {
        let a = y * (n + 1) + x;
        [a, a + 1, a + n + 2, a, a + n + 2, a + n + 1]
    };
    let triangles = (0..n).flat_map(|y| (0..n).flat_map(move |x| square(x, y))).collect();
    (positions, triangles)
}

/// A body of that grid.
pub fn sheet(world: RhexisWorld, n: u32) -> RhexisEntity {
    let (positions, triangles) = grid(n);
    // SAFETY: all numbers and pointers, which may be zero.
    let mut desc: RhexisBodyDesc = unsafe { std::mem::zeroed() };
    ok(rhexis_body_init(out(&mut desc)));
    desc.name = text(c"sheet");
    (desc.positions, desc.vertex_count) = (array(&positions), positions.len() / 3);
    (desc.triangles, desc.triangle_count) = (array(&triangles), triangles.len() / 3);
    let mut body = RhexisEntity::default();
    ok(rhexis_body_create(world, input(&desc), out(&mut body)));
    body
}

/// Checks the version, as every host does.
pub fn check_abi() {
    ok(rhexis_check_abi(RHEXIS_ABI_VERSION, 0));
}

/// A component by TOML.
#[track_caller]
pub fn set(world: RhexisWorld, entity: RhexisEntity, component: &CStr, toml: &CStr) {
    ok(rhexis_set(world, entity, text(component), text(toml)));
}

pub fn hash(world: RhexisWorld) -> u64 {
    let mut hash = 0;
    ok(rhexis_hash(world, out(&mut hash)));
    hash
}

//! The body of a snapshot, under a head that is right.
#![no_main]

#[path = "../../../crates/rhexis-scene/tests/hostile/mod.rs"]
mod hostile;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|body: &[u8]| hostile::snapshot(body));

//! Edits of small meshes.
#![no_main]

#[path = "../../../crates/rhexis-scene/tests/hostile/mod.rs"]
mod hostile;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| hostile::edits(bytes));

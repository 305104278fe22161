//! Scene files.
#![no_main]

#[path = "../../../crates/rhexis-scene/tests/hostile/mod.rs"]
mod hostile;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| hostile::scene(rhexis_scene::Document::new(text, "fuzz.toml")));

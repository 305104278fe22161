//! Scene files.
#![no_main]

#[path = "../../hostile/mod.rs"]
mod hostile;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| hostile::scene(rhexis::scene::Document::new(text, "fuzz.toml")));

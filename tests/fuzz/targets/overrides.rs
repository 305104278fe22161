//! What `--set` puts into the scenes of the catalog: a scene by its number, then a line for each.
#![no_main]

#[path = "../../../crates/rhexis-scene/tests/hostile/mod.rs"]
mod hostile;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|input: (u8, &str)| hostile::overrides(input.0, input.1));

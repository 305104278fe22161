//! Mesh files of all formats; the first byte chooses which.
#![no_main]

#[path = "../../../crates/rhexis-scene/tests/hostile/mod.rs"]
mod hostile;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let [which, rest @ ..] = bytes {
        let extensions = rhexis_scene::mesh_file::EXTENSIONS;
        hostile::mesh(extensions[usize::from(*which) % extensions.len()], rest);
    }
});

//! The example is a test: it asserts a number at its end.

#[allow(dead_code, reason = "its main function is called by the example alone")]
#[path = "../../examples/own_mesh.rs"]
mod own_mesh;

use rhexis_scene::{generate, mesh_file};
use std::fmt::Write;

#[test]
fn own_mesh_tears_a_cap_and_a_file() {
    let cap = generate::cap(10.0, 9.8, 1500).unwrap();
    let mut text = String::new();
    for p in &cap.positions {
        writeln!(text, "v {} {} {}", p.x, p.y, p.z).unwrap();
    }
    for [a, b, c] in &cap.triangles {
        writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1).unwrap();
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cap.obj");
    std::fs::write(&path, text).unwrap();
    own_mesh::tear(cap).unwrap();
    own_mesh::tear(mesh_file::read(&path).unwrap()).unwrap();
}

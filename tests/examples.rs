//! The examples are tests: each asserts a number at its end.
#![cfg(feature = "scenes")]

#[path = "../examples/hello_tear.rs"]
mod hello_tear;
#[path = "../examples/own_mesh.rs"]
mod own_mesh;

use rhexis::scene::{generate, mesh_file};

#[test]
fn hello_tear_follows_the_fibres() {
    hello_tear::main().unwrap();
}

#[test]
fn own_mesh_tears_a_generated_cap_and_a_file() {
    own_mesh::tear(generate::cap(10.0, 9.8, 1500).unwrap()).unwrap();
}

//! Snapshots that an earlier version has written go on as they did then.
#![cfg(feature = "snapshot")]

use rhexis::simulation::Simulation;
use rhexis::snapshot::Snapshot;

/// Written by version 14 of the format: a notched square of 112 triangles after 20 steps of 10 ms, and the hash that 20 more
/// lead to from there: a change of the numerics that is meant changes the second hash, never the first.
#[test]
fn a_snapshot_of_version_14_goes_on_to_the_same_bits() {
    let bytes = include_bytes!("data/version-14.snapshot");
    assert_eq!(bytes[8], 14);
    let snapshot = Snapshot::from_bytes(bytes).unwrap();
    assert_eq!(snapshot.writer(), "");
    let mut simulation = Simulation::from_snapshot(&snapshot).unwrap();
    assert_eq!(simulation.hash().to_string(), "513fe6662dc09d7d");
    (0..20).for_each(|_| _ = simulation.step(10.0).unwrap());
    // Its Cholesky factor is passed over: builds with and without the feature go on alike.
    assert_eq!(simulation.hash().to_string(), "2b74fe12225417a3");
    // What is written again has the present version and a writer.
    let again = simulation.snapshot().to_bytes().unwrap();
    assert!(again[8] > 14 && Snapshot::from_bytes(&again).unwrap().writer() == env!("CARGO_PKG_VERSION"));
}

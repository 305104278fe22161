//! What it costs to keep and to take back a state: `cargo bench --bench snapshots`.

use divan::{Bencher, counter::BytesCount};
use rhexis::simulation::Simulation;
use rhexis::snapshot::Snapshot;
use rhexis_scene::Document;

fn main() {
    divan::main();
}

/// Scenes of some 5,000 triangles, their time steps \[ms\] and how many of them have gone.
const FLAT: &str = "fig2-tear, 4,992 triangles";
const CAPSULE: &str = "capsulorhexis, 4,000 triangles and refined";

fn state(name: &str) -> Simulation {
    let (scene, changes, steps, dt) = match name {
        FLAT => ("fig2-tear", &["bodies.0.mesh.grid.nx=52", "bodies.0.mesh.grid.ny=48"][..], 130, 2.0),
        _ => ("capsulorhexis", &["bodies.0.mesh.cap.triangles=4000"][..], 50, 20.0),
    };
    let mut document = Document::named(scene).expect("a scene of the catalog");
    for change in changes.iter().chain(&["run.threads=1"]) {
        document.set(change).expect("a value of the scene");
    }
    let scene = document.scene().expect("a sound scene");
    let mut simulation = scene.instantiate().expect("bodies of the scene").simulation;
    for _ in 0..steps {
        simulation.step(dt).expect("a step");
    }
    simulation
}

#[divan::bench(args = [FLAT, CAPSULE])]
fn take(bencher: Bencher, name: &str) {
    let simulation = state(name);
    bencher.bench_local(|| simulation.snapshot());
}

#[divan::bench(args = [FLAT, CAPSULE])]
fn restore(bencher: Bencher, name: &str) {
    let mut simulation = state(name);
    let snapshot = simulation.snapshot();
    bencher.bench_local(|| simulation.restore(&snapshot));
}

#[divan::bench(args = [FLAT, CAPSULE])]
fn to_bytes(bencher: Bencher, name: &str) {
    let snapshot = state(name).snapshot();
    let size = snapshot.to_bytes().map_or(0, |bytes| bytes.len());
    bencher.counter(BytesCount::new(size)).bench_local(|| snapshot.to_bytes());
}

#[divan::bench(args = [FLAT, CAPSULE])]
fn from_bytes(bencher: Bencher, name: &str) {
    let bytes = state(name).snapshot().to_bytes().unwrap_or_default();
    bencher.counter(BytesCount::new(bytes.len())).bench_local(|| Snapshot::from_bytes(&bytes));
}

#[divan::bench(args = [FLAT, CAPSULE])]
fn hash(bencher: Bencher, name: &str) {
    let simulation = state(name);
    bencher.bench_local(|| simulation.hash());
}

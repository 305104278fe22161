//! What is left out where it is not needed, and what that saves: the tear criterion away from tips, systems that no body needs,
//! frames that nobody looks at; and what the order of rows costs. One thread.
//!
//! `cargo bench --bench skips`. Compare medians of one run; `docs/performance.md` has some.

mod fig2;

use divan::{Bencher, counter::ItemsCount};
use fig2::{LARGE, square};
use glam::DVec3;
use rhexis::components::{Curve, Fibres, Tearing};
use rhexis::membrane::Membrane;
use rhexis::schedule::{STEP, Stage};
use rhexis::settings::Settings;
use rhexis::simulation::Simulation;
use rhexis::storage::{BodyId, TriangleMesh};
use rhexis::systems::StepContext;
use rhexis::systems::forces::{assembly, corotation};
use rhexis::systems::step::integrate;

fn main() {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().expect("no pool before this one");
    divan::main();
}

fn stretched(body: Membrane) -> (Simulation, BodyId, StepContext) {
    let mut simulation = Simulation::new(Settings { threads: 1, ..Settings::default() }).expect("threads");
    let body = simulation.spawn(body).expect("an admissible body");
    simulation.step(1.0).expect("a time step");
    let step = StepContext::of_step(simulation.settings(), 1.0, 2.0);
    (simulation, body, step)
}

/// Fibres along the pull: along them the stress is high and so is the strength.
fn sheet(strength_along_fibres: f64, may_initiate: bool) -> Membrane {
    let tearing = Tearing { strength_across_fibres: 1e3, strength_along_fibres, may_initiate, ..Tearing::default() };
    square(LARGE, Curve::constant(0.15)).fibres(Fibres::at_degrees(0.0)).with(tearing)
}

fn decide(bencher: Bencher, body: Membrane, has_tip: bool) {
    let (mut simulation, body, step) = stretched(body);
    if has_tip {
        simulation.cut(body, &[DVec3::new(15.0, 30.0, 0.0), DVec3::new(15.0, 27.0, 0.0)]).expect("a notch");
    }
    let system = STEP.iter().find(|system| system.stage == Stage::Decide).expect("the criterion");
    bencher.bench_local(|| (system.run)(simulation.world_mut(), &step));
}

/// One tip, and no tear may start elsewhere.
#[divan::bench]
fn criterion_at_one_tip(bencher: Bencher) {
    decide(bencher, sheet(1e3, false), true);
}

/// A tear may start anywhere, and no stress reaches the smallest strength.
#[divan::bench]
fn criterion_under_the_bound(bencher: Bencher) {
    decide(bencher, sheet(1e3, true), false);
}

/// The stress is above the smallest strength everywhere, and every place has to be searched.
#[divan::bench]
fn criterion_above_the_bound(bencher: Bencher) {
    decide(bencher, sheet(1e-3, true), false);
}

/// All systems that find no body: what a plain elastic sheet pays for everything that it does not carry.
#[divan::bench]
fn systems_without_a_body(bencher: Bencher) {
    let (mut simulation, _, step) = stretched(square(LARGE, Curve::constant(0.15)));
    let world = simulation.world_mut();
    // Those of a redone step would have marked the body as done for the others.
    let of_first_pass = STEP.iter().filter(|system| system.stage != Stage::Resume);
    let idle: Vec<_> = of_first_pass.filter(|system| (system.run)(world, &step) == 0).collect();
    bencher
        .counter(ItemsCount::new(idle.len()))
        .bench_local(|| idle.iter().map(|system| (system.run)(world, &step)).sum::<usize>());
}

/// What an observer asks for when it wants to see something.
#[divan::bench]
fn frame(bencher: Bencher) {
    let (simulation, ..) = stretched(sheet(1e3, false));
    bencher.bench_local(|| simulation.frame());
}

/// Triangles and vertices in random order.
fn shuffled(mesh: &TriangleMesh) -> TriangleMesh {
    let mut state = 1_u64;
    let mut shuffle = |count: usize| {
        let mut order: Vec<usize> = (0..count).collect();
        for i in (1..count).rev() {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            order.swap(i, (state >> 33) as usize % (i + 1));
        }
        order
    };
    let (vertices, triangles) = (shuffle(mesh.positions.len()), shuffle(mesh.triangles.len()));
    let mut row = vec![0; vertices.len()];
    (0..).zip(&vertices).for_each(|(new, &old)| row[old] = new);
    TriangleMesh {
        positions: vertices.iter().map(|&old| mesh.positions[old]).collect(),
        triangles: triangles.iter().map(|&old| mesh.triangles[old].map(|v| row[v as usize])).collect(),
        ..TriangleMesh::default()
    }
}

/// Corotation and assembly of 150,000 triangles, whose rows are as the grid has them, in random order, or sorted again.
#[divan::bench(args = ["grid", "random", "reordered"], max_time = 2)]
fn forces(bencher: Bencher, order: &str) {
    let grid = rhexis::generate::grid(30.0, 30.0, 300, 250).expect("a grid");
    let mesh = if order == "grid" { grid } else { shuffled(&grid) };
    let count = mesh.triangles.len();
    let material = rhexis::components::Material::allard_2009();
    let mut simulation = Simulation::new(Settings { threads: 1, ..Settings::default() }).expect("threads");
    let body = simulation.spawn(Membrane::new("sheet", mesh, material).planar()).expect("an admissible body");
    if order == "reordered" {
        simulation.reorder(body).expect("a body");
    }
    simulation.step(1.0).expect("a time step");
    let step = StepContext::of_step(simulation.settings(), 1.0, 2.0);
    let world = simulation.world_mut();
    integrate::begin(world, &step);
    bencher
        .counter(ItemsCount::new(count))
        .bench_local(|| corotation::corotation(world, &step) + assembly::assembly(world, &step));
}

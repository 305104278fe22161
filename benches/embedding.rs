//! What a program that embeds the engine asks for between steps, on 5,060 triangles: `cargo bench --bench embedding`.

mod fig2;

use divan::{Bencher, counter::ItemsCount};
use fig2::{hand, square};
use glam::DVec3;
use rhexis::components::{ChangeSet, Changes, Grip, Grips, Jaws, Path, Tearing};
use rhexis::settings::Settings;
use rhexis::simulation::{DebugLines, Haptics, Simulation, normals};
use rhexis::storage::BodyId;
use std::cell::RefCell;

const CELLS: [usize; 2] = [55, 46];
const COUNT: usize = 2 * CELLS[0] * CELLS[1];

fn main() {
    divan::main();
}

/// The square under a trembling hand, pinched near its middle.
fn pinched() -> (Simulation, BodyId) {
    let grip = Grip {
        name: "forceps".into(),
        near_tip: None,
        from: 0.0,
        until: f64::INFINITY,
        material_point: DVec3::new(12.0, 17.0, 0.0),
        jaws: Jaws { radius: 1.0, stiffness: Some(0.2), ..Jaws::default() },
        path: Path { points: vec![(0.0, DVec3::ZERO), (1000.0, DVec3::new(2.0, 1.0, 0.0))] },
        turns: Path::default(),
    };
    let mut simulation = Simulation::new(Settings { threads: 1, ..Settings::default() }).expect("threads");
    let body = square(CELLS, hand()).with(Grips::new(vec![grip])).with(Changes::default());
    let body = simulation.spawn(body).expect("an admissible body");
    for _ in 0..100 {
        simulation.step(1.0).expect("a time step");
    }
    (simulation, body)
}

#[divan::bench(max_time = 2)]
fn step(bencher: Bencher) {
    let (mut simulation, _) = pinched();
    bencher.counter(ItemsCount::new(COUNT)).bench_local(|| simulation.step(1.0).map(|report| report.time));
}

/// A model per step, each from the last one's answers.
#[divan::bench(args = [1000.0, 5.0], max_time = 3)]
fn haptic_model(bencher: Bencher, horizon: f64) {
    let (simulation, body) = pinched();
    let shared = RefCell::new((simulation, Haptics::new(horizon)));
    let next = || {
        let (simulation, haptics) = &mut *shared.borrow_mut();
        let coupling = simulation.coupling_of_grip(body, 0).expect("a closed grip");
        haptics.model(simulation, body, &coupling).expect("a model")
    };
    for _ in 0..50 {
        next();
    }
    let move_on = || {
        shared.borrow_mut().0.step(1.0).expect("a time step");
    };
    bencher.counter(ItemsCount::new(COUNT)).with_inputs(move_on).bench_local_values(|()| next());
}

/// The same from what the steps' solves have left.
#[divan::bench(max_time = 3)]
fn refreshed_haptic_model(bencher: Bencher) {
    let (simulation, body) = pinched();
    let shared = RefCell::new((simulation, Haptics::new(1.0)));
    let next = || {
        let (simulation, haptics) = &mut *shared.borrow_mut();
        let coupling = simulation.coupling_of_grip(body, 0).expect("a closed grip");
        haptics.refresh(simulation, body, &coupling).expect("a model")
    };
    let move_on = || {
        shared.borrow_mut().0.step(1.0).expect("a time step");
    };
    for _ in 0..50 {
        move_on();
        next();
    }
    bencher.counter(ItemsCount::new(COUNT)).with_inputs(move_on).bench_local_values(|()| next());
}

#[divan::bench]
fn vertex_normals(bencher: Bencher) {
    let (mut simulation, body) = pinched();
    let mut into = Vec::new();
    bencher.counter(ItemsCount::new(COUNT)).bench_local(|| {
        let view = simulation.view(body).expect("a body");
        normals(view.positions, view.triangles, &mut into);
    });
}

#[divan::bench]
fn positions_between_steps(bencher: Bencher) {
    let (mut simulation, body) = pinched();
    let mut into = Vec::new();
    bencher.counter(ItemsCount::new(COUNT)).bench_local(|| {
        simulation.view(body).expect("a body").positions_before(0.4, &mut into);
    });
}

#[divan::bench]
fn ray(bencher: Bencher) {
    let (simulation, body) = pinched();
    let from = DVec3::new(13.0, 15.0, 9.0);
    bencher.counter(ItemsCount::new(COUNT)).bench_local(|| simulation.cast_ray(body, from, DVec3::NEG_Z, 99.0));
}

#[divan::bench]
fn nearest(bencher: Bencher) {
    let (simulation, body) = pinched();
    let from = DVec3::new(13.0, 15.0, 9.0);
    bencher.counter(ItemsCount::new(COUNT)).bench_local(|| simulation.nearest(body, from, 99.0));
}

#[divan::bench]
fn debug_lines(bencher: Bencher) {
    let (simulation, body) = pinched();
    let mut into = Vec::new();
    bencher.counter(ItemsCount::new(COUNT)).bench_local(|| {
        into.clear();
        simulation.debug_lines(body, &DebugLines::all(1.0), &mut into).expect("a body");
    });
}

/// A cut right through with 110 triangles' width, noted or not, and what it takes to hand the list over.
#[divan::bench(args = [false, true])]
fn cut(bencher: Bencher, is_noted: bool) {
    let body = || {
        let mut simulation = Simulation::new(Settings { threads: 1, ..Settings::default() }).expect("threads");
        let body = simulation.spawn(square(CELLS, hand()).with(Tearing::default())).expect("an admissible body");
        let mut changes = ChangeSet::default();
        if is_noted {
            simulation.world_mut().insert_one(body.entity(), Changes::default()).expect("a body");
            simulation.drain_changes(body, &mut changes).expect("a list");
        }
        (simulation, body, changes)
    };
    bencher.with_inputs(body).bench_local_values(|(mut simulation, body, mut changes)| {
        simulation.cut(body, &[DVec3::new(15.1, 30.0, 0.0), DVec3::new(16.3, 0.0, 0.0)]).expect("a cut");
        if is_noted {
            simulation.drain_changes(body, &mut changes).expect("a list");
        }
        (simulation, changes)
    });
}

//! A step of 64 small membranes (640 triangles each) at 1 ms: sleeping ones, and several threads.
//!
//! `cargo bench --bench many`. `all_pulled`: a hand leads every one of them. `at_rest_awake`: it leads four; the others, drawn
//! out once and left alone, may not sleep. `at_rest_asleep`: they do. Compare medians of one run.

mod fig2;

use divan::Bencher;
use fig2::{hand, square};
use rhexis::components::{Curve, Sleeping};
use rhexis::settings::Settings;
use rhexis::simulation::Simulation;

fn main() {
    divan::main();
}

const CELLS: [usize; 2] = [20, 16];
const COUNT: usize = 64;

/// Of the membranes the first `led` are led by a hand; the others are drawn out within 20 ms.
fn bench(bencher: Bencher, threads: usize, led: usize, may_sleep: bool) {
    let mut simulation = Simulation::new(Settings { threads, ..Settings::default() }).expect("threads");
    for i in 0..COUNT {
        let curve = if i < led { hand() } else { Curve::ramp(20.0, 1.0).expect("a positive duration") };
        let mut body = square(CELLS, curve);
        if may_sleep {
            body = body.with(Sleeping::default());
        }
        simulation.spawn(body).expect("an admissible body");
    }
    for _ in 0..100 {
        simulation.step(1.0).expect("a time step");
    }
    let asleep = simulation.report().bodies.iter().filter(|body| body.is_asleep).count();
    assert_eq!(asleep, if may_sleep { COUNT - led } else { 0 });
    bencher.bench_local(|| {
        simulation.step(1.0).expect("a time step");
    });
}

#[divan::bench(args = [1, 2], max_time = 4)]
fn all_pulled(bencher: Bencher, threads: usize) {
    bench(bencher, threads, COUNT, false);
}

#[divan::bench(args = [1, 2], max_time = 4)]
fn at_rest_awake(bencher: Bencher, threads: usize) {
    bench(bencher, threads, 4, false);
}

#[divan::bench(args = [1, 2], max_time = 4)]
fn at_rest_asleep(bencher: Bencher, threads: usize) {
    bench(bencher, threads, 4, true);
}

#[divan::bench(args = [1, 2], max_time = 4)]
fn all_asleep(bencher: Bencher, threads: usize) {
    bench(bencher, threads, 0, true);
}

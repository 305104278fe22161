//! A whole dynamic step of the fibrous square under a trembling hand, at 1 ms, with default settings.
//!
//! `cargo bench --bench step`. Compare medians of one run, and ratios rather than times: the machine's speed drops out.
//! A step's work follows the hand, so the spread between fastest and slowest is the scene's, not only noise.

mod fig2;

use divan::{Bencher, counter::ItemsCount};
use fig2::{LARGE, SMALL, hand, square};
use rhexis::settings::Settings;
use rhexis::simulation::Simulation;

fn main() {
    divan::main();
}

fn bench(bencher: Bencher, cells: [usize; 2], threads: usize) {
    let settings = Settings { threads, ..Settings::default() };
    let mut simulation = Simulation::new(settings).expect("threads");
    simulation.spawn(square(cells, hand())).expect("an admissible body");
    // Past the first steps from rest, whose first guess is zero.
    for _ in 0..20 {
        simulation.step(1.0).expect("a time step");
    }
    bencher.counter(ItemsCount::new(2 * cells[0] * cells[1])).bench_local(|| {
        simulation.step(1.0).expect("a time step");
    });
}

#[divan::bench(args = [1, 2], max_time = 3)]
fn triangles_1500(bencher: Bencher, threads: usize) {
    bench(bencher, SMALL, threads);
}

#[divan::bench(args = [1, 2], max_time = 6)]
fn triangles_15010(bencher: Bencher, threads: usize) {
    bench(bencher, LARGE, threads);
}

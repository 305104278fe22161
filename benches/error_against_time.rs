//! Error against time: what a tolerance buys on the fibrous square.
//!
//! `cargo bench --bench error_against_time` prints a table as CSV and writes it to `error_against_time.csv` in the target
//! directory, within some ten seconds; `-- --full` adds the meshes of 6,000 and 15,010 triangles, a minute or two. Two cases, each against the same mesh solved
//! to a residual of 1e-12, so that what is left is the solver's error alone:
//! - `static`: 10 % stretch by one Newton solve; the tolerance is Newton's (largest imbalance over largest corner force).
//! - `haptic`: 12 steps of 1 ms under a trembling hand; the tolerance is that of the linear solve in each step.
//!
//! `stress_error` is the rms of the stress differences over the rms of the stress, `position_error` \[mm\] the largest
//! distance of a vertex, `median_ms` the median over repetitions (static) or steps (haptic), on one thread.

mod fig2;

use fig2::{LARGE, LESSER, MEDIUM, SMALL, hand, square};
use rhexis::components::Curve;
use rhexis::frame::BodyFrame;
use rhexis::settings::{LinearParams, Settings};
use rhexis::simulation::Simulation;
use std::time::{Duration, Instant};

const TOLERANCES: [f64; 8] = [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8];
const TIGHT: f64 = 1e-12;
const STATIC_REPETITIONS: usize = 3;
const HAPTIC_STEPS: usize = 12;

struct Outcome {
    state: BodyFrame,
    iterations: u32,
    median: Duration,
}

fn median(mut times: Vec<Duration>) -> Duration {
    times.sort_unstable();
    times[times.len() / 2]
}

fn outcome(mut simulation: Simulation, iterations: u32, times: Vec<Duration>) -> Outcome {
    Outcome { state: simulation.frame().bodies.remove(0), iterations, median: median(times) }
}

fn settled(cells: [usize; 2], tolerance: f64) -> Outcome {
    let mut times = Vec::new();
    loop {
        let mut simulation = Simulation::new(Settings { threads: 1, ..Settings::default() }).expect("threads");
        simulation.spawn(square(cells, Curve::ramp(1.0, 3.0).expect("a ramp"))).expect("an admissible body");
        let start = Instant::now();
        let iterations = simulation.settle(1.0, tolerance).expect("an equilibrium").bodies[0].iterations;
        times.push(start.elapsed());
        if times.len() == STATIC_REPETITIONS {
            return outcome(simulation, iterations, times);
        }
    }
}

fn stepped(cells: [usize; 2], tolerance: f64) -> Outcome {
    let linear = LinearParams { tolerance, iterations: 100_000, ..LinearParams::default() };
    let mut simulation = Simulation::new(Settings { threads: 1, linear, ..Settings::default() }).expect("threads");
    simulation.spawn(square(cells, hand())).expect("an admissible body");
    let (mut times, mut iterations) = (Vec::new(), 0);
    for _ in 0..HAPTIC_STEPS {
        let start = Instant::now();
        iterations += simulation.step(1.0).expect("a time step").bodies[0].iterations;
        times.push(start.elapsed());
    }
    outcome(simulation, iterations / HAPTIC_STEPS as u32, times)
}

/// Relative rms error of stress, largest error of position \[mm\].
fn errors(state: &BodyFrame, exact: &BodyFrame) -> (f64, f64) {
    let norm_sq = |m: &glam::DMat3| m.to_cols_array().iter().map(|x| x * x).sum::<f64>();
    let difference: f64 = state.stress.iter().zip(&exact.stress).map(|(a, b)| norm_sq(&(*a - *b))).sum();
    let size: f64 = exact.stress.iter().map(norm_sq).sum();
    let distances = state.positions.iter().zip(&exact.positions).map(|(a, b)| a.distance(*b));
    ((difference / size).sqrt(), distances.fold(0.0, f64::max))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut meshes = vec![SMALL, LESSER];
    if std::env::args().any(|argument| argument == "--full") {
        meshes.extend([MEDIUM, LARGE]);
    }
    let mut table = String::from("case,triangles,tolerance,iterations,median_ms,stress_error,position_error\n");
    print!("{table}");
    for (case, run) in [("static", settled as fn([usize; 2], f64) -> Outcome), ("haptic", stepped)] {
        for &cells in &meshes {
            let exact = run(cells, TIGHT);
            for tolerance in TOLERANCES {
                let Outcome { state, iterations, median } = run(cells, tolerance);
                let (stress, position) = errors(&state, &exact.state);
                let (count, ms) = (2 * cells[0] * cells[1], median.as_secs_f64() * 1e3);
                let row = format!("{case},{count},{tolerance:e},{iterations},{ms:.3},{stress:.2e},{position:.2e}\n");
                print!("{row}");
                table += &row;
            }
        }
    }
    let folder = std::env::current_exe()?;
    // target/release/deps/error_against_time-…
    let folder = folder.ancestors().nth(3).ok_or("the executable lies in the target directory")?;
    std::fs::write(folder.join("error_against_time.csv"), table)?;
    Ok(())
}

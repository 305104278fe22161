//! Error against time: what a time step buys, by the default step and by the accurate one.
//!
//! `cargo bench --bench error_against_time_step` prints a table as CSV and writes it to `error_against_time_step.csv` in the target
//! directory, within a minute. The fibrous square of 1,500 triangles is drawn out by 3 mm within 8 ms, so fast that waves run
//! through it, and seen halfway. The reference is the same mesh by converged TR-BDF2 in steps of 5 µs, so that what is left is the
//! error of the time step and of the solver. `stress_error` is the rms of the stress differences over the rms of the stress,
//! `position_error` \[mm\] the largest distance of a vertex, `ms` the time of the run on one thread, the least of three.

mod fig2;

use fig2::{SMALL, square};
use rhexis::components::Curve;
use rhexis::frame::BodyFrame;
use rhexis::settings::{Accuracy, Advanced, Integrator, LinearParams, Precision, Settings, Tangent};
use rhexis::simulation::Simulation;
use std::f64::consts::PI;
use std::time::{Duration, Instant};

/// Simulated time \[ms\]; the pull takes twice as long.
const DURATION: f64 = 4.0;
const REPETITIONS: usize = 3;

fn run(settings: Settings, steps: u32) -> (Duration, BodyFrame) {
    let settings = Settings { threads: 1, ..settings };
    let mut simulation = Simulation::new(settings).expect("threads");
    // A path without a kink: steps see it as smooth.
    let at = |i: u32| {
        let t = f64::from(i) / 1024.0;
        (2.0 * DURATION * t, 1.5 * (1.0 - (PI * t).cos()))
    };
    let path = Curve::new((0..=1024).map(at).collect()).expect("ascending times");
    simulation.spawn(square(SMALL, path)).expect("an admissible body");
    let start = Instant::now();
    for _ in 0..steps {
        simulation.step(DURATION / f64::from(steps)).expect("a time step");
    }
    (start.elapsed(), simulation.frame().bodies.remove(0))
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
    let (default, accurate) = (Settings::default(), Settings::new(Accuracy::Accurate));
    let exact = run(Settings { advanced: Advanced { newton_iterations: 10, ..accurate.advanced }, ..accurate }, 800).1;
    let double = Settings { advanced: Advanced { precision: Precision::Double, ..accurate.advanced }, ..accurate };
    let linear = LinearParams { stress_tolerance: 1e-6, ..default.advanced.linear };
    let kinds = [
        ("default", default),
        ("default, stress to 1e-6", Settings { advanced: Advanced { linear, ..default.advanced }, ..default }),
        (
            "tr_bdf2, one rotated solve",
            Settings { advanced: Advanced { integrator: Integrator::TrBdf2, linear, ..default.advanced }, ..default },
        ),
        (
            "backward_euler, two solves",
            Settings { advanced: Advanced { integrator: Integrator::BackwardEuler, ..accurate.advanced }, ..accurate },
        ),
        ("accurate", accurate),
        (
            "accurate, exact tangent",
            Settings { advanced: Advanced { tangent: Tangent::Exact, ..accurate.advanced }, ..accurate },
        ),
        ("accurate, double precision", double),
        (
            "accurate, three solves",
            Settings { advanced: Advanced { newton_iterations: 3, ..accurate.advanced }, ..accurate },
        ),
    ];
    let mut table = String::from("kind,dt,ms,stress_error,position_error\n");
    print!("{table}");
    for (kind, settings) in kinds {
        for steps in [5, 10, 20, 40, 80, 160] {
            let mut runs: Vec<_> = (0..REPETITIONS).map(|_| run(settings, steps)).collect();
            runs.sort_by_key(|(time, _)| *time);
            let (time, state) = &runs[0];
            let (stress, position) = errors(state, &exact);
            let (dt, ms) = (DURATION / f64::from(steps), time.as_secs_f64() * 1e3);
            let row = format!("\"{kind}\",{dt},{ms:.2},{stress:.2e},{position:.2e}\n");
            print!("{row}");
            table += &row;
        }
    }
    let folder = std::env::current_exe()?;
    // target/release/deps/error_against_time_step-…
    let folder = folder.ancestors().nth(3).ok_or("the executable lies in the target directory")?;
    std::fs::write(folder.join("error_against_time_step.csv"), table)?;
    Ok(())
}

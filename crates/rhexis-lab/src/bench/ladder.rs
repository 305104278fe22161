//! The states that decide which solver is used when: a flat taut sheet, and a lens capsule half torn, its flap folded over,
//! without bending and with it.

use super::clock::median;
use super::solve::{Isolated, WAYS, Way, relative};
use super::trace::{ROUNDS, instantiate, triangle_count};
use super::{BenchError, Context, Depth, Table};
use rhexis::event::EventKind;
use rhexis::settings::LinearParams;
use std::time::Instant;

const FIGURES: [&str; 8] = [
    "iterations",
    "setup_first_ms",
    "setup_again_ms",
    "total_ms",
    "iteration_ns_per_triangle",
    "residual",
    "stress_error",
    "noise",
];

/// Tolerances at which the solves are judged.
const TOLERANCES: [f64; 3] = [1e-2, 1e-3, 1e-6];
/// The reference's: as far as every size can be solved in single precision, a round at a time.
const TIGHT: f64 = 1e-10;
const MOST_ITERATIONS: u32 = 50_000;
/// A solve is measured for so long.
const SECONDS: f64 = 0.5;

/// Cells of the flat sheet, and the depth from which on it is measured.
const SHEETS: [([usize; 2], Depth); 4] =
    [([30, 25], Depth::Quick), ([95, 79], Depth::Usual), ([300, 250], Depth::Usual), ([950, 790], Depth::Full)];
/// Triangles of the capsule before refinement, the time at which it is taken \[ms\], and the depth.
const CAPSULES: [(usize, f64, Depth); 3] =
    [(1500, 2_000.0, Depth::Quick), (5000, 16_500.0, Depth::Usual), (20_000, 16_500.0, Depth::Full)];

/// The states of the capsule, with what sets them.
const FLAPS: [(&str, &[&str]); 2] = [("capsule, torn", &[]), ("capsule, torn, bending", &["bodies.0.bending={}"])];

/// Measures iterations, time and error of every way to solve in these states.
///
/// # Errors
/// Where a state is not reached.
pub fn ladder(context: &Context) -> Result<Vec<Table>, BenchError> {
    let keys = ["state", "triangles", "solver", "tolerance"];
    let mut table = Table::new("ladder", context, &keys, &FIGURES);
    table.remark("one solve from a guess of zero, one thread; `total` has what the solver sets up anew for every solve (a Cholesky");
    table.remark("factor of the present state is at hand), `setup first` what a mesh needs on top, `setup again` the same once it is known");
    let sheets = SHEETS.iter().filter(|(_, from)| *from <= context.depth).map(|&(cells, _)| cells);
    let capsules: Vec<_> = CAPSULES.iter().filter(|(.., from)| *from <= context.depth).collect();
    context.begin(sheets.clone().count() + FLAPS.len() * capsules.len());
    for cells in sheets {
        context.now(format!("flat taut sheet of {} triangles", 2 * cells[0] * cells[1]));
        measure(&mut table, "flat, taut", &mut taut_sheet(cells)?)?;
        context.done();
    }
    // A quick run's small capsule would stand beside the large ones as if it were half torn.
    let skipped = if context.depth == Depth::Quick { 0 } else { 1 };
    for &&(triangles, time, _) in capsules.iter().skip(skipped) {
        for (state, sets) in FLAPS {
            context.now(format!("{state}: {triangles} triangles, up to {time} ms"));
            measure(&mut table, state, &mut torn_capsule(triangles, time, sets)?)?;
            context.done();
        }
    }
    Ok(vec![table])
}

/// The square of Figure 2 at 98 % of its pull of 10 %, in equilibrium; the step is one of 10 ms to 100 %. Above 200,000 triangles
/// the first step from rest: an equilibrium of those takes too long, and at rest the problem is the linear one.
pub(super) fn taut_sheet(cells: [usize; 2]) -> Result<(Isolated, usize), BenchError> {
    const LARGEST_TAUT: usize = 200_000;
    let [nx, ny] = cells;
    let sets = [format!("bodies.0.mesh.grid.nx={nx}"), format!("bodies.0.mesh.grid.ny={ny}")];
    let mut instance = instantiate("fig2", &sets)?;
    let body = instance.bodies[0];
    if 2 * nx * ny <= LARGEST_TAUT {
        instance.simulation.settle(490.0, 1e-9)?;
    }
    let mut simulation = instance.simulation;
    // The first dynamic step makes what a solve writes to.
    simulation.refresh(body)?;
    Ok((Isolated::new(simulation, body, 10.0)?, 2 * nx * ny))
}

/// The lead scene at a time, in the step after the next advance of the tear.
fn torn_capsule(triangles: usize, time: f64, sets: &[&str]) -> Result<(Isolated, usize), BenchError> {
    let mut sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
    sets.push(format!("bodies.0.mesh.cap.triangles={triangles}"));
    let mut instance = instantiate("capsulorhexis", &sets)?;
    while !instance.is_finished() {
        instance.advance()?;
        let mut events = instance.simulation.drain_events();
        let has_torn = events.any(|event| matches!(event.kind, EventKind::Advanced { .. }));
        drop(events);
        if has_torn && instance.simulation.time() >= time {
            let (body, simulation) = (instance.bodies[0], instance.simulation);
            let count = triangle_count(&simulation, body);
            return Ok((Isolated::new(simulation, body, 5.0)?, count));
        }
    }
    Err(BenchError::State(format!("the capsule of {triangles} triangles does not tear after {time} ms")))
}

fn measure(table: &mut Table, state: &str, (solve, triangles): &mut (Isolated, usize)) -> Result<(), BenchError> {
    let ways = || WAYS.iter().filter(|way| *triangles <= way.most_triangles);
    let exact = {
        // The last of the list is the most exact where it can be had.
        let way = ways().next_back().ok_or_else(|| BenchError::State("no way to solve".to_owned()))?;
        solve.solve(way, LinearParams::by_residual(TIGHT, MOST_ITERATIONS))?;
        solve.stress()
    };
    for way in ways() {
        let limited = LinearParams::by_residual(TIGHT, 0);
        solve.forget();
        let setup_first = solve.solve(way, limited)?.ms;
        let again = times(solve, way, limited, SECONDS)?;
        let setup_again = median(&again);
        for tolerance in TOLERANCES {
            let linear = LinearParams::by_residual(tolerance, MOST_ITERATIONS);
            let figures = figures(solve, way, linear, *triangles, (setup_first, setup_again), &exact)?;
            let (count, tolerance) = (triangles.to_string(), format!("{tolerance:e}"));
            table.add(&[state, &count, way.name, &tolerance], &figures);
        }
    }
    Ok(())
}

/// Times of solves \[ms\]: of two at least, and of more while `seconds` have not passed, but at most of [`ROUNDS`].
pub(super) fn times(
    solve: &mut Isolated,
    way: &Way,
    linear: LinearParams,
    seconds: f64,
) -> Result<Vec<f64>, BenchError> {
    let start = Instant::now();
    let mut times = Vec::new();
    while times.len() < 2 || times.len() < ROUNDS && start.elapsed().as_secs_f64() < seconds {
        times.push(solve.solve(way, linear)?.ms);
    }
    Ok(times)
}

/// The figures of [`FIGURES`].
fn figures(
    solve: &mut Isolated,
    way: &Way,
    linear: LinearParams,
    triangles: usize,
    (setup_first, setup_again): (f64, f64),
    exact: &[rhexis::math::Sym2],
) -> Result<[f64; 8], BenchError> {
    // The first makes the factor, where one is kept.
    let solved = solve.solve(way, linear)?;
    let error = relative(&solve.stress(), exact);
    let times = times(solve, way, linear, SECONDS)?;
    let total = median(&times);
    let (least, most) = times.iter().fold((f64::INFINITY, 0.0_f64), |(l, m), x| (l.min(*x), m.max(*x)));
    let iterations = f64::from(solved.iterations);
    let is_kept = total < setup_again;
    let iterating = if is_kept { total } else { total - setup_again };
    let per_iteration = 1e6 * iterating / iterations.max(1.0) / triangles as f64;
    Ok([iterations, setup_first, setup_again, total, per_iteration, solved.residual, error, most / least - 1.0])
}

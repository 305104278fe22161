//! The times that the engine aims at, each at its error, on a core of stated speed.

use super::clock::{median, quantile};
use super::equal_error::{at_tolerance, loosest};
use super::ladder::{taut_sheet, times};
use super::solve::WAYS;
use super::trace::{Plan, Trace};
use super::{BenchError, Context, Depth, Table, Yardsticks};
use rhexis::settings::LinearParams;

/// A case, and what it aims at.
struct Target {
    name: &'static str,
    scene: &'static str,
    sets: &'static [&'static str],
    /// The measured times: from, until, states compared until, between those \[ms\].
    window: [f64; 4],
    /// Whether runs part whatever their tolerance, so that errors are those of single steps.
    is_chaotic: bool,
    /// Stress error of the worst state.
    error: f64,
    threads: usize,
    /// The median of a step \[ms\].
    median: f64,
    /// The slowest of a thousand steps over the median; infinite for none.
    tail: f64,
    /// The slowest step in which a tip advances \[ms\]; infinite for none.
    tearing: f64,
    from: Depth,
}

const HAPTIC: Target = Target {
    name: "",
    scene: "fig2-haptic",
    sets: &["run.steps=100000"],
    window: [40.0, 1040.0, 1040.0, 25.0],
    is_chaotic: false,
    error: 1e-2,
    threads: 1,
    median: 0.2,
    tail: f64::INFINITY,
    tearing: f64::INFINITY,
    from: Depth::Usual,
};

const TARGETS: &[Target] = &[
    Target { name: "haptic 1.5k, 1 %", tail: 2.0, from: Depth::Quick, ..HAPTIC },
    Target { name: "haptic 1.5k, 0.01 %", error: 1e-4, median: 0.3, tail: 2.0, ..HAPTIC },
    // The same square with a notch, pulled on until it tears: what a step costs in which it does.
    Target {
        name: "haptic 1.5k, tearing",
        sets: &[
            "run.steps=100000",
            "bodies.0.tearing={ strength_along_fibres = 0.05, strength_ratio = 16, exponent = 0.5, radius = 1.5, may_initiate = false }",
            "bodies.0.cuts=[{ polyline = [[15, 30], [15, 27]] }]",
            "bodies.0.holds.1.curve={ hand = { to = 4, within = 400, tremor = 0.1, noise = 0.01, duration = 4000 } }",
        ],
        window: [100.0, 400.0, 400.0, 10.0],
        median: 0.2,
        tearing: 1.0,
        ..HAPTIC
    },
    Target {
        name: "haptic 6k, 1 %",
        sets: &["run.steps=100000", "bodies.0.mesh.grid.nx=60", "bodies.0.mesh.grid.ny=50"],
        window: [100.0, 400.0, 400.0, 25.0],
        median: 0.7,
        ..HAPTIC
    },
    Target { name: "haptic 15k, 1 %", sets: FIFTEEN, window: [100.0, 300.0, 300.0, 25.0], median: 2.0, ..HAPTIC },
    Target {
        name: "haptic 15k, 1 %, 2 threads",
        sets: FIFTEEN,
        window: [100.0, 300.0, 300.0, 25.0],
        threads: 2,
        median: 1.2,
        ..HAPTIC
    },
    Target { name: "dynamic 150k, 0.2 %", ..DYNAMIC },
    Target { name: "dynamic 150k, 0.2 %, 2 threads", threads: 2, median: 12.0, ..DYNAMIC },
    // The whole scene: its slowest of a thousand steps is to take 5 ms.
    Target {
        name: "capsulorhexis 5k, dt 5 ms, 1 %",
        scene: "capsulorhexis",
        sets: &["run.dt=5"],
        window: [1600.0, 4600.0, 2600.0, 50.0],
        is_chaotic: true,
        median: 2.5,
        tail: 2.0,
        tearing: 8.0,
        ..HAPTIC
    },
    // As long as a step lasts.
    Target {
        name: "capsulorhexis 20k, dt 20 ms, 1 %, 2 threads",
        scene: "capsulorhexis",
        sets: &["bodies.0.mesh.cap.triangles=20000"],
        window: [1600.0, 4600.0, 2600.0, 100.0],
        is_chaotic: true,
        threads: 2,
        median: 20.0,
        ..HAPTIC
    },
];

const FIFTEEN: &[&str] = &["run.steps=100000", "bodies.0.mesh.grid.nx=95", "bodies.0.mesh.grid.ny=79"];

const DYNAMIC: Target = Target {
    scene: "fig2",
    sets: &["bodies.0.mesh.grid.nx=300", "bodies.0.mesh.grid.ny=250"],
    window: [20.0, 80.0, 80.0, 20.0],
    error: 2e-3,
    median: 20.0,
    ..HAPTIC
};

/// Solve alone of the linear problem with 1.5 million triangles to a residual of 1e-3 \[ms\], and its growth per triangle from
/// 150,000.
const SOLVE: (f64, f64) = (250.0, 1.1);

const LINEAR_NAME: &str = "static linear 1.5M, solve only";

/// A case is measured for so long: a shared core is half as fast for seconds at a time, and yardsticks are of it at its best.
const SECONDS: f64 = 30.0;

/// And a way to solve so long, of which there are several.
const SOLVE_SECONDS: f64 = 5.0;

const FIGURES: [&str; 11] = [
    "raw_median_ms",
    "scaled_median_ms",
    "target_median_ms",
    "scaled_p999_ms",
    "tail",
    "scaled_tearing_ms",
    "target_tearing_ms",
    "tolerance",
    "stress_error",
    "iterations",
    "noise",
];

/// Runs the cases whose names have one of `names` in them, or all, each at the loosest tolerance that reaches its error.
///
/// # Errors
/// For a name that no case has in it, and where a run fails.
pub fn targets(context: &Context, names: &[String]) -> Result<Vec<Table>, BenchError> {
    let mut table = Table::new("targets", context, &["case", "triangles"], &FIGURES);
    table.columns.push("verdict".to_owned());
    let Yardsticks { fma_gflops, triad_gbs } = Yardsticks::REFERENCE;
    table.remark(format!(
        "scaled: times on a core with {fma_gflops} GFLOP/s and {triad_gbs} GB/s; this one has {:.0} and {:.1}. Up to 20,000 triangles by arithmetic, above by memory",
        context.yardsticks.fma_gflops, context.yardsticks.triad_gbs
    ));
    table.remark("whole steps, the criterion included, at the loosest tolerance whose worst state has the stress error of the case; against the same");
    table.remark("run solved tightly. Processor time of the stepping thread; on two threads time on the wall");
    let is_meant = |name: &str| names.is_empty() || names.iter().any(|part| name.contains(part.as_str()));
    if let Some(part) = names.iter().find(|part| !all_names().any(|name| name.contains(part.as_str()))) {
        let known: Vec<&str> = all_names().collect();
        return Err(BenchError::Unknown(format!(
            "no target has `{part}` in its name\n  help: they are {}",
            known.join("; ")
        )));
    }
    let targets: Vec<&Target> = TARGETS.iter().filter(|t| t.from <= context.depth && is_meant(t.name)).collect();
    context.begin(targets.len() + 1);
    for target in targets {
        context.now(target.name);
        whole_step(context, target, &mut table)?;
        context.done();
    }
    if context.depth == Depth::Full && is_meant(LINEAR_NAME) {
        context.now(LINEAR_NAME);
        linear_solve(context, &mut table)?;
    }
    context.done();
    Ok(vec![table])
}

fn all_names() -> impl Iterator<Item = &'static str> {
    TARGETS.iter().map(|target| target.name).chain([LINEAR_NAME])
}

fn add(table: &mut Table, keys: &[&str], figures: &[f64], is_met: Option<bool>) {
    table.add(keys, figures);
    let verdict = match is_met {
        Some(true) => "met",
        Some(false) => "NOT MET",
        None => "",
    };
    table.rows.last_mut().into_iter().for_each(|row| row.push(verdict.to_owned()));
}

fn whole_step(context: &Context, target: &Target, table: &mut Table) -> Result<(), BenchError> {
    let sets = target.sets.iter().map(|&set| set.to_owned()).collect();
    let [from, mut until, mut compared_until, every] = target.window;
    if context.depth == Depth::Quick {
        (until, compared_until) = (from + 4.0 * every, from + 4.0 * every);
    }
    let (scene, is_chaotic) = (target.scene, target.is_chaotic);
    let mut plan = Plan { scene, sets, solver: Vec::new(), from, until, compared_until, every, is_chaotic };
    // A residual so far below the error leaves none to speak of in the stress.
    let tight = at_tolerance(&Plan { until: compared_until, ..plan.clone() }, 1e-4 * target.error);
    let exact = Trace::record(&tight, 0.0)?;
    plan.sets.push(format!("run.threads={}", target.threads));
    let seconds = if context.depth == Depth::Quick { 0.0 } else { SECONDS };
    let reached = loosest(&plan, &exact, target.error, seconds)?;
    let trace = &reached.trace;
    let scale = context.yardsticks.over(&Yardsticks::REFERENCE, trace.triangle_count);
    let middle = median(&trace.step_ms);
    let slowest = quantile(&trace.step_ms, 0.999);
    let of_tears = trace.step_ms.iter().zip(&trace.has_torn).filter(|(_, has_torn)| **has_torn).map(|(ms, _)| *ms);
    let tearing = of_tears.fold(f64::NAN, f64::max);
    let is_met = scale * middle <= target.median
        && slowest / middle <= target.tail
        && !(scale * tearing > target.tearing)
        && reached.errors.stress <= target.error;
    let wanted_tearing = if target.tearing.is_finite() { target.tearing } else { f64::NAN };
    let figures = [
        middle,
        scale * middle,
        target.median,
        scale * slowest,
        slowest / middle,
        scale * tearing,
        wanted_tearing,
        reached.tolerance,
        reached.errors.stress,
        trace.iterations,
        trace.noise,
    ];
    add(table, &[target.name, &trace.triangle_count.to_string()], &figures, Some(is_met));
    Ok(())
}

/// The linear problem at rest, from a first guess of zero: the fastest way on each size, with and without what it takes to set it up.
fn linear_solve(context: &Context, table: &mut Table) -> Result<(), BenchError> {
    let linear = LinearParams::by_residual(1e-3, 50_000);
    let mut per_triangle = Vec::new();
    for (cells, wanted) in [([300, 250], f64::NAN), ([950, 790], SOLVE.0)] {
        let (mut solve, triangles) = taut_sheet(cells)?;
        let mut best = (f64::INFINITY, f64::NAN, f64::NAN, f64::NAN, "");
        for way in WAYS.iter().rev().filter(|way| triangles <= way.most_triangles) {
            solve.forget();
            let with_setup = solve.solve(way, linear)?.ms;
            let solved = solve.solve(way, linear)?;
            // The plainest come last: one so slow is not the fastest, whatever the machine does beside it.
            if solved.ms > 3.0 * best.0 {
                continue;
            }
            let least = times(&mut solve, way, linear, SOLVE_SECONDS)?.into_iter().fold(solved.ms, f64::min);
            if least < best.0 {
                best = (least, with_setup, f64::from(solved.iterations), solved.residual, way.name);
            }
        }
        let (ms, with_setup, iterations, residual, way) = best;
        let scale = context.yardsticks.over(&Yardsticks::REFERENCE, triangles);
        per_triangle.push(ms / triangles as f64);
        let nan = f64::NAN;
        let figures = [ms, scale * ms, wanted, nan, nan, nan, nan, residual, nan, iterations, nan];
        let (name, triangles) = (format!("static linear, solve only: {way}"), triangles.to_string());
        add(table, &[&name, &triangles], &figures, wanted.is_finite().then_some(scale * ms <= wanted));
        let figures = [with_setup, scale * with_setup, nan, nan, nan, nan, nan, residual, nan, iterations, nan];
        add(table, &[&format!("static linear, with setup: {way}"), &triangles], &figures, None);
    }
    let growth = per_triangle[1] / per_triangle[0];
    table.remark(format!(
        "solve only: time per triangle grows {growth:.2}× from 150,000 to 1.5 million; {} is wanted",
        SOLVE.1
    ));
    Ok(())
}

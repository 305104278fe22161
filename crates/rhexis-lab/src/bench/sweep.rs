//! The runs behind the work–precision tables.

use super::clock::{median, quantile};
use super::errors::Errors;
use super::front::{Point, better};
use super::plot::{Chart, Series, draw};
use super::trace::{Plan, Rounds, Trace, in_turns};
use super::work_precision::{Case, INTEGRATORS, Mesh, Setting};
use super::{BenchError, Context, Depth, Table};

const FIGURES: [&str; 12] = [
    "median_ms",
    "p999_ms",
    "worst_ms",
    "process_ms",
    "cost_ms_per_ms",
    "iterations",
    "noise",
    "stress_error",
    "position_error_mm",
    "force_error",
    "path_error_mm",
    "compared",
];

/// The tables of a case.
pub(super) fn sweep(context: &Context, case: &Case) -> Result<[Table; 2], BenchError> {
    let solvers = solvers(context, case)?;
    let discretisation = discretisation(context, case)?;
    Ok([solvers, discretisation])
}

/// How long a plan is repeated for its times \[s\].
fn seconds(depth: Depth) -> f64 {
    match depth {
        Depth::Quick => 0.0,
        Depth::Usual => 3.0,
        Depth::Full => 10.0,
    }
}

fn plan(context: &Context, case: &Case, mesh: &[&str], dt: f64, more: &[String]) -> Plan {
    let mut sets: Vec<String> = case.sets.iter().chain(mesh).map(|&set| set.to_owned()).collect();
    sets.push(format!("run.dt={dt}"));
    let (from, until, every) = (case.window.from, case.until(context.depth), case.window.every);
    // The tolerance of static solves belongs to the run, not to the solver.
    if case.is_static() {
        sets.extend_from_slice(more);
    }
    let (scene, solver, is_chaotic) = (case.scene, more.to_vec(), case.is_chaotic);
    Plan { scene, sets, solver, from, until, compared_until: until, every, is_chaotic }
}

fn with_tolerance(case: &Case, tolerance: f64, sets: &[&str]) -> Vec<String> {
    let mut sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
    sets.push(format!("{}={tolerance:e}", case.tolerance));
    if !case.is_static() {
        sets.push("run.advanced.linear_iterations=100000".to_owned());
        // But for the scene's own settings the error of the stress decides alone.
        if tolerance != case.default_tolerance {
            sets.push("run.advanced.linear_tolerance=1".to_owned());
        }
    }
    sets
}

fn figures(trace: &Trace, dt: f64, errors: &Errors) -> [f64; 12] {
    let times = &trace.step_ms;
    let middle = median(times);
    let Errors { stress, position, force, path, compared } = *errors;
    [
        middle,
        quantile(times, 0.999),
        quantile(times, 1.0),
        median(&trace.process_ms),
        middle / dt,
        trace.iterations,
        trace.noise,
        stress,
        position,
        force,
        path,
        compared,
    ]
}

fn solvers(context: &Context, case: &Case) -> Result<Table, BenchError> {
    let keys = ["case", "triangles", "setting", "tolerance", "is_default"];
    let mut table = Table::new(format!("work-precision-{}-solvers", case.name), context, &keys, &FIGURES);
    table.remark(format!(
        "errors against the same run on the same mesh at the same step, solved to {:e}; a step is {} ms; stress is that at interior vertices",
        case.tight, case.time_steps[0]
    ));
    if case.is_chaotic {
        table.remark("slack tissue folds one way or the other whatever the tolerance: stress and positions are those of single steps, against the");
        table.remark(
            "exact solution of each from the same state; forces and paths those of whole runs, which part in any case",
        );
    }
    let meshes: Vec<&Mesh> = case.meshes.iter().filter(|mesh| mesh.from <= context.depth).collect();
    let settings: Vec<&Setting> = case.settings.iter().filter(|setting| setting.from <= context.depth).collect();
    context.begin(meshes.len() * (1 + 2 * settings.len() * case.tolerances.len()));
    let dt = case.time_steps[0];
    for mesh in meshes {
        context.now(format!("{}: reference", case.name));
        // With a factor of its own the double path goes deepest, whatever is the default.
        let tight = with_tolerance(case, case.tight, &[]);
        let exact = Trace::record(&plan(context, case, mesh.sets, dt, &tight), 0.0)?;
        context.done();
        let triangles = exact.triangle_count.to_string();
        let (mut runs, mut rounds) = (Vec::new(), Vec::new());
        for (place, setting) in settings.iter().enumerate() {
            for &tolerance in case.tolerances {
                context.now(format!("{}: {triangles} triangles, {}, {tolerance:e}", case.name, setting.name));
                let sets = with_tolerance(case, tolerance, setting.sets);
                match Rounds::begin(plan(context, case, mesh.sets, dt, &sets)) {
                    Ok(first) => {
                        runs.push((place, tolerance));
                        rounds.push(first);
                    }
                    // One setting that fails is a result too.
                    Err(error) => {
                        table.remark(format!("{triangles} triangles, {}, {tolerance:e}: {error}", setting.name));
                        context.done();
                    }
                }
                context.done();
            }
        }
        context.now(format!("{}: {triangles} triangles, all in turns", case.name));
        in_turns(&mut rounds, seconds(context.depth), || context.done())?;
        let (mut points, mut names, mut default) = (Vec::new(), Vec::new(), None);
        let mut series: Vec<Series> =
            settings.iter().map(|setting| Series { name: setting.name.to_owned(), points: Vec::new() }).collect();
        for ((place, tolerance), Rounds { trace, .. }) in runs.into_iter().zip(&rounds) {
            let setting = settings[place].name;
            let errors = Errors::against(trace, &exact);
            let figures = figures(trace, dt, &errors);
            let is_default = place == 0 && tolerance == case.default_tolerance;
            if is_default {
                default = Some(points.len());
            }
            let point = Point::new(figures[0], errors.stress);
            points.push(point);
            series[place].points.push(point);
            names.push(format!("{setting} at {tolerance:e}"));
            let (tolerance, is_default) = (format!("{tolerance:e}"), is_default.to_string());
            table.add(&[case.name, &triangles, setting, &tolerance, &is_default], &figures);
        }
        table.remark(verdict(&format!("{triangles} triangles"), default, &points, &names));
        let chart = Chart {
            title: format!("{}, {triangles} triangles: error of the solver", case.name),
            axes: ["processor time of a step, median [ms]", "stress error against the tight solve [1]"],
            series,
            defaults: default.map(|i| points[i]).into_iter().collect(),
        };
        draw(&context.directory, &format!("{}-{triangles}", table.name), &chart)?;
    }
    Ok(table)
}

/// Whether the default is on the front.
fn verdict(what: &str, default: Option<usize>, points: &[Point], names: &[String]) -> String {
    let Some(default) = default else { return format!("{what}: the default was not measured") };
    match better(points, default) {
        _ if !points[default].is_known() => format!("{what}: the default has no known error"),
        None => format!("{what}: the default is on the Pareto front"),
        Some(i) => format!(
            "{what}: the default is off the Pareto front: {} takes {:.0} % of its time at {:.1e} instead of {:.1e}",
            names[i],
            100.0 * points[i].ms / points[default].ms,
            points[i].error,
            points[default].error
        ),
    }
}

fn discretisation(context: &Context, case: &Case) -> Result<Table, BenchError> {
    let keys = ["case", "triangles", "integrator", "time_step", "is_default"];
    let mut table = Table::new(format!("work-precision-{}-discretisation", case.name), context, &keys, &FIGURES);
    let shortest = case.time_steps.iter().copied().fold(f64::INFINITY, f64::min);
    let integrators: Vec<&Setting> =
        INTEGRATORS.iter().filter(|i| i.from <= context.depth).take(if case.is_static() { 1 } else { 2 }).collect();
    let meshes: Vec<&Mesh> = case.meshes.iter().filter(|mesh| mesh.from <= context.depth).collect();
    let time_steps = if context.depth == Depth::Quick { &case.time_steps[..1] } else { case.time_steps };
    context.begin(1 + 2 * meshes.len() * integrators.len() * time_steps.len());
    context.now(format!("{}: finest reference", case.name));
    // The quick run shows that it works; its reference is no finer than need be.
    let finest = match context.depth {
        Depth::Quick => case.meshes.last().map_or(case.finest, |mesh| mesh.sets),
        _ => case.finest,
    };
    // A step of the reference is solved as far as its mesh deserves: a thousandth of what the finest measured mesh leaves.
    let tight = with_tolerance(case, case.tight.max(1e-6), &[]);
    let exact = Trace::record(&plan(context, case, finest, shortest, &tight), 0.0)?;
    context.done();
    // Where there is a tear, its path is what counts.
    let is_by_path = !exact.paths.is_empty();
    table.remark(format!(
        "errors against {} triangles at {shortest} ms, at the vertices that both meshes have",
        exact.triangle_count
    ));
    let (mut runs, mut rounds) = (Vec::new(), Vec::new());
    for (i, integrator) in integrators.iter().enumerate() {
        for &dt in time_steps {
            for (m, mesh) in meshes.iter().enumerate() {
                let sets = with_tolerance(case, case.default_tolerance, integrator.sets);
                context.now(format!("{}: mesh {m}, {}, {dt} ms", case.name, integrator.name));
                rounds.push(Rounds::begin(plan(context, case, mesh.sets, dt, &sets))?);
                runs.push((i, dt, m));
                context.done();
            }
        }
    }
    context.now(format!("{}: all meshes and time steps in turns", case.name));
    in_turns(&mut rounds, seconds(context.depth), || context.done())?;
    let (mut points, mut series, mut names, mut default) = (Vec::new(), Vec::<Series>::new(), Vec::new(), None);
    for ((i, dt, m), Rounds { trace, .. }) in runs.into_iter().zip(&rounds) {
        let integrator = integrators[i].name;
        if m == 0 {
            let name = if case.is_static() { "meshes".to_owned() } else { format!("{integrator}, {dt} ms") };
            series.push(Series { name, points: Vec::new() });
        }
        // Between meshes and time steps there is only the run as a whole.
        let errors = Errors::of_states(trace, &exact);
        let figures = figures(trace, dt, &errors);
        let is_default = i == 0 && dt == case.time_steps[0] && m == 0;
        if is_default {
            default = Some(points.len());
        }
        let triangles = trace.triangle_count.to_string();
        let error = if is_by_path { errors.path } else { errors.stress };
        let point = Point::new(if case.is_static() { figures[0] } else { figures[4] }, error);
        points.push(point);
        if let Some(last) = series.last_mut() {
            last.points.push(point);
        }
        names.push(format!("{triangles} triangles at {dt} ms, {integrator},"));
        table.add(&[case.name, &triangles, integrator, &dt.to_string(), &is_default.to_string()], &figures);
    }
    table.remark(verdict("mesh and time step", default, &points, &names));
    let chart = Chart {
        title: format!("{}: error of mesh and time step", case.name),
        axes: [
            if case.is_static() {
                "processor time of the solve [ms]"
            } else {
                "processor time over simulated time [ms/ms]"
            },
            if is_by_path {
                "distance of the tear's path from the finest [mm]"
            } else {
                "stress error against the finest mesh [1]"
            },
        ],
        series,
        defaults: default.map(|i| points[i]).into_iter().collect(),
    };
    draw(&context.directory, &table.name, &chart)?;
    Ok(table)
}

//! Ablation: every preconditioner, every remedy of the energy guard and every speed path left out by itself.
//!
//! A row is one run with one change. Its work, time and error stand beside its outcome: a remedy may cost nothing and decide how a scene
//! ends. Counts are the same on every machine; times are ratios to the run with everything on, measured in turns.

mod cases;
mod game;
mod rows;
mod run;

use super::errors::Errors;
use super::trace::Trace;
use super::{BenchError, Context, Depth, Table};
use cases::{CASES, Case};
use rhexis_scene::nearest;
use rows::{ROWS, Row};
use run::{Measured, Start};

const FIGURES: [&str; 21] = [
    "iterations",
    "solves",
    "work",
    "time_ratio",
    "process_ratio",
    "undone",
    "corrected",
    "relaxed",
    "limited",
    "failed",
    "stress_error",
    "position_error_mm",
    "force_error",
    "path_error_mm",
    "steps",
    "advances",
    "grasps",
    "slips",
    "pieces",
    "opening_mm",
    "force_mn",
];

/// Rounds of runs in turns, of which the least time counts.
fn rounds(depth: Depth) -> usize {
    match depth {
        Depth::Quick => 1,
        Depth::Usual => 2,
        Depth::Full => 5,
    }
}

/// Measures the rows whose names contain one of `only`, or all, on these scenes, or all.
///
/// # Errors
/// For an unknown scene or row, and where a scene cannot be run.
pub fn ablation(context: &Context, scenes: &[String], only: &[String]) -> Result<Vec<Table>, BenchError> {
    let cases = scenes.iter().map(|name| find(name)).collect::<Result<Vec<&Case>, _>>()?;
    let cases = if cases.is_empty() { CASES.iter().collect() } else { cases };
    let is_chosen = |row: &&Row| only.is_empty() || only.iter().any(|part| row.name.contains(part.as_str()));
    let chosen: Vec<&Row> = ROWS[1..].iter().filter(is_chosen).collect();
    if chosen.is_empty() {
        let names: Vec<&str> = ROWS.iter().map(|row| row.name).collect();
        let what = format!("no row has `{}` in its name\n  help: the rows are {}", only.join("`, `"), names.join(", "));
        return Err(BenchError::Unknown(what));
    }
    let mut tables = Vec::new();
    for case in cases {
        let table = measure(context, case, &chosen)?;
        // The next scene may take minutes.
        table.write(&context.directory)?;
        tables.push(table);
    }
    Ok(tables)
}

fn find(name: &str) -> Result<&'static Case, BenchError> {
    CASES.iter().find(|case| case.name == name).ok_or_else(|| {
        let names: Vec<&str> = CASES.iter().map(|case| case.name).collect();
        let near =
            nearest(name, names.iter().copied()).map_or(String::new(), |near| format!("did you mean `{near}`? "));
        let what = format!("no ablation of a scene `{name}`\n  help: {near}the scenes are {}", names.join(", "));
        BenchError::Unknown(what)
    })
}

fn measure(context: &Context, case: &Case, chosen: &[&Row]) -> Result<Table, BenchError> {
    let rounds = rounds(context.depth);
    context.begin(2 + rounds * (1 + chosen.len()));
    context.now(format!("{}: start", case.name));
    let start = Start::of(case, context.depth)?;
    context.done();
    // A row that a scene's settings leave out already is not run again.
    let (run, same): (Vec<&Row>, Vec<&Row>) = chosen.iter().partition(|row| start.is_changed_by(row));
    let run: Vec<&Row> = ROWS[..1].iter().chain(run).collect();
    context.now(format!("{}: reference", case.name));
    let exact = start.reference()?.trace;
    context.done();
    let mut all: Vec<Vec<Measured>> = run.iter().map(|_| Vec::new()).collect();
    for round in 0..rounds {
        for (row, measured) in run.iter().zip(&mut all) {
            context.now(format!("{}: {}, round {} of {rounds}", case.name, row.name, round + 1));
            measured.push(start.run(row, round == 0)?);
            context.done();
        }
    }
    let mut table = Table::new(format!("ablation-{}", case.name), context, &["scene", "kind", "row"], &FIGURES);
    let least = |measured: &[Measured], of: fn(&Measured) -> f64| measured.iter().map(of).fold(f64::INFINITY, f64::min);
    let base = all.first().map_or(&[][..], Vec::as_slice);
    let of_base = [least(base, |m| m.ms), least(base, |m| m.process_ms)];
    for (row, measured) in run.iter().zip(&all) {
        let Some(first) = measured.first() else { continue };
        let ratios = [least(measured, |m| m.ms) / of_base[0], least(measured, |m| m.process_ms) / of_base[1]];
        table.add(&[case.name, row.kind, row.name], &figures(first, ratios, &exact));
    }
    let slowest = base.iter().map(|measured| measured.ms).fold(0.0, f64::max);
    table.remark(format!(
        "{}; from {} to {} ms, every row from one state; one thread; {rounds} rounds in turns, the least of each; everything on took {:.0} ms, \
         its slowest round {:.0} % more",
        case.about,
        start.from(),
        start.until(),
        of_base[0],
        100.0 * (slowest / of_base[0] - 1.0)
    ));
    table.remark(if case.is_chaotic {
        "errors of stress and positions are those of single steps against their exact solution, forces and paths those against the run solved tightly"
    } else {
        "errors against the same run solved tightly"
    });
    if !same.is_empty() {
        let names: Vec<&str> = same.iter().map(|row| row.name).collect();
        table.remark(format!("not in use here: {}", names.join(", ")));
    }
    Ok(table)
}

fn figures(measured: &Measured, [time, process]: [f64; 2], exact: &Trace) -> [f64; 21] {
    let Errors { stress, position, force, path, .. } = Errors::against(&measured.trace, exact);
    let run::Counts { iterations, solves, work, undone, corrected, relaxed, limited, failed, .. } = measured.counts;
    let run::Counts { steps, advances, grasps, slips, pieces, .. } = measured.counts;
    let counted = |count: u64| count as f64;
    [
        counted(iterations),
        counted(solves),
        counted(work),
        time,
        process,
        counted(undone),
        counted(corrected),
        counted(relaxed),
        counted(limited),
        counted(failed),
        stress,
        position,
        force,
        path,
        counted(steps),
        counted(advances),
        counted(grasps),
        counted(slips),
        counted(pieces),
        measured.opening,
        measured.force,
    ]
}

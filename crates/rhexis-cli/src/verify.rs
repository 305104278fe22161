//! `rhexis verify`.

use super::interrupt::Interrupt;
use super::{Stop, VerifyArgs, outputs, say::complain, say::say};
use indicatif::ProgressBar;
use rhexis_lab::verify::{Artifacts, CASES, Case, Depth, Group, Row};
use rhexis_scene::nearest;
use serde::Serialize;
use std::time::Duration;

#[derive(Serialize)]
struct Output {
    passed: bool,
    rows: Vec<Line>,
    errors: Vec<Failure>,
}

/// One comparison as it is printed.
#[derive(Serialize)]
struct Line {
    case: &'static str,
    what: String,
    error: f64,
    /// Absent for a figure that is only reported.
    tolerance: Option<f64>,
    unit: &'static str,
    verdict: &'static str,
}

#[derive(Serialize)]
struct Failure {
    case: &'static str,
    what: String,
}

/// Runs the cases and prints case, error, tolerance and verdict.
pub(super) fn verify(args: &VerifyArgs) -> Result<(), Stop> {
    let cases = chosen(args.case.as_deref())?;
    let mut output = Output { passed: true, rows: Vec::new(), errors: Vec::new() };
    let directory = outputs::directory(args.out.as_deref(), "out/verify")?;
    let depth = if args.quick { Depth::Quick } else { Depth::Full };
    let artifacts = Artifacts { directory: Some(directory), depth };
    let spinner = ProgressBar::new_spinner();
    spinner.enable_steady_tick(Duration::from_millis(200));
    let interrupt = Interrupt::watch()?;
    for case in cases {
        if interrupt.is_asked() {
            break;
        }
        spinner.set_message(format!("{}: {}", case.name, case.about));
        match (case.run)(&artifacts) {
            Ok(rows) => {
                for row in rows {
                    let line = line(row);
                    output.passed &= line.verdict != "FAILED";
                    if !args.json {
                        spinner.suspend(|| say(&printed(&line)))?;
                    }
                    output.rows.push(line);
                }
            }
            Err(error) => {
                output.passed = false;
                if !args.json {
                    spinner.suspend(|| complain(&format!("error: {}: {error}", case.name)));
                }
                output.errors.push(Failure { case: case.name, what: error.to_string() });
            }
        }
    }
    spinner.finish_and_clear();
    // Cases are missing then.
    output.passed &= !interrupt.is_asked();
    if args.json {
        say(&serde_json::to_string_pretty(&output).map_err(|error| Stop::Failed(error.to_string()))?)?;
    } else {
        let failed = output.rows.iter().filter(|line| line.verdict == "FAILED").count() + output.errors.len();
        say(&format!("{} comparisons, {failed} failed", output.rows.len()))?;
    }
    match (output.passed, interrupt.is_asked()) {
        (_, true) => Err(Stop::Interrupted),
        (true, _) => Ok(()),
        (false, _) => Err(Stop::Silent),
    }
}

fn chosen(name: Option<&str>) -> Result<Vec<&'static Case>, Stop> {
    let Some(name) = name else { return Ok(CASES.iter().collect()) };
    let chosen: Vec<&Case> = CASES.iter().filter(|case| case.name == name || case.group.name() == name).collect();
    if !chosen.is_empty() {
        return Ok(chosen);
    }
    let names: Vec<&str> = CASES
        .iter()
        .map(|case| case.name)
        .chain(
            [Group::Mechanics, Group::Time, Group::Bed, Group::Compartments, Group::Contact, Group::Tear]
                .map(Group::name),
        )
        .collect();
    let suggestion =
        nearest(name, names.iter().copied()).map_or(String::new(), |near| format!("did you mean `{near}`? "));
    Err(Stop::Usage(format!(
        "no verification case `{name}`\n  help: {suggestion}the cases and groups are {}",
        names.join(", ")
    )))
}

fn line(row: Row) -> Line {
    let verdict = match (row.is_informative(), row.passes()) {
        (true, _) => "noted",
        (false, true) => "ok",
        (false, false) => "FAILED",
    };
    let tolerance = (!row.is_informative()).then_some(row.tolerance);
    Line { case: row.case, what: row.what, error: row.error, tolerance, unit: row.unit, verdict }
}

fn printed(line: &Line) -> String {
    let unit = if line.unit == "1" { "" } else { line.unit };
    let tolerance = line.tolerance.map_or("-".to_owned(), |tolerance| format!("{tolerance:.1e}"));
    let Line { case, what, error, verdict, .. } = line;
    format!("{verdict:6} {case:14} {error:9.2e} of {tolerance:>8} {unit:4} {what}")
}

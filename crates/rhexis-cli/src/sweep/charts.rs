//! Plots of the table: each measure that varies over each parameter that is a number, coloured by how the cases ended.

use super::case::Case;
use super::plan::Plan;
use super::record::Record;
use super::table::cell;
use super::values::number;
use crate::Stop;
use crate::plot::{Curve, Panel, Style, files, label};
use std::collections::BTreeMap;
use std::path::Path;

/// Measures that are drawn, where they vary.
const DRAWN: [&str; 11] = [
    "diameter_mm",
    "circularity",
    "decentration_mm",
    "completion_deg",
    "grasps",
    "force_rms_n",
    "force_peak_n",
    "tear_length_mm",
    "torn_area_mm2",
    "largest_radius_mm",
    "steps",
];

/// The directory of a sweep's plots.
pub(super) const FOLDER: &str = "plots";

/// Draws the plots and says how many there are.
///
/// # Errors
/// Where a file cannot be written.
pub(super) fn draw(
    folder: &Path,
    plan: &Plan,
    cases: &[Case],
    records: &BTreeMap<String, Record>,
) -> Result<usize, Stop> {
    let done: Vec<(&Case, &Record)> = cases.iter().filter_map(|case| Some((case, records.get(&case.key)?))).collect();
    let mut panels = Vec::new();
    for (place, parameter) in plan.parameters().iter().enumerate() {
        let at = |case: &Case| number(&cell(&case.values[place])).unwrap_or(f64::NAN);
        let x: Vec<f64> = done.iter().map(|(case, _)| at(case)).collect();
        if !varies(&x) {
            continue;
        }
        panels.extend(measures(&done).iter().filter_map(|measure| panel(&parameter.name, &x, measure, &done)));
    }
    let folder = folder.join(FOLDER);
    if !panels.is_empty() {
        std::fs::create_dir_all(&folder).map_err(|error| Stop::Failed(format!("{}: {error}", folder.display())))?;
    }
    panels.iter().try_for_each(|panel| files(&folder, panel)).map_err(Stop::Failed)?;
    Ok(panels.len())
}

/// What is drawn of these cases: of the usual measures those that are there, and the peak of every hold.
fn measures(done: &[(&Case, &Record)]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for (name, _) in done.iter().flat_map(|(_, record)| &record.measures) {
        let plain = name.rsplit('/').next().unwrap_or(name);
        if (DRAWN.contains(&plain) || plain.ends_with("_peak_n")) && !names.contains(name) {
            names.push(name.clone());
        }
    }
    names
}

/// One plot; none of a measure that is the same in all cases.
fn panel(parameter: &str, x: &[f64], measure: &str, done: &[(&Case, &Record)]) -> Option<Panel> {
    let value = |record: &Record| record.measure(measure).and_then(|value| value.as_f64()).unwrap_or(f64::NAN);
    let y: Vec<f64> = done.iter().map(|(_, record)| value(record)).collect();
    if !varies(&y) {
        return None;
    }
    let mut outcomes: Vec<String> = done.iter().map(|(_, record)| outcome(record)).collect();
    let all = outcomes.clone();
    outcomes.sort();
    outcomes.dedup();
    let curve = |name: String| {
        let only: Vec<f64> = y.iter().zip(&all).map(|(y, own)| if *own == name { *y } else { f64::NAN }).collect();
        Curve::new(name, x, &only)
    };
    Some(Panel {
        name: file_name(&format!("{measure}-over-{parameter}")),
        axes: [parameter.to_owned(), label(measure)],
        curves: outcomes.into_iter().map(curve).collect(),
        style: Style::Points,
    })
}

fn outcome(record: &Record) -> String {
    let outcome = record.measure("outcome").and_then(|outcome| outcome.as_str());
    outcome.unwrap_or(&record.end).replace('_', " ")
}

fn varies(values: &[f64]) -> bool {
    let mut finite = values.iter().filter(|value| value.is_finite());
    let first = finite.next();
    finite.any(|value| Some(value) != first)
}

/// A name that is one file on every system.
fn file_name(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() || c == '_' { c } else { '-' }).take(120).collect()
}

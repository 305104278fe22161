//! Measures of a run for a row of the table, from `report.json` and `series.csv`.

use crate::plot::Table;
use serde_json::{Value, json};
use std::path::Path;

/// Figures of a tear drawn by forceps.
const COURSE: [&str; 20] = [
    "outcome",
    "completion_deg",
    "diameter_mm",
    "diameter_as_it_lies_mm",
    "circularity",
    "circularity_as_it_lies",
    "decentration_mm",
    "largest_radius_mm",
    "grasps",
    "time_ms",
    "force_rms_n",
    "force_peak_n",
    "force_mean_n",
    "force_time_above_mn_s",
    "tool_path_mm",
    "tremor_mm",
    "zonule_load_n",
    "spikes",
    "optic_covered",
    "optic_overlap_mm",
];

/// Figures of a tear, by their names in the report and in the table.
const TEAR: [(&str, &str); 9] = [
    ("/length_mm", "tear_length_mm"),
    ("/account/torn_area_mm2", "torn_area_mm2"),
    ("/account/overshoot_median", "overshoot_median"),
    ("/starts", "starts"),
    ("/advances", "advances"),
    ("/ambiguous", "ambiguous"),
    ("/ended", "tips_ended"),
    ("/fragments_freed", "fragments_freed"),
    ("/refusals", "refusals"),
];

const BODY: [&str; 4] = ["triangles", "elastic_mj", "kinetic_mj", "relative_imbalance"];

const SOLVER: [(&str, &str); 5] = [
    ("/solver/iterations", "iterations"),
    ("/solver/rolled_back", "retries"),
    ("/solver/failed/steps", "failed_steps"),
    ("/solver/unsolved/steps", "unsolved_steps"),
    ("/solver/unconverged/steps", "unconverged_steps"),
];

/// The measures in the order of the table's columns. Of several bodies each has its name before it.
pub(super) fn measures(run: &Path, report: &Value) -> Vec<(String, Value)> {
    let mut found: Vec<(String, Value)> = Vec::new();
    for name in ["steps", "simulated_ms"] {
        found.push((name.to_owned(), report[name].clone()));
    }
    let bodies = report["bodies"].as_array().map_or(&[][..], Vec::as_slice);
    for body in bodies {
        let prefix = match bodies {
            [_] => String::new(),
            _ => format!("{}/", body["name"].as_str().unwrap_or_default()),
        };
        of_body(body, &prefix, &mut found);
    }
    peaks(run, bodies, &mut found);
    for (pointer, name) in SOLVER {
        found.push((name.to_owned(), report.pointer(pointer).cloned().unwrap_or_default()));
    }
    found.push(("notes".to_owned(), json!(report["caveats"].as_array().map_or(0, Vec::len))));
    found.push(("hash".to_owned(), report["hash"].clone()));
    found
}

fn of_body(body: &Value, prefix: &str, found: &mut Vec<(String, Value)>) {
    let mut put = |name: &str, value: &Value| found.push((format!("{prefix}{name}"), value.clone()));
    if body["course"].is_object() {
        COURSE.iter().for_each(|name| put(name, &body["course"][name]));
        if body["course"]["score"].is_object() {
            put("score", &body["course"]["score"]["total"]);
        }
    }
    if body["tear"].is_object() {
        TEAR.iter().for_each(|(pointer, name)| put(name, body["tear"].pointer(pointer).unwrap_or(&Value::Null)));
        put("tips", &json!(body["tear"]["tips"].as_array().map_or(0, Vec::len)));
    }
    BODY.iter().for_each(|name| put(name, &body[name]));
    for force in body["reactions"].as_array().into_iter().flatten() {
        let parts: Vec<f64> = force["force_n"].as_array().into_iter().flatten().filter_map(Value::as_f64).collect();
        let length = parts.iter().map(|part| part * part).sum::<f64>().sqrt();
        put(&format!("{}_force_n", force["name"].as_str().unwrap_or_default()), &json!(length));
    }
}

/// The largest force of every hold over the run. Grips have theirs in the course of the tear.
fn peaks(run: &Path, bodies: &[Value], found: &mut Vec<(String, Value)>) {
    let Ok(table) = Table::read(run) else { return };
    for body in bodies {
        let name = body["name"].as_str().unwrap_or_default();
        let prefix = if bodies.len() == 1 { String::new() } else { format!("{name}/") };
        for hold in body["reactions"].as_array().into_iter().flatten() {
            let hold = hold["name"].as_str().unwrap_or_default();
            let force = table.lengths("N").into_iter().find(|(known, _)| *known == format!("{name}/{hold}"));
            if let Some((_, lengths)) = force {
                let peak = lengths.into_iter().fold(0.0, f64::max);
                found.push((format!("{prefix}{hold}_peak_n"), json!(peak)));
            }
        }
    }
}

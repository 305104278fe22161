//! The table of a sweep: `table.csv` with a row per case, `times.csv` with what depends on the machine.

use super::case::Case;
use super::plan::Plan;
use super::record::Record;
use crate::Stop;
use crate::output::file;
use rhexis_scene::output::OutputError;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

/// The files of a sweep's directory.
pub(super) const NAMES: [&str; 2] = ["table.csv", "times.csv"];

/// Columns before the parameters and after them, ahead of the measures.
const ENDS: [&str; 2] = ["end", "reason"];

/// A value as it stands in a cell: a string without its quotes.
pub(super) fn cell(text: &str) -> String {
    match toml::de::DeValue::parse(text) {
        Ok(value) => match value.get_ref().as_str() {
            Some(word) => word.to_owned(),
            None => text.split_whitespace().collect::<Vec<_>>().join(" "),
        },
        Err(_) => text.to_owned(),
    }
}

/// Writes both files from the cases that have a record, in the order of the cases: the same bytes in whatever order they ended.
///
/// # Errors
/// Where a file cannot be written.
pub(super) fn write(
    folder: &Path,
    plan: &Plan,
    cases: &[Case],
    records: &BTreeMap<String, Record>,
) -> Result<(), Stop> {
    let done: Vec<(&Case, &Record)> = cases.iter().filter_map(|case| Some((case, records.get(&case.key)?))).collect();
    let measures = columns(&done);
    let mut table = csv::Writer::from_writer(Vec::new());
    let names = plan.parameters().iter().map(|parameter| parameter.name.as_str());
    let header = ["case", "run"].into_iter().chain(names).chain(ENDS).chain(measures.iter().map(String::as_str));
    let mut rows = vec![header.map(str::to_owned).collect::<Vec<_>>()];
    for (case, record) in &done {
        let values = case.values.iter().map(|value| cell(value));
        let found = measures.iter().map(|name| record.measure(name).map_or(String::new(), plain));
        let ends = [record.end.clone(), record.reason.clone().unwrap_or_default()];
        rows.push(
            [case.number.to_string(), case.key.clone()].into_iter().chain(values).chain(ends).chain(found).collect(),
        );
    }
    put(&mut table, &rows, folder, NAMES[0])?;
    let mut times = csv::Writer::from_writer(Vec::new());
    let mut rows = vec![["case", "run", "elapsed_s", "stepping_s"].map(str::to_owned).to_vec()];
    for (case, record) in &done {
        let seconds = [record.elapsed_s, record.stepping_s].map(|time| format!("{time:.3}"));
        rows.push([case.number.to_string(), case.key.clone()].into_iter().chain(seconds).collect());
    }
    put(&mut times, &rows, folder, NAMES[1])
}

/// Measures in the order in which they first come.
fn columns(done: &[(&Case, &Record)]) -> Vec<String> {
    let mut columns: Vec<String> = Vec::new();
    for (_, record) in done {
        // Of one scene the columns are mostly the same from row to row.
        if record.measures.iter().map(|(name, _)| name).eq(columns.iter()) {
            continue;
        }
        for (name, _) in &record.measures {
            if !columns.contains(name) {
                columns.push(name.clone());
            }
        }
    }
    columns
}

fn plain(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

fn put(writer: &mut csv::Writer<Vec<u8>>, rows: &[Vec<String>], folder: &Path, name: &str) -> Result<(), Stop> {
    rows.iter().try_for_each(|row| writer.write_record(row)).map_err(|error| Stop::Failed(error.to_string()))?;
    writer.flush().map_err(|error| Stop::Failed(error.to_string()))?;
    file::replace(&folder.join(name), writer.get_ref()).map_err(|error: OutputError| Stop::Failed(error.to_string()))
}

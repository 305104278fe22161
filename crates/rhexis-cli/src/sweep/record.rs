//! What is kept of a case that has ended: a line of `cases.jsonl`.

use super::measures::measures;
use crate::journal::Journal;
use crate::{Stop, kept};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

/// The file of a sweep's directory that grows by a line per case.
pub(super) const NAME: &str = "cases.jsonl";

/// How a case ended, and its measures.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(super) struct Record {
    /// Tells the case from all others: of scene, values, files that are read, and version of the program.
    pub key: String,
    /// As in `report.json`; `refused` for a scene that cannot be built, `broken` for a run that ended the program's own way.
    pub end: String,
    /// Why it failed or was refused.
    pub reason: Option<String>,
    /// In their order.
    pub measures: Vec<(String, Value)>,
    /// Time from the first step to the end, with the writing of files.
    pub elapsed_s: f64,
    /// The part of it spent in steps.
    pub stepping_s: f64,
}

impl Record {
    /// Of a run's report.
    pub(super) fn of(key: &str, run: &Path, report: &Value) -> Self {
        let number = |name: &str| report[name].as_f64().unwrap_or(0.0);
        Self {
            key: key.to_owned(),
            end: report["end"]["state"].as_str().unwrap_or("broken").to_owned(),
            reason: report["end"]["reason"].as_str().map(str::to_owned),
            measures: measures(run, report),
            elapsed_s: number("elapsed_s"),
            stepping_s: number("stepping_s"),
        }
    }

    /// Of a case without a report.
    pub(super) fn without_report(key: &str, end: &str, reason: String) -> Self {
        let (key, end, reason) = (key.to_owned(), end.to_owned(), Some(reason));
        Self { key, end, reason, measures: Vec::new(), elapsed_s: 0.0, stepping_s: 0.0 }
    }

    /// Whether it gave no figures to trust.
    pub(super) fn has_failed(&self) -> bool {
        ["failed", "refused", "broken"].contains(&self.end.as_str())
    }

    /// A measure by its name.
    pub(super) fn measure(&self, name: &str) -> Option<&Value> {
        self.measures.iter().find(|(known, _)| known == name).map(|(_, value)| value)
    }
}

/// The records of a directory by their keys, and the file to go on with. Of two of one key the last counts: the first had failed.
///
/// # Errors
/// Where the file cannot be read or written, and for a line that is no record.
pub(super) fn open(folder: &Path) -> Result<(BTreeMap<String, Record>, Journal), Stop> {
    let path = folder.join(NAME);
    let failed = |error: std::io::Error| Stop::Failed(format!("cannot open {}: {error}", path.display()));
    let (records, whole) = read_whole(folder)?;
    let journal = if path.exists() { Journal::resume(&path, whole) } else { Journal::create(&path) };
    Ok((records, journal.map_err(failed)?))
}

/// The records of a directory, none where there is no file yet.
///
/// # Errors
/// As [`open`].
pub(super) fn read(folder: &Path) -> Result<BTreeMap<String, Record>, Stop> {
    read_whole(folder).map(|(records, _)| records)
}

/// The records of a directory and the length of their lines, without one that was being written when the program was killed.
fn read_whole(folder: &Path) -> Result<(BTreeMap<String, Record>, u64), Stop> {
    let path = folder.join(NAME);
    let text = match kept::text(&path) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok((BTreeMap::new(), 0)),
        Err(error) => return Err(Stop::Failed(format!("cannot read {}: {error}", path.display()))),
    };
    let whole = text.rfind('\n').map_or(0, |at| at + 1);
    let mut records = BTreeMap::new();
    for (line, words) in text[..whole].lines().enumerate() {
        let record: Record = serde_json::from_str(words).map_err(|error| {
            let place = format!("{}:{}", path.display(), line + 1);
            Stop::Failed(format!(
                "{place}: is no record of a case: {error}; take the line out, and the case is run anew"
            ))
        })?;
        records.insert(record.key.clone(), record);
    }
    Ok((records, whole as u64))
}

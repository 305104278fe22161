//! `series.csv` of a run as columns.

use crate::{Stop, kept};
use std::path::Path;

/// The columns of a run.
pub(crate) struct Table {
    /// Name of the run's directory.
    pub run: String,
    names: Vec<String>,
    columns: Vec<Vec<f64>>,
}

impl Table {
    /// Reads the series of a run.
    pub(crate) fn read(directory: &Path) -> Result<Self, Stop> {
        let path = directory.join("series.csv");
        let failed = |what: &dyn std::fmt::Display| {
            let help = "give the output directory of `rhexis run`";
            Stop::Failed(format!("{}: {what}; {help}", path.display()))
        };
        let mut reader = csv::Reader::from_reader(kept::open(&path).map_err(|error| failed(&error))?);
        let names: Vec<String> = reader.headers().map_err(|error| failed(&error))?.iter().map(str::to_owned).collect();
        let mut columns = vec![Vec::new(); names.len()];
        for record in reader.records() {
            let record = record.map_err(|error| failed(&error))?;
            for (column, value) in columns.iter_mut().zip(&record) {
                column.push(value.parse().unwrap_or(f64::NAN));
            }
        }
        if columns.first().is_none_or(Vec::is_empty) {
            return Err(failed(&"it has no rows"));
        }
        let name = directory.file_name().map(|name| name.to_string_lossy().into_owned());
        Ok(Self { run: name.unwrap_or_else(|| directory.display().to_string()), names, columns })
    }

    /// A column by its name.
    pub(super) fn column(&self, name: &str) -> Result<&[f64], Stop> {
        let found = self.names.iter().position(|known| known == name);
        found.map(|at| self.columns[at].as_slice()).ok_or_else(|| {
            let names = self.names.join(", ");
            Stop::Failed(format!("{}: series.csv has no column `{name}`; it has {names}", self.run))
        })
    }

    /// The named vectors of three columns with this unit, as their lengths: forces of holds and grips.
    pub(crate) fn lengths(&self, unit: &str) -> Vec<(String, Vec<f64>)> {
        let vector = |(at, name): (usize, &String)| {
            let stem = name.strip_suffix(&format!("_x_{unit}"))?;
            let axes = [at, at + 1, at + 2].map(|at| self.columns.get(at));
            let [Some(x), Some(y), Some(z)] = axes else { return None };
            let lengths = x.iter().zip(y).zip(z).map(|((x, y), z)| (x * x + y * y + z * z).sqrt()).collect();
            Some((stem.to_owned(), lengths))
        };
        self.names.iter().enumerate().filter_map(vector).collect()
    }
}

/// What an axis shows: a column's name with its unit in brackets.
pub(crate) fn label(column: &str) -> String {
    const UNITS: [(&str, &str); 10] = [
        ("_N_per_mm", "N/mm"),
        ("_N_mm", "N·mm"),
        ("_mJ", "mJ"),
        ("_mm2", "mm²"),
        ("_mm", "mm"),
        ("_ms", "ms"),
        ("_MPa", "MPa"),
        ("_N", "N"),
        ("_n", "N"),
        ("_deg", "°"),
    ];
    let found = UNITS.iter().find_map(|(suffix, unit)| Some((column.strip_suffix(suffix)?, unit)));
    found.map_or(column.replace('_', " "), |(stem, unit)| format!("{} [{unit}]", stem.replace('_', " ")))
}

//! Reading the reference files.

use super::VerifyError;
use glam::DVec3;
use serde_json::Value;

/// A JSON reference file.
pub(super) struct Json {
    file: &'static str,
    root: Value,
}

impl Json {
    /// Reads the text of a file.
    pub(super) fn new(file: &'static str, text: &str) -> Result<Self, VerifyError> {
        let root = serde_json::from_str(text).map_err(|e| VerifyError::Reference { file, what: e.to_string() })?;
        Ok(Self { file, root })
    }

    fn missing(&self, path: &str, kind: &str) -> VerifyError {
        VerifyError::Reference { file: self.file, what: format!("no {kind} at {path}") }
    }

    /// The number at a JSON pointer.
    pub(super) fn number(&self, path: &str) -> Result<f64, VerifyError> {
        self.root.pointer(path).and_then(Value::as_f64).ok_or_else(|| self.missing(path, "number"))
    }

    /// Number of elements of the list at a JSON pointer.
    pub(super) fn len(&self, path: &str) -> Result<usize, VerifyError> {
        self.root.pointer(path).and_then(Value::as_array).map(Vec::len).ok_or_else(|| self.missing(path, "list"))
    }

    /// Whether the value at a JSON pointer is `true`.
    pub(super) fn is_true(&self, path: &str) -> bool {
        self.root.pointer(path).and_then(Value::as_bool).unwrap_or(false)
    }

    /// The list of numbers at a JSON pointer.
    pub(super) fn numbers(&self, path: &str) -> Result<Vec<f64>, VerifyError> {
        (0..self.len(path)?).map(|i| self.number(&format!("{path}/{i}"))).collect()
    }

    /// The list of vectors at a JSON pointer, of two components (z = 0) or three.
    pub(super) fn vectors(&self, path: &str) -> Result<Vec<DVec3>, VerifyError> {
        let vector = |i: usize| {
            let at = format!("{path}/{i}");
            match self.numbers(&at)?[..] {
                [x, y] => Ok(DVec3::new(x, y, 0.0)),
                [x, y, z] => Ok(DVec3::new(x, y, z)),
                _ => Err(self.missing(&at, "vector")),
            }
        };
        (0..self.len(path)?).map(vector).collect()
    }
}

/// The rows of a CSV reference file with `N` columns.
pub(super) fn csv<const N: usize>(file: &'static str, text: &str) -> Result<Vec<[f64; N]>, VerifyError> {
    let wrong = |what: String| VerifyError::Reference { file, what };
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
    let row = |record: Result<csv::StringRecord, csv::Error>| {
        let record = record.map_err(|e| wrong(e.to_string()))?;
        let numbers: Result<Vec<f64>, _> = record.iter().map(str::parse::<f64>).collect();
        let numbers = numbers.map_err(|e| wrong(e.to_string()))?;
        numbers.try_into().map_err(|n: Vec<f64>| wrong(format!("{} columns where {N} are expected", n.len())))
    };
    reader.records().map(row).collect()
}

/// The file `$name` of `tests/reference`, as (name, text).
macro_rules! file {
    ($name:literal) => {
        ($name, include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/reference/", $name)))
    };
}

pub(super) use file;

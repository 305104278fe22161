//! A table of results: printed in columns, kept as CSV with the machine's speed in its head.

use super::{BenchError, Context, Yardsticks};
use rhexis::internal::source;
use rhexis_scene::output::file;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// The largest table that is read \[bytes\].
const MOST_BYTES: u64 = 64 << 20;

/// A table of results.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Name of its file, without the ending.
    pub name: String,
    /// The machine's speed while it was made.
    pub yardsticks: Yardsticks,
    /// How many of the columns, from the left, say which row it is; the rest is measured.
    pub key_count: usize,
    /// Names of the columns. Measured ones end with their unit: `_ms`, `_mm`, …
    pub columns: Vec<String>,
    /// The rows.
    pub rows: Vec<Vec<String>>,
    /// What is to be said about them, line by line.
    pub remarks: Vec<String>,
}

impl Table {
    /// An empty table.
    pub fn new(name: impl Into<String>, context: &Context, keys: &[&str], measured: &[&str]) -> Self {
        let columns = keys.iter().chain(measured).map(|&column| column.to_owned()).collect();
        let (name, yardsticks, key_count) = (name.into(), context.yardsticks, keys.len());
        Self { name, yardsticks, key_count, columns, rows: Vec::new(), remarks: Vec::new() }
    }

    /// Adds a row: first its keys, then its figures.
    pub fn add(&mut self, keys: &[&str], figures: &[f64]) {
        let figures = figures.iter().map(|&figure| shortest(figure));
        self.rows.push(keys.iter().map(|&key| key.to_owned()).chain(figures).collect());
    }

    /// Adds a line about the rows.
    pub fn remark(&mut self, text: impl Into<String>) {
        self.remarks.push(text.into());
    }

    /// The text of its file.
    pub fn csv(&self) -> String {
        let Yardsticks { fma_gflops, triad_gbs } = self.yardsticks;
        let mut text = format!(
            "# rhexis {}, {}, {}\n# fma_gflops {fma_gflops:.1}\n# triad_gbs {triad_gbs:.2}\n# keys {}\n",
            env!("CARGO_PKG_VERSION"),
            std::env::consts::ARCH,
            std::env::consts::OS,
            self.key_count
        );
        for remark in &self.remarks {
            let _ = writeln!(text, "# {remark}");
        }
        for row in std::iter::once(&self.columns).chain(&self.rows) {
            let fields: Vec<String> = row.iter().map(|field| field.replace(',', ";")).collect();
            let _ = writeln!(text, "{}", fields.join(","));
        }
        text
    }

    /// Writes `<name>.csv` into the directory.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&self, directory: &Path) -> Result<PathBuf, BenchError> {
        make(directory)?;
        let path = directory.join(format!("{}.csv", self.name));
        file::replace(&path, self.csv().as_bytes())?;
        Ok(path)
    }

    /// Reads a table that was written.
    ///
    /// # Errors
    /// If it cannot be read or is none.
    pub fn read(path: &Path) -> Result<Self, BenchError> {
        let wrong = |what: &str| BenchError::File { path: path.to_owned(), what: what.to_owned() };
        let bytes = source::read(path, MOST_BYTES).map_err(|e| wrong(&e.to_string()))?;
        let text = String::from_utf8(bytes).map_err(|e| wrong(&e.to_string()))?;
        let head = |name: &str| {
            let line = text.lines().find_map(|line| line.strip_prefix("# ")?.strip_prefix(name)?.strip_prefix(' '));
            line.and_then(|value| value.trim().parse::<f64>().ok()).filter(|value| *value > 0.0)
        };
        let missing =
            "not a table of results: its head lacks the machine's speed; take a file that `rhexis bench` wrote";
        let (Some(fma_gflops), Some(triad_gbs)) = (head("fma_gflops"), head("triad_gbs")) else {
            return Err(wrong(missing));
        };
        let fields = |line: &str| line.split(',').map(str::to_owned).collect::<Vec<String>>();
        let mut rows = text.lines().filter(|line| !line.starts_with('#')).map(fields);
        let columns = rows.next().ok_or_else(|| wrong("there is no row in it"))?;
        let rows: Vec<Vec<String>> = rows.collect();
        if rows.iter().any(|row| row.len() != columns.len()) {
            return Err(wrong("some rows have more or fewer fields than there are columns"));
        }
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let key_count = (head("keys").unwrap_or(1.0) as usize).min(columns.len());
        let yardsticks = Yardsticks { fma_gflops, triad_gbs };
        Ok(Self { name, yardsticks, key_count, columns, rows, remarks: Vec::new() })
    }

    /// The table in columns, for the eye.
    pub fn printed(&self) -> String {
        let lines = || std::iter::once(&self.columns).chain(&self.rows);
        let width = |column: usize| lines().map(|row| row[column].chars().count()).max().unwrap_or(0);
        let widths: Vec<usize> = (0..self.columns.len()).map(width).collect();
        let is_empty = |column: usize| self.rows.iter().all(|row| row[column].is_empty());
        let shown: Vec<bool> = (0..self.columns.len()).map(|column| !is_empty(column)).collect();
        let mut text = String::new();
        for row in lines() {
            for (column, field) in row.iter().enumerate().filter(|(column, _)| shown[*column]) {
                let width = widths[column];
                let _ = match column < self.key_count {
                    true => write!(text, "{field:width$}  "),
                    false => write!(text, "{field:>width$}  "),
                };
            }
            text.truncate(text.trim_end().len());
            text.push('\n');
        }
        for remark in &self.remarks {
            let _ = writeln!(text, "{remark}");
        }
        text
    }
}

/// Three digits; nothing for what was not measured.
fn shortest(figure: f64) -> String {
    match figure.abs() {
        _ if figure.is_nan() => String::new(),
        0.0 => "0".to_owned(),
        size if !(1e-3..1e6).contains(&size) => format!("{figure:.2e}"),
        size if size >= 100.0 => format!("{figure:.0}"),
        size => {
            let digits = (2 - size.log10().floor() as i32).max(0) as usize;
            format!("{figure:.digits$}")
        }
    }
}

/// Makes the directory.
pub(crate) fn make(directory: &Path) -> Result<(), BenchError> {
    let failed = |e: std::io::Error| BenchError::File { path: directory.to_owned(), what: e.to_string() };
    std::fs::create_dir_all(directory).map_err(failed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_have_three_digits() {
        let cases = [(0.0, "0"), (1.23456, "1.23"), (0.0123456, "0.0123"), (1234.5, "1234"), (1.5e-7, "1.50e-7")];
        for (figure, text) in cases {
            assert_eq!(shortest(figure), text);
        }
        assert_eq!(shortest(f64::NAN), "");
    }

    #[test]
    fn a_table_reads_back() {
        let yardsticks = Yardsticks { fma_gflops: 100.0, triad_gbs: 20.0 };
        let columns = ["case", "median_ms"].map(str::to_owned).to_vec();
        let rows = vec![vec!["a, b".to_owned(), "1.5".to_owned()]];
        let table = Table { name: "t".into(), yardsticks, key_count: 1, columns, rows, remarks: vec!["so".into()] };
        let directory = tempfile::tempdir().unwrap();
        let read = Table::read(&table.write(directory.path()).unwrap()).unwrap();
        assert_eq!((read.yardsticks, read.key_count, &read.columns), (yardsticks, 1, &table.columns));
        assert_eq!(read.rows, [["a; b", "1.5"]]);
        std::fs::write(directory.path().join("u.csv"), "a,b\n1,2\n").unwrap();
        assert!(Table::read(&directory.path().join("u.csv")).unwrap_err().to_string().contains("rhexis bench"));
    }
}

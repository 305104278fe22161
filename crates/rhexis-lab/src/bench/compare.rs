//! Two tables of the same benchmark beside each other: what has become faster or slower, machine and noise set aside.

use super::{BenchError, Table};
use std::path::Path;

/// Changes below this are not distinguished from noise, whatever the runs themselves say.
const LEAST: f64 = 0.1;
/// An error is the same bits in every run: a smaller change tells already.
const LEAST_OF_ERRORS: f64 = 0.02;

/// Compares the times and errors of the rows that both tables have. Times are scaled by the machines' speeds.
///
/// # Errors
/// If a file is no table, or the two have no row or column in common.
pub fn compare(before: &Path, after: &Path) -> Result<Table, BenchError> {
    let (a, b) = (Table::read(before)?, Table::read(after)?);
    let keys = a.columns[..a.key_count].to_vec();
    let common: Vec<(usize, usize)> = (a.key_count..a.columns.len())
        .filter(|&i| is_compared(&a.columns[i]))
        .filter_map(|i| Some((i, b.columns.iter().position(|column| *column == a.columns[i])?)))
        .collect();
    let is_alike = keys == b.columns[..b.key_count] && !common.is_empty();
    let columns = keys.iter().cloned().chain(["figure", "before", "after", "ratio", "verdict"].map(str::to_owned));
    let mut table = Table {
        name: "compare".to_owned(),
        yardsticks: b.yardsticks,
        key_count: a.key_count + 1,
        columns: columns.collect(),
        rows: Vec::new(),
        remarks: Vec::new(),
    };
    for row in &a.rows {
        let Some(other) = b.rows.iter().find(|other| is_alike && other[..b.key_count] == row[..a.key_count]) else {
            continue;
        };
        let speed = b.yardsticks.over(&a.yardsticks, triangles(&a, row));
        let noise = noise(&a, row).max(noise(&b, other));
        for &(i, j) in &common {
            let (Ok(was), Ok(is)) = (row[i].parse::<f64>(), other[j].parse::<f64>()) else { continue };
            let is_time = a.columns[i].ends_with("_ms");
            let ratio = if is_time { is * speed / was } else { is / was };
            let least = if is_time { LEAST.max(2.0 * noise) } else { LEAST_OF_ERRORS };
            if !ratio.is_finite() {
                continue;
            }
            let verdict = match ratio {
                r if r > 1.0 + least => "WORSE",
                r if r < 1.0 / (1.0 + least) => "better",
                _ => "same",
            };
            let mut fields = row[..a.key_count].to_vec();
            fields.extend([a.columns[i].clone(), row[i].clone(), other[j].clone(), format!("{ratio:.2}")]);
            fields.push(verdict.to_owned());
            table.rows.push(fields);
        }
    }
    if table.rows.is_empty() {
        let what = format!("has no row in common with {}; give two results of one benchmark", before.display());
        return Err(BenchError::File { path: after.to_owned(), what });
    }
    let count = |verdict: &str| table.rows.iter().filter(|row| row.last().is_some_and(|v| v == verdict)).count();
    let [better, worse] = ["better", "WORSE"].map(count);
    let (x, y) = (a.yardsticks, b.yardsticks);
    table.remark(format!(
        "this machine, before → after: {:.0} → {:.0} GFLOP/s, {:.1} → {:.1} GB/s; ratios of times are scaled by it",
        x.fma_gflops, y.fma_gflops, x.triad_gbs, y.triad_gbs
    ));
    table.remark(format!("{} figures compared, {better} better, {worse} worse", table.rows.len()));
    Ok(table)
}

/// Times and errors; not the slowest steps, which one disturbance decides.
fn is_compared(column: &str) -> bool {
    let is_extreme = column.starts_with("worst") || column.starts_with("p999");
    column.contains("error") || (column.ends_with("_ms") && !is_extreme)
}

fn field(table: &Table, row: &[String], name: &str) -> Option<f64> {
    let place = table.columns.iter().position(|column| column == name)?;
    row[place].parse().ok()
}

fn triangles(table: &Table, row: &[String]) -> usize {
    field(table, row, "triangles").map_or(0, |count| count as usize)
}

fn noise(table: &Table, row: &[String]) -> f64 {
    field(table, row, "noise").unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(directory: &Path, name: &str, gflops: f64, row: &str) -> std::path::PathBuf {
        let path = directory.join(name);
        let head =
            format!("# fma_gflops {gflops}\n# triad_gbs 20\n# keys 2\ncase,triangles,median_ms,stress_error,noise\n");
        std::fs::write(&path, format!("{head}{row}\n")).unwrap();
        path
    }

    #[test]
    fn times_are_scaled_and_small_changes_are_noise() {
        let directory = tempfile::tempdir().unwrap();
        let a = written(directory.path(), "a.csv", 100.0, "x,1500,2.0,1e-3,0.02");
        // Twice as fast a machine, and half the time: nothing has changed. The error has.
        let b = written(directory.path(), "b.csv", 200.0, "x,1500,1.0,2e-3,0.02");
        let table = compare(&a, &b).unwrap();
        let verdicts: Vec<&str> = table.rows.iter().map(|row| row.last().unwrap().as_str()).collect();
        assert_eq!(verdicts, ["same", "WORSE"], "{}", table.printed());
        let c = written(directory.path(), "c.csv", 100.0, "x,1500,2.5,1e-3,0.2");
        assert!(compare(&a, &c).unwrap().rows[0].last().unwrap() == "same", "within twice the noise of 20 %");
        let d = written(directory.path(), "d.csv", 100.0, "y,1500,2.5,1e-3,0.2");
        assert!(compare(&a, &d).unwrap_err().to_string().contains("no row in common"));
    }
}

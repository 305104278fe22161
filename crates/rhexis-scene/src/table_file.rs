//! Curves and paths from tables of numbers: `{ csv = "hand.csv" }` in place of a list of points.

use super::document::join;
use super::error::Fault;
use super::files::Files;
use glam::{DVec3, DVec4};
use rhexis::math::elementary;
use serde::Deserialize;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

/// Sine of half a turn from which its axis is more than rounding.
const LEAST_SINE: f64 = 1e-9;

/// Largest file that is read \[bytes\].
const MOST_BYTES: u64 = 64 << 20;

/// A curve or path in a file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TableSpec {
    /// CSV file with a row per point, `,`, `;` or tabs between its columns; relative to the scene file.
    pub csv: PathBuf,
    /// Columns to be read, by their names or their places from 0: time first, then the value, or x, y and z. Of a `rotate` also the four of a
    /// quaternion, x, y, z and w; from row to row the shorter way round is taken. Default all.
    #[serde(default)]
    pub columns: Vec<ColumnSpec>,
    /// Unit of the times: `"ms"` (default) or `"s"`.
    #[serde(default)]
    pub time_unit: TimeUnitSpec,
}

/// A column of a table.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged)]
pub enum ColumnSpec {
    /// By its place, from 0.
    Place(usize),
    /// By its name in the first row.
    Name(String),
}

/// Unit of times in a table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
pub enum TimeUnitSpec {
    /// Milliseconds.
    #[default]
    #[serde(rename = "ms")]
    Milliseconds,
    /// Seconds.
    #[serde(rename = "s")]
    Seconds,
}

/// Reads a table as TOML: `[[t, v], …]`, or `[[t, [x, y, z]], …]`. `key` is that of the table in the scene.
pub(super) fn read(spec: &TableSpec, files: &Files, key: &str) -> Result<String, Fault> {
    let path = files.path(&spec.csv);
    let at_file = |what: String, hint: &str| Fault::new(join(key, "csv"), what, hint);
    let bytes = files.read(&spec.csv, MOST_BYTES).map_err(|error| {
        let hint = "check the path and the permissions; a relative path begins at the scene file's folder";
        at_file(format!("cannot read {}: {error}", path.display()), hint)
    })?;
    let text = String::from_utf8_lossy(&bytes);
    let separator = separator(&text);
    let mut reader = csv::ReaderBuilder::new()
        .delimiter(separator)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .has_headers(false)
        .from_reader(text.as_bytes());
    let (mut columns, mut rows): (Option<Vec<usize>>, Vec<String>) = (None, Vec::new());
    let mut turned = DVec3::ZERO;
    for record in reader.records() {
        let hint = "every row has as many numbers as the first";
        let record = record.map_err(|error| at_file(format!("{}: {error}", path.display()), hint))?;
        let line = record.position().map_or(0, csv::Position::line);
        let is_header = columns.is_none() && record.iter().any(|field| field.parse::<f64>().is_err());
        let own = match &columns {
            Some(own) => own,
            None => columns.insert(places(spec, is_header.then_some(&record), record.len(), &path, key)?),
        };
        if is_header {
            continue;
        }
        let mut numbers = Vec::with_capacity(own.len());
        for &column in own {
            let field = record.get(column).unwrap_or_default();
            let number = field.parse::<f64>().ok().filter(|number| number.is_finite());
            numbers.push(number.ok_or_else(|| {
                let what = format!("{}:{line}: {field:?} in column {column} is not a finite number", path.display());
                at_file(what, "give numbers with a point, as 1.5 or 2e-3")
            })?);
        }
        if let [time, x, y, z, w] = numbers[..] {
            turned = rotation_vector(DVec4::new(x, y, z, w), turned).ok_or_else(|| {
                let what = format!("{}:{line}: the quaternion is zero", path.display());
                at_file(what, "give x, y, z and w of a rotation")
            })?;
            let degrees = turned.map(f64::to_degrees);
            numbers = vec![time, degrees.x, degrees.y, degrees.z];
        }
        rows.push(row(&numbers, spec.time_unit));
    }
    if rows.is_empty() {
        return Err(at_file(format!("{} has no row of numbers", path.display()), "give a row per point, time first"));
    }
    Ok(format!("[{}]", rows.join(", ")))
}

/// The rotation vector \[rad\] of a quaternion, of any length but zero, that is nearest to another one.
fn rotation_vector(quaternion: DVec4, near: DVec3) -> Option<DVec3> {
    let DVec4 { x, y, z, w } = quaternion.try_normalize()?;
    let part = DVec3::new(x, y, z);
    // Next to no turn has no axis of its own: a tracker that comes round is back at whole turns about the one it had.
    let own = if part.length() > LEAST_SINE { part } else { near };
    let Some(axis) = own.try_normalize() else { return Some(DVec3::ZERO) };
    let angle = 2.0 * elementary::atan2(part.dot(axis), w);
    let turns = ((near.dot(axis) - angle) / TAU).round();
    Some(axis * (angle + turns * TAU))
}

/// The separator of columns: a semicolon or a tab where the first rows have any, else a comma.
fn separator(text: &str) -> u8 {
    let first: String = text.lines().filter(|line| !line.starts_with('#')).take(2).collect();
    *[b';', b'\t'].iter().find(|byte| first.as_bytes().contains(byte)).unwrap_or(&b',')
}

/// Places of the columns to be read, of a table with so many.
fn places(
    spec: &TableSpec,
    header: Option<&csv::StringRecord>,
    count: usize,
    path: &Path,
    key: &str,
) -> Result<Vec<usize>, Fault> {
    let names: Vec<&str> = header.into_iter().flatten().collect();
    let place = |(i, column): (usize, &ColumnSpec)| {
        let found = match column {
            ColumnSpec::Place(place) => Some(*place).filter(|place| *place < count),
            ColumnSpec::Name(name) => names.iter().position(|own| own == name),
        };
        found.ok_or_else(|| {
            let name = match column {
                ColumnSpec::Place(place) => place.to_string(),
                ColumnSpec::Name(name) => format!("{name:?}"),
            };
            let has = if names.is_empty() { format!("{count} without names") } else { names.join(", ") };
            let what = format!("{} has no column {name}: it has {has}", path.display());
            Fault::new(format!("{key}.columns.{i}"), what, "name one of these, or its place from 0")
        })
    };
    let given: Vec<usize> = spec.columns.iter().enumerate().map(place).collect::<Result<_, _>>()?;
    let columns = if given.is_empty() { (0..count).collect() } else { given };
    let most = if key == "rotate" || key.ends_with(".rotate") { 5 } else { 4 };
    if (2..=most).contains(&columns.len()) {
        return Ok(columns);
    }
    let what = format!("{} gives {} column(s) a point", path.display(), columns.len());
    let hint = "choose by `columns` the time and the value, or the time and x, y, z; of a `rotate` also the time and a quaternion's x, y, z, w";
    Err(Fault::new(format!("{key}.columns"), what, hint))
}

/// A point as TOML.
fn row(numbers: &[f64], unit: TimeUnitSpec) -> String {
    let time = if unit == TimeUnitSpec::Seconds { numbers[0] * 1e3 } else { numbers[0] };
    match numbers {
        [_, value] => format!("[{time:?}, {value:?}]"),
        _ => format!("[{time:?}, {:?}]", &numbers[1..]),
    }
}

#[cfg(test)]
mod tests {
    use crate::Document;

    /// Reads a hold's curve from a table.
    fn curve(table: &str, spec: &str) -> Result<Vec<(f64, f64)>, String> {
        let mut document = Document::named("fig2").unwrap().with_file("hand.csv", table.as_bytes().to_vec());
        document.set(&format!("bodies.0.holds.1.curve={spec}")).unwrap();
        let scene = document.scene().map_err(|error| error.to_string())?;
        Ok(scene.file().bodies[0].holds[1].curve.0.points().to_vec())
    }

    #[test]
    fn a_curve_is_read_by_names_places_or_all_of_it() {
        let points = vec![(0.0, 0.0), (1500.0, 2.5e-3)];
        assert_eq!(curve("0,0\n1500,2.5e-3\n", "{ csv = \"hand.csv\" }"), Ok(points.clone()));
        let named = "t; force; way\n0; 9; 0\n1.5; 9; 2.5e-3\n";
        let spec = "{ csv = \"hand.csv\", columns = [\"t\", \"way\"], time_unit = \"s\" }";
        assert_eq!(curve(named, spec), Ok(points.clone()));
        let spec = "{ csv = \"hand.csv\", columns = [0, 2], time_unit = \"s\" }";
        assert_eq!(curve(named, spec), Ok(points));
    }

    #[test]
    fn a_path_is_read_from_four_columns() {
        let mut document =
            Document::named("capsulorhexis").unwrap().with_file("way.csv", b"0,0,0,0\n10,1,2,3\n".to_vec());
        document.set("obstacles.0.path={ csv = \"way.csv\" }").unwrap();
        let scene = document.scene().unwrap();
        let path = scene.file().obstacles[0].path.as_ref().unwrap();
        assert_eq!(path.0.points[1], (10.0, glam::DVec3::new(1.0, 2.0, 3.0)));
    }

    #[test]
    fn turns_are_read_from_quaternions_without_a_jump() {
        // Twice round about z in steps of 60°, as a tracker tells it, whose sign turns over.
        let row = |k: u32| {
            let half = 30_f64.to_radians() * f64::from(k);
            let sign = if half.cos() < 0.0 { -1.0 } else { 1.0 };
            format!("{k},0,0,{:?},{:?}\n", sign * half.sin(), sign * half.cos())
        };
        let table: String = (0..=12).map(row).collect();
        let read = |table: String, key: &str| {
            let mut document = Document::named("capsulorhexis").unwrap().with_file("turn.csv", table.into_bytes());
            document.set(&format!("obstacles.0.{key}={{ csv = \"turn.csv\" }}")).unwrap();
            document.scene().map_err(|error| error.to_string())
        };
        let scene = read(table.clone(), "rotate").unwrap();
        let turns = &scene.file().obstacles[0].rotate.as_ref().unwrap().0.points;
        for (k, (time, degrees)) in turns.iter().enumerate() {
            assert!(*time == k as f64 && degrees.distance(glam::DVec3::Z * (60.0 * k as f64)) < 1e-9, "{degrees}");
        }
        assert!(read(table, "path").unwrap_err().contains("5 column(s) a point"));
        assert!(read("0,0,0,0,0\n".to_owned(), "rotate").unwrap_err().contains("turn.csv:1: the quaternion is zero"));
    }

    #[test]
    fn what_is_wrong_in_a_table_is_named_with_file_and_line() {
        for (table, spec, what) in [
            ("0,0\n5,x\n", "{ csv = \"hand.csv\" }", "hand.csv:2: \"x\" in column 1"),
            ("0,0\n5\n", "{ csv = \"hand.csv\" }", "hand.csv"),
            ("t,v\n", "{ csv = \"hand.csv\" }", "no row of numbers"),
            ("t,v\n0,1\n", "{ csv = \"hand.csv\", columns = [\"t\", \"w\"] }", "no column \"w\": it has t, v"),
            ("0,1,2,3,4\n", "{ csv = \"hand.csv\" }", "5 column(s) a point"),
            ("0,1\n0,2\n", "{ csv = \"hand.csv\" }", "must be larger"),
            ("0,1\n", "{ csv = \"other.csv\" }", "cannot read other.csv"),
            ("0,1\n", "{ csv = \"hand.csv\", unit = \"s\" }", "unknown key `unit`"),
        ] {
            let refused = curve(table, spec).unwrap_err();
            assert!(refused.contains(what), "{refused}");
        }
    }
}

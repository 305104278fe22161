//! Figures that documents quote from runs: each stands between markers that name its run, and equals the program's report.
//!
//! `<!-- figure: SCENE KEY=VALUE …: NAME,NAME; NAME -->5.23, 5.45 | 0.983<!-- /figure -->` has the figures `NAME` of a run of `SCENE` with these
//! values set; a semicolon begins the next cell of a table. Times by the clock have no place in it.

use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const BEGIN: &str = "<!-- figure: ";
const END: &str = "<!-- /figure -->";
const HOW: &str = "RHEXIS_UPDATE_FIGURES=1 cargo test --release -p rhexis-cli --test figures -- --ignored";

/// One figure of the tear's course; a dash where the run has none, `None` for an unknown name.
fn figure(course: &Value, name: &str) -> Option<String> {
    let number = |value: &Value, scale: f64, digits: usize| {
        value.as_f64().map_or_else(|| "–".to_owned(), |number| format!("{:.digits$}", scale * number))
    };
    let course_number = |key: &str, scale, digits| Some(number(&course[key], scale, digits));
    match name {
        "outcome" => Some(course[name].as_str().unwrap_or("–").replace('_', " ")),
        "completion" => course_number("completion_deg", 1.0, 0),
        "diameter" => course_number("diameter_mm", 1.0, 2),
        "as_it_lies" => course_number("diameter_as_it_lies_mm", 1.0, 2),
        "circularity" => course_number("circularity", 1.0, 3),
        "decentration" => course_number("decentration_mm", 1.0, 2),
        "largest_radius" => course_number("largest_radius_mm", 1.0, 2),
        "grasps" => course_number("grasps", 1.0, 0),
        "time" => course_number("time_ms", 1e-3, 1),
        "rms" => course_number("force_rms_n", 1e3, 1),
        "peak" => course_number("force_peak_n", 1e3, 1),
        "rms_by_grasp" => {
            let grasps = course["force_by_grasp"].as_array().map(Vec::as_slice).unwrap_or_default();
            Some(grasps.iter().map(|grasp| number(&grasp["force_rms_n"], 1e3, 1)).collect::<Vec<_>>().join(", "))
        }
        _ => None,
    }
}

/// The text of a marker's figures in a run.
fn text(course: &Value, names: &str) -> Option<String> {
    let cells = names.split(';').map(|cell| {
        let figures: Option<Vec<String>> = cell.split(',').map(|name| figure(course, name.trim())).collect();
        Some(figures?.join(", "))
    });
    Some(cells.collect::<Option<Vec<_>>>()?.join(" | "))
}

/// A marker of a document.
struct Marker {
    line: usize,
    /// Scene and values set.
    run: String,
    names: String,
    shown: String,
    /// Bytes of the shown text.
    range: std::ops::Range<usize>,
}

fn broken(file: &str, line: usize) -> ! {
    panic!("{file}:{line}: not `{BEGIN}SCENE KEY=VALUE …: NAMES -->TEXT{END}`")
}

fn markers(file: &str, document: &str) -> Vec<Marker> {
    let mut found = Vec::new();
    let mut at = 0;
    while let Some(begin) = document[at..].find(BEGIN).map(|place| at + place) {
        let line = 1 + document[..begin].matches('\n').count();
        let head = begin + BEGIN.len();
        let Some((what, rest)) = document[head..].split_once(" -->") else { broken(file, line) };
        let (Some((run, names)), Some(length)) = (what.rsplit_once(": "), rest.find(END)) else { broken(file, line) };
        let start = head + what.len() + " -->".len();
        let range = start..start + length;
        at = range.end;
        found.push(Marker {
            line,
            run: run.to_owned(),
            names: names.to_owned(),
            shown: document[range.clone()].to_owned(),
            range,
        });
    }
    found
}

/// All documents with figures.
fn documents() -> Vec<(String, PathBuf, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut pending = ["README.md", "docs", "crates", "bindings"].map(|name| root.join(name)).to_vec();
    let mut found = Vec::new();
    while let Some(path) = pending.pop() {
        let name = path.strip_prefix(&root).unwrap().display().to_string();
        if path.is_dir() {
            let is_left_out = ["target", "node_modules"].iter().any(|folder| path.ends_with(folder));
            let inner = fs::read_dir(&path).unwrap().map(|entry| entry.unwrap().path());
            pending.extend(inner.filter(|inner| !is_left_out && !inner.is_symlink()));
        } else if path.extension().is_some_and(|extension| extension == "md") {
            let document = fs::read_to_string(&path).unwrap();
            if document.contains(BEGIN) {
                found.push((name, path, document));
            }
        }
    }
    found.sort();
    found
}

/// The course of a body of this run, as the program reports it.
fn course(run: &str) -> Value {
    let folder = tempfile::tempdir().unwrap();
    let mut words = run.split_whitespace();
    let mut command = Command::new(env!("CARGO_BIN_EXE_rhexis"));
    command.current_dir(folder.path()).args(["run", words.next().unwrap(), "--json", "--quiet"]);
    for set in words.chain(["output.pictures=0", "output.frames=0"]) {
        command.args(["--set", set]);
    }
    let output = command.output().unwrap();
    assert!(output.status.success(), "{run}: {}", String::from_utf8_lossy(&output.stderr));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let course = report["bodies"][0]["course"].clone();
    assert!(course.is_object(), "{run}: no body has a tear that is drawn by forceps");
    course
}

/// The numbers of a text, each with the unit of its last digit, and the words between them.
fn numbers(text: &str) -> (Vec<(f64, f64)>, Vec<&str>) {
    let is_number = |c: char| c.is_ascii_digit() || c == '.';
    let words = text.split(|c: char| !is_number(c)).filter(|word| !word.is_empty());
    let numbers = words.map(|word| {
        let digits = word.split_once('.').map_or(0, |(_, digits)| digits.len());
        (word.parse().unwrap_or(f64::NAN), 0.1_f64.powi(digits as i32))
    });
    (numbers.collect(), text.split(is_number).filter(|between| !between.is_empty()).collect())
}

/// Whether two texts differ in numbers alone, by one unit of the last digit at the most.
fn agree(old: &str, new: &str) -> bool {
    let ((old, around), (new, around_new)) = (numbers(old), numbers(new));
    let is_near = |((a, unit), (b, _)): (&(f64, f64), &(f64, f64))| (a - b).abs() <= 1.01 * unit;
    around == around_new && old.len() == new.len() && old.iter().zip(&new).all(is_near)
}

#[test]
fn every_marker_names_figures_and_a_scene() {
    let documents = documents();
    assert!(documents.iter().any(|(name, ..)| name == "docs/capsulorhexis.md"));
    for (name, _, document) in &documents {
        for Marker { line, run, names, shown, .. } in markers(name, document) {
            assert!(text(&Value::Null, &names).is_some(), "{name}:{line}: an unknown figure in {names:?}");
            let scene = run.split_whitespace().next().unwrap_or_default();
            assert!(rhexis_scene::catalog::find(scene).is_ok(), "{name}:{line}: no scene {scene:?} in the catalog");
            // A line that begins with a comment is HTML, and ends the paragraph before it.
            let start = document.lines().nth(line - 1).unwrap_or_default().trim_start();
            assert!(!start.starts_with("<!--"), "{name}:{line}: put a word before the marker");
            let count = |separator| names.matches(separator).count();
            assert_eq!(shown.matches('|').count(), count(';'), "{name}:{line}: {shown:?} is not {names:?}");
        }
    }
    assert!(agree("5.23, 5.45 | closed", "5.22, 5.46 | closed"));
    assert!(!agree("5.23 | closed", "5.21 | closed") && !agree("5.23 | closed", "5.23 | ran out"));
}

#[test]
#[ignore = "runs of minutes: cargo test --release -p rhexis-cli --test figures -- --ignored; RHEXIS_UPDATE_FIGURES=1 rewrites the documents"]
fn figures_are_those_of_the_program() {
    let is_updated = std::env::var_os("RHEXIS_UPDATE_FIGURES").is_some();
    let (mut courses, mut changes) = (BTreeMap::new(), String::new());
    for (name, path, mut document) in documents() {
        let mut texts = Vec::new();
        for Marker { line, run, names, shown, range } in markers(&name, &document) {
            let course = courses.entry(run.clone()).or_insert_with(|| course(&run));
            let now = text(course, &names).unwrap();
            if !agree(&shown, &now) {
                changes += &format!("{name}:{line}: {shown:?} is now {now:?} ({run})\n");
            }
            texts.push((range, now));
        }
        if is_updated {
            // From the last to the first: replacing a text moves those behind it.
            texts.into_iter().rev().for_each(|(range, now)| document.replace_range(range, &now));
            fs::write(path, document).unwrap();
        }
    }
    assert!(is_updated || changes.is_empty(), "figures off by more than one unit of their last digit:\n{changes}{HOW}");
    print!("{changes}");
}

//! Sweeps: cases of a file, their table, interruptions, what is refused.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Twelve cases of a few steps on a coarse square: two angles, two ends of a range, three samples.
const TWELVE: &str = r#"scene = "fig2-tear"
samples = 3
seed = 7

[set]
"run.steps" = 20
"bodies.0.mesh" = { grid = { width = 30, height = 30, nx = 10, ny = 10 } }
"bodies.0.tearing.radius" = 4

[vary]
"bodies.0.fibres.degrees" = [45, 60]
"bodies.0.material.young_fibre" = { from = 5, to = 20, count = 2 }

[sample]
"bodies.0.tearing.strength_along_fibres, bodies.0.damping" = { uniform = [0.004, 0.006] }
"#;

fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rhexis"));
    command.current_dir(folder).args(arguments).stdin(Stdio::null());
    command
}

fn rhexis(folder: &Path, arguments: &[&str]) -> Output {
    command(folder, arguments).output().unwrap()
}

fn words(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn swept(folder: &Path, arguments: &[&str]) -> String {
    let output = rhexis(folder, &[&["sweep"], arguments].concat());
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", words(&output.stderr));
    words(&output.stdout)
}

/// The table's columns by name.
fn rows(path: &Path) -> Vec<std::collections::BTreeMap<String, String>> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    reader.deserialize().map(Result::unwrap).collect()
}

fn lines(path: &Path) -> Vec<String> {
    fs::read_to_string(path).unwrap_or_default().lines().map(str::to_owned).collect()
}

/// The keys of the cases that are done, each once.
fn keys(folder: &Path) -> BTreeSet<String> {
    let lines = lines(&folder.join("cases.jsonl"));
    let key = |line: &String| serde_json::from_str::<serde_json::Value>(line).unwrap()["key"].to_string();
    let keys: BTreeSet<String> = lines.iter().map(key).collect();
    assert_eq!(keys.len(), lines.len(), "a case is there twice");
    keys
}

#[test]
fn lists_ranges_and_samples_are_one_table_on_any_number_of_cores() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("twelve.toml"), TWELVE).unwrap();
    let said = swept(folder, &["twelve.toml", "--jobs", "1"]);
    assert!(said.contains("12 of 12 cases done, 0 failed"), "{said}");
    swept(folder, &["twelve.toml", "--jobs", "5", "--out", "five"]);
    let [one, five] = ["out/twelve", "five"].map(|out| fs::read(folder.join(out).join("table.csv")).unwrap());
    assert!(one == five, "the table depends on the number of cores");

    let rows = rows(&folder.join("five/table.csv"));
    let column = |name: &str| rows.iter().map(|row| row[name].as_str()).collect::<Vec<_>>();
    assert_eq!(column("case"), ["0", "1", "2", "3", "4", "5", "6", "7", "8", "9", "10", "11"]);
    assert_eq!(column("bodies.0.fibres.degrees"), [&["45"; 6][..], &["60"; 6]].concat());
    assert_eq!(column("bodies.0.material.young_fibre")[..6], ["5", "5", "5", "20", "20", "20"]);
    let samples = column("bodies.0.tearing.strength_along_fibres, bodies.0.damping");
    // The same three for every combination, and no two alike.
    assert_eq!(samples[..3], samples[9..]);
    assert_eq!(samples.iter().collect::<BTreeSet<_>>().len(), 3);
    assert!(samples.iter().all(|s| (0.004..=0.006).contains(&s.parse::<f64>().unwrap())));
    assert_eq!(column("hash").into_iter().collect::<BTreeSet<_>>().len(), 12);
    assert!(column("right_peak_n").iter().all(|force| force.parse::<f64>().unwrap() > 0.0));
    assert_eq!(column("end"), ["torn_through"; 12]);

    // What a case has in the table is what a run of it reports.
    let report = fs::read_to_string(folder.join(format!("five/cases/{}/report.json", rows[4]["run"]))).unwrap();
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    assert_eq!(report["hash"], rows[4]["hash"].as_str());
    assert_eq!(report["threads"], 1);
    assert_eq!(report["bodies"][0]["tear"]["length_mm"].to_string(), rows[4]["tear_length_mm"]);
    assert_eq!(lines(&folder.join("five/times.csv")).len(), 13);
    let plot = folder.join("five/plots/right_peak_n-over-bodies-0-material-young_fibre.svg");
    assert!(fs::read_to_string(plot).unwrap().contains("bodies.0.material.young_fibre"));
}

#[test]
fn a_sweep_that_was_killed_goes_on_without_loss_or_doubling() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("twelve.toml"), TWELVE).unwrap();
    swept(folder, &["twelve.toml", "--out", "whole"]);
    let whole = fs::read(folder.join("whole/table.csv")).unwrap();

    let mut child = command(folder, &["sweep", "twelve.toml", "--jobs", "1", "--quiet"]).spawn().unwrap();
    let out = folder.join("out/twelve");
    let start = Instant::now();
    while lines(&out.join("cases.jsonl")).len() < 3 && child.try_wait().unwrap().is_none() {
        assert!(start.elapsed() < Duration::from_secs(300), "nothing is done");
        sleep(Duration::from_millis(1));
    }
    // It may have come to its end by itself: what follows holds then, too.
    let _ = child.kill();
    child.wait().unwrap();
    // Killed while it wrote a line.
    let done = lines(&out.join("cases.jsonl"));
    let text = done[..2].join("\n") + "\n" + &done[2][..done[2].len() / 2];
    fs::write(out.join("cases.jsonl"), text).unwrap();
    fs::remove_dir_all(out.join("cases")).unwrap();
    swept(folder, &["twelve.toml", "--jobs", "2"]);
    assert_eq!(keys(&out).len(), 12);
    assert!(fs::read(out.join("table.csv")).unwrap() == whole);
    // The two that were done were not run again.
    assert_eq!(fs::read_dir(out.join("cases")).unwrap().count(), 10);

    // Nothing is left to do; a longer list adds its own cases.
    fs::remove_dir_all(out.join("cases")).unwrap();
    swept(folder, &["twelve.toml"]);
    assert!(!out.join("cases").exists());
    fs::write(folder.join("twelve.toml"), TWELVE.replace("[45, 60]", "[30, 45, 60]")).unwrap();
    let said = swept(folder, &["twelve.toml"]);
    assert!(said.contains("18 of 18"), "{said}");
    assert_eq!(fs::read_dir(out.join("cases")).unwrap().count(), 6);
    assert_eq!(keys(&out).len(), 18);
    assert_eq!(rows(&out.join("table.csv")).len(), 18);
}

#[cfg(unix)]
#[test]
fn ctrl_c_keeps_what_is_done_and_the_state_of_what_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let long = TWELVE
        .replace("\"run.steps\" = 20", "\"run.steps\" = 300\n\"run.until_torn\" = false")
        .replace("samples = 3", "samples = 1");
    fs::write(folder.join("long.toml"), long).unwrap();
    swept(folder, &["long.toml", "--out", "whole", "--jobs", "2"]);
    let child = command(folder, &["sweep", "long.toml", "--jobs", "2"]).stderr(Stdio::piped()).spawn().unwrap();
    let out = folder.join("out/long");
    let start = Instant::now();
    let has_begun =
        |run: &fs::DirEntry| fs::metadata(run.path().join("series.csv")).is_ok_and(|data| data.len() > 4000);
    while fs::read_dir(out.join("cases")).into_iter().flatten().filter_map(Result::ok).filter(has_begun).count() < 2 {
        assert!(start.elapsed() < Duration::from_secs(300), "nothing has begun");
        sleep(Duration::from_millis(1));
    }
    Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    let ended = child.wait_with_output().unwrap();
    assert_eq!(ended.status.code(), Some(130), "{}", words(&ended.stderr));
    let states = fs::read_dir(out.join("cases"))
        .unwrap()
        .filter(|run| run.as_ref().unwrap().path().join("run.snapshot").exists());
    assert_eq!(states.count(), 2, "of the two that were running");
    assert!(out.join("table.csv").exists());
    // They go on from there, to the table of a sweep without a break.
    swept(folder, &["long.toml"]);
    let [whole, resumed] = ["whole", "out/long"].map(|out| fs::read(folder.join(out).join("table.csv")).unwrap());
    assert!(whole == resumed);
}

#[test]
fn a_case_that_fails_is_a_row_with_its_reason() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let text = TWELVE.split("[vary]").next().unwrap().replace("samples = 3", "keep = false");
    let text = text + "[vary]\n\"bodies.0.material.thickness\" = [0.1, -0.1]\n\"bodies.0.fibres.degrees\" = [45, 50]\n";
    fs::write(folder.join("thin.toml"), text).unwrap();
    let output = rhexis(folder, &["sweep", "thin.toml"]);
    assert_eq!(output.status.code(), Some(0), "{}", words(&output.stderr));
    let said = words(&output.stdout) + &words(&output.stderr);
    assert!(said.contains("4 of 4 cases done, 2 failed") && said.contains("case 2: refused"), "{said}");
    let rows = rows(&folder.join("out/thin/table.csv"));
    let ends: Vec<&str> = rows.iter().map(|row| row["end"].as_str()).collect();
    assert_eq!(ends, ["done", "done", "refused", "refused"]);
    let reason = &rows[3]["reason"];
    assert!(reason.contains("thickness") && reason.contains("-0.1"), "{reason}");
    assert!(rows[3]["hash"].is_empty() && !rows[0]["hash"].is_empty());
    // keep = false
    let left = fs::read_dir(folder.join("out/thin/cases")).map_or(0, Iterator::count);
    assert_eq!(left, 0);
    // They count as done, unless it is asked to try them again.
    let listed = swept(folder, &["thin.toml", "--list"]);
    assert_eq!(listed.matches(",true,").count(), 4, "{listed}");
    let listed = swept(folder, &["thin.toml", "--list", "--retry-failed"]);
    assert_eq!(listed.matches(",true,").count(), 2, "{listed}");
}

#[test]
fn bad_keys_and_values_are_named_with_file_and_line() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for (from, to, wanted) in [
        ("bodies.0.fibres.degrees", "bodies.0.fibre.degrees", ["bad.toml:11:1", "`fibre`"]),
        ("young_fibre", "young_fiber", ["bad.toml:12:1", "young_fibre"]),
        ("[45, 60]", "[45, \"steep\"]", ["bad.toml:11:1", "steep"]),
        ("\"run.steps\" = 20", "\"run.step\" = 20", ["bad.toml:6:1", "`steps`"]),
        ("seed = 7", "sed = 7", ["bad.toml:3:1", "`seed`"]),
        ("samples = 3", "", ["bad.toml:14:1", "go together"]),
        ("count = 2", "cout = 2", ["bad.toml:12:1", "cout"]),
        ("uniform", "unform", ["bad.toml:15:1", "unform"]),
        ("\"bodies.0.fibres.degrees\"", "bodies.0.fibres.degrees", ["bad.toml:11:1", "in quotes"]),
        ("\"run.steps\" = 20", "\"bodies.0.fibres.degrees\" = 20", ["bad.toml:11:1", "given twice"]),
        ("fig2-tear", "fig3-tear", ["fig3-tear", "fig2-tear"]),
        ("[vary]", "[vary", ["bad.toml:10:", "help"]),
    ] {
        assert!(TWELVE.contains(from), "{from}");
        fs::write(folder.join("bad.toml"), TWELVE.replacen(from, to, 1)).unwrap();
        let output = rhexis(folder, &["sweep", "bad.toml"]);
        let error = words(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{to}: {error}");
        assert!(wanted.iter().all(|word| error.contains(word)) && !error.contains("panicked"), "{to}: {error}");
        assert!(!folder.join("out").exists(), "{to}: nothing is written before the file is understood");
    }
    let output = rhexis(folder, &["sweep", "nowhere.toml"]);
    assert!(words(&output.stderr).contains("nowhere.toml"));
}

#[test]
fn one_case_alone_gives_the_record_that_the_table_is_made_of() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("twelve.toml"), TWELVE).unwrap();
    swept(folder, &["twelve.toml", "--out", "whole"]);
    let listed: serde_json::Value = serde_json::from_str(&swept(folder, &["twelve.toml", "--list", "--json"])).unwrap();
    assert_eq!(listed["cases"].as_array().unwrap().len(), 12);
    assert_eq!(listed["cases"][4]["values"]["bodies.0.material.young_fibre"], "20");
    fs::create_dir_all(folder.join("out/twelve")).unwrap();
    let records: String =
        (0..12).map(|n| swept(folder, &["twelve.toml", "--case", &n.to_string(), "--out", "alone"])).collect();
    fs::write(folder.join("out/twelve/cases.jsonl"), records).unwrap();
    swept(folder, &["twelve.toml", "--table"]);
    let [whole, gathered] = ["whole", "out/twelve"].map(|out| fs::read(folder.join(out).join("table.csv")).unwrap());
    assert!(whole == gathered);
    let refused = rhexis(folder, &["sweep", "twelve.toml", "--case", "12"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(words(&refused.stderr).contains("the cases 0 to 11"));
    // Nobody is there any more to take the result.
    let left = rhexis(
        folder,
        &["sweep", "twelve.toml", "--case", "0", "--out", "left", "--until-input-ends", "--set", "run.steps=100000"],
    );
    assert_eq!(left.status.code(), Some(130));
}

#[test]
fn the_example_sweeps_are_understood() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/sweeps");
    let files: Vec<_> = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert!(!files.is_empty());
    for file in files {
        let listed = swept(&folder, &[file.to_str().unwrap(), "--list"]);
        assert!(listed.lines().count() > 2, "{}", file.display());
    }
    let help = swept(&folder, &["--help"]);
    let example: String =
        help.split("as fibres.toml:\n").nth(1).unwrap().split("\n\n  rhexis").next().unwrap().to_owned();
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("fibres.toml"), example).unwrap();
    let listed = swept(folder.path(), &["fibres.toml", "--list"]);
    assert_eq!(listed.lines().count(), 1 + 3 * 3 * 4, "{listed}");
}

//! What happens around a run does not break it: full disks, directories that vanish, signals, kills in the middle of a write.
//!
//! No test waits for a time: each watches the files of the run until they show that it is where it is wanted.
#![cfg(unix)]

use serde_json::Value;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};

fn rhexis(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rhexis"));
    command.current_dir(folder).args(arguments).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// Under a limit of so many blocks of 512 bytes for any file, as it stands for a full disk.
fn limited(folder: &Path, blocks: u32, arguments: &[&str]) -> Output {
    let script = format!("ulimit -f {blocks}; exec \"$0\" \"$@\"");
    let program = env!("CARGO_BIN_EXE_rhexis");
    let mut command = Command::new("sh");
    command.current_dir(folder).args(["-c", &script, program]).args(arguments).stdin(Stdio::null()).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn error_of(output: &Output, code: i32) -> String {
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{error}");
    assert!(!error.contains("panicked"), "{error}");
    error
}

fn read(folder: &Path, name: &str) -> String {
    std::fs::read_to_string(folder.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

fn report(folder: &Path) -> Value {
    serde_json::from_str(&read(folder, "report.json")).unwrap()
}

/// Whole rows of `series.csv`, the header not counted; none while there is no file.
fn rows(out: &Path) -> usize {
    std::fs::read_to_string(out.join("series.csv")).map_or(0, |text| text.matches('\n').count().saturating_sub(1))
}

/// Whether it came there before it ended.
fn comes_to(child: &mut Child, mut is_there: impl FnMut() -> bool) -> bool {
    while !is_there() {
        if child.try_wait().unwrap().is_some() {
            return false;
        }
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    true
}

fn wait_until(child: &mut Child, is_there: impl FnMut() -> bool) {
    assert!(comes_to(child, is_there), "the run has ended before it was where it was wanted");
}

fn signal(child: &Child, name: &str) {
    assert!(Command::new("kill").args([name, &child.id().to_string()]).status().unwrap().success());
}

/// 60 steps of `fig2-tear` on a finer mesh, which take long enough to be caught in the middle; the tear runs from the twentieth on.
const SHORT: [&str; 15] = [
    "run",
    "fig2-tear",
    "--set",
    "run.steps=60",
    "--set",
    "output.pictures=0",
    "--set",
    "output.frames=4",
    "--set",
    "run.until_torn=false",
    "--set",
    "bodies.0.mesh.grid.nx=50",
    "--set",
    "bodies.0.mesh.grid.ny=42",
    "--quiet",
];

/// Small, and endless as far as a test goes.
const ENDLESS: [&str; 12] = [
    "run",
    "fig2",
    "--set",
    "run.steps=1000000",
    "--set",
    "output.pictures=0",
    "--set",
    "output.frames=0",
    "--set",
    "bodies.0.mesh.grid.nx=4",
    "--set",
    "bodies.0.mesh.grid.ny=4",
];

fn with<'a>(base: &[&'a str], more: &[&'a str]) -> Vec<&'a str> {
    [base, more].concat()
}

fn assert_same(folder: &Path, whole: &str, other: &str) {
    let names =
        ["series.csv", "events.jsonl", "frames.pvd", "dump/positions.csv", "dump/stresses.csv", "dump/reactions.csv"];
    for name in names {
        let [whole, other] = [whole, other].map(|out| read(&folder.join(out), name));
        assert!(whole == other, "{name}");
    }
    let names = |out: &str| {
        let names = std::fs::read_dir(folder.join(out)).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<String> = names.filter(|n| n.ends_with(".vtu") || n.ends_with(".png")).collect();
        names.sort();
        names
    };
    assert_eq!(names(whole), names(other));
    let [whole, other] = [whole, other].map(|out| report(&folder.join(out)));
    for key in ["end", "steps", "simulated_ms", "bodies", "solver", "events", "ambiguous", "caveats"] {
        assert_eq!(whole[key], other[key], "{key}");
    }
}

#[test]
fn a_full_disk_ends_no_run() {
    let folder = tempfile::tempdir().unwrap();
    let steps = ["--out", "full", "--steps", "40", "--set", "output.pictures=2", "--snapshots", "5"];
    let output = limited(folder.path(), 4, &with(&ENDLESS, &steps));
    let error = error_of(&output, 1);
    for name in ["series.csv", "report.json", "run.snapshot", "picture-0-000000.png"] {
        assert!(error.contains(&format!("full/{name}")), "{name} is not named: {error}");
    }
    assert!(error.contains("File too large") && error.contains("--out"), "reason and remedy: {error}");
    assert_eq!(error.matches("warning: cannot write full/series.csv").count(), 1, "told once: {error}");
    // It went to its end all the same, and the figures stand on standard output.
    assert!(text(&output.stdout).contains("done after 40 of 40 steps"), "{}", text(&output.stdout));
    let series = read(&folder.path().join("full"), "series.csv");
    assert!(series.len() <= 2048 && series.ends_with('\n') && series.lines().count() > 3, "whole rows: {series}");
    assert!(std::fs::read_dir(folder.path().join("full")).unwrap().count() < 10, "no heap of parts");
}

#[test]
fn rows_wait_for_room_and_are_then_written() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("o");
    std::fs::create_dir(&out).unwrap();
    std::os::unix::fs::symlink("/dev/full", out.join("series.csv")).unwrap();
    let mut child = rhexis(folder.path(), &with(&ENDLESS, &["--out", "o"])).spawn().unwrap();
    // Made after the series.
    wait_until(&mut child, || out.join("events.jsonl").exists());
    std::fs::remove_file(out.join("series.csv")).unwrap();
    wait_until(&mut child, || rows(&out) > 20);
    signal(&child, "-INT");
    let output = child.wait_with_output().unwrap();
    error_of(&output, 130);
    let series = read(&out, "series.csv");
    let steps: Vec<&str> = series.lines().skip(1).map(|row| row.split(',').next().unwrap()).collect();
    assert!(steps.iter().enumerate().all(|(i, step)| *step == i.to_string()), "no row is missing");
    assert_eq!(report(&out)["steps"].as_u64(), Some(steps.len() as u64 - 1));
    let caveats = report(&out)["caveats"].to_string();
    assert!(caveats.contains("series.csv was taken away during the run"), "{caveats}");
}

#[test]
fn a_directory_that_vanishes_is_made_anew() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("o");
    let mut child = rhexis(folder.path(), &with(&ENDLESS, &["--out", "o", "--snapshots", "5"])).spawn().unwrap();
    wait_until(&mut child, || rows(&out) > 10 && out.join("run.snapshot").exists());
    // Under a name of its own first: a file that is made in between would keep a directory from going.
    std::fs::rename(&out, folder.path().join("gone")).unwrap();
    std::fs::remove_dir_all(folder.path().join("gone")).unwrap();
    wait_until(&mut child, || rows(&out) > 30 && out.join("run.snapshot").exists());
    signal(&child, "-TERM");
    error_of(&child.wait_with_output().unwrap(), 130);
    let steps = report(&out)["steps"].as_u64().unwrap();
    assert_eq!(rows(&out) as u64, steps + 1, "all rows, those from before too");
    assert_eq!(report(&out)["end"]["state"], "interrupted");
}

#[test]
fn an_interrupted_run_goes_on_to_the_same_results() {
    let folder = tempfile::tempdir().unwrap();
    let done = |more: &[&str]| {
        let output = rhexis(folder.path(), &with(&SHORT, more)).output().unwrap();
        error_of(&output, 0);
    };
    done(&["--out", "whole", "--dump", "whole/dump"]);
    for name in ["INT", "TERM"] {
        let out = folder.path().join(name);
        // On a busy machine a run may be over before anybody sees that it is half done.
        let output = (0..50).find_map(|_| {
            let _ = std::fs::remove_dir_all(&out);
            let mut child = rhexis(folder.path(), &with(&SHORT, &["--out", name])).spawn().unwrap();
            if comes_to(&mut child, || rows(&out) > 25) && child.try_wait().unwrap().is_none() {
                signal(&child, &format!("-{name}"));
            }
            let output = child.wait_with_output().unwrap();
            (output.status.code() != Some(0)).then_some(output)
        });
        let error = error_of(&output.expect("never caught in the middle"), 130);
        assert!(error.contains("interrupted"), "{error}");
        let steps = report(&out)["steps"].as_u64().unwrap();
        assert!(report(&out)["end"]["state"] == "interrupted" && steps < 60 && rows(&out) as u64 == steps + 1);
        done(&["--out", name, "--resume", "--dump", &format!("{name}/dump")]);
        assert_same(folder.path(), "whole", name);
    }
}

#[test]
fn a_run_killed_again_and_again_comes_to_the_same_results() {
    let folder = tempfile::tempdir().unwrap();
    let done = |more: &[&str]| {
        let output = rhexis(folder.path(), &with(&SHORT, more)).output().unwrap();
        error_of(&output, 0);
    };
    done(&["--out", "whole", "--dump", "whole/dump"]);
    let out = folder.path().join("killed");
    let arguments = with(&SHORT, &["--out", "killed", "--snapshots", "1"]);
    let mut kills = 0;
    // A snapshot after every step: most kills fall into the writing of one.
    for at in [2, 5, 12, 19, 26, 33, 40, 47] {
        let more: &[&str] = if out.join("run.snapshot").exists() { &["--resume"] } else { &[] };
        let mut child = rhexis(folder.path(), &with(&arguments, more)).spawn().unwrap();
        if comes_to(&mut child, || rows(&out) > at && out.join("run.snapshot").exists()) {
            child.kill().unwrap();
        }
        kills += usize::from(child.wait().unwrap().code().is_none());
    }
    assert!(kills > 0, "never caught in the middle");
    // As a kill in the middle of a write leaves it.
    std::fs::write(out.join("run.snapshot.part"), "rhexrun and no more").unwrap();
    done(&["--out", "killed", "--resume", "--dump", "killed/dump"]);
    assert_same(folder.path(), "whole", "killed");
}

#[cfg(target_os = "linux")]
#[test]
fn a_second_interrupt_ends_at_once() {
    let folder = tempfile::tempdir().unwrap();
    // One case, of minutes: only a second signal can end it before its time, and then it prints nothing any more.
    let mut child = rhexis(folder.path(), &["verify", "tear-load"]).spawn().unwrap();
    let status = format!("/proc/{}/status", child.id());
    let catches_sigint = || {
        let status = std::fs::read_to_string(&status).unwrap_or_default();
        let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap_or_default();
        u64::from_str_radix(caught.trim(), 16).is_ok_and(|bits| bits & 2 != 0)
    };
    wait_until(&mut child, catches_sigint);
    while child.try_wait().unwrap().is_none() {
        let _ = Command::new("kill").args(["-INT", &child.id().to_string()]).stderr(Stdio::null()).status();
    }
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130));
    assert!(!text(&output.stdout).contains("comparisons"), "{}", text(&output.stdout));
}

#[test]
fn a_second_run_into_the_same_directory_is_refused_while_the_first_lives() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("o");
    let arguments = with(&ENDLESS, &["--out", "o", "--snapshots", "5", "--quiet"]);
    let short = with(&arguments, &["--steps", "3"]);
    let mut first = rhexis(folder.path(), &arguments).spawn().unwrap();
    wait_until(&mut first, || rows(&out) > 10 && out.join("run.snapshot").exists());
    for more in [&[][..], &["--resume"]] {
        let error = error_of(&rhexis(folder.path(), &with(&short, more)).output().unwrap(), 1);
        let holder = format!("o is in use: process {} ", first.id());
        assert!(error.contains(&holder) && error.contains("another directory with --out"), "{error}");
    }
    let seen = rows(&out);
    wait_until(&mut first, || rows(&out) > seen + 5);
    let series = read(&out, "series.csv");
    let steps: Vec<&str> = series.lines().skip(1).map(|row| row.split(',').next().unwrap()).collect();
    // The last row may be half read.
    let whole = &steps[..steps.len() - 1];
    assert!(whole.iter().enumerate().all(|(i, step)| *step == i.to_string()), "rows of one run");

    first.kill().unwrap();
    first.wait().unwrap();
    assert!(out.join("run.lock").exists(), "what a killed run leaves");
    let steps = (read(&out, "series.csv").lines().count() + 2).to_string();
    error_of(&rhexis(folder.path(), &with(&arguments, &["--steps", &steps, "--resume"])).output().unwrap(), 0);
    assert!(!out.join("run.lock").exists(), "one that has ended leaves none");
    error_of(&rhexis(folder.path(), &short).output().unwrap(), 0);
    assert_eq!(rows(&out), 4);
}

/// The lock of a directory that was taken away is taken anew with it.
#[test]
fn a_directory_that_was_made_anew_is_still_one_runs() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("o");
    let arguments = with(&ENDLESS, &["--out", "o"]);
    let mut first = rhexis(folder.path(), &arguments).spawn().unwrap();
    wait_until(&mut first, || rows(&out) > 10);
    std::fs::rename(&out, folder.path().join("gone")).unwrap();
    wait_until(&mut first, || out.join("run.lock").exists() && rows(&out) > 10);
    let error = error_of(&rhexis(folder.path(), &arguments).output().unwrap(), 1);
    assert!(error.contains("o is in use"), "{error}");
    signal(&first, "-INT");
    error_of(&first.wait_with_output().unwrap(), 130);
}

#[test]
fn a_recording_that_cannot_be_written_any_more_costs_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("o");
    let arguments = with(&ENDLESS, &["--out", "o", "--record", "taken.rec"]);
    let mut child = rhexis(folder.path(), &arguments).spawn().unwrap();
    wait_until(&mut child, || rows(&out) > 3);
    std::fs::create_dir(folder.path().join("taken.rec")).unwrap();
    signal(&child, "-INT");
    let error = error_of(&child.wait_with_output().unwrap(), 1);
    assert!(error.contains("taken.rec") && error.contains("--record"), "{error}");
    assert_eq!(report(&out)["end"]["state"], "interrupted");
    // Known before the run.
    let arguments = with(&ENDLESS, &["--steps", "3", "--out", "p", "--record", "taken.rec"]);
    let error = error_of(&rhexis(folder.path(), &arguments).output().unwrap(), 1);
    assert!(error.contains("taken.rec: it is a directory") && error.contains("--record"), "{error}");
    assert!(!folder.path().join("p/series.csv").exists(), "before the run");
    std::fs::write(folder.path().join("file"), "").unwrap();
    let arguments = with(&ENDLESS, &["--steps", "3", "--record", "file/inside.rec"]);
    let error = error_of(&rhexis(folder.path(), &arguments).output().unwrap(), 1);
    assert!(error.contains("file") && error.contains("--record"), "before the run: {error}");
}

/// Renaming a file over a device would take the device from everybody.
#[test]
fn a_device_is_never_replaced() {
    use std::os::unix::fs::FileTypeExt;
    let folder = tempfile::tempdir().unwrap();
    // A device stands behind the name: what a rename takes away is the name.
    let name = folder.path().join("null");
    std::os::unix::fs::symlink("/dev/null", &name).unwrap();
    let arguments = with(&ENDLESS, &["--steps", "3", "--record", "null"]);
    let error = error_of(&rhexis(folder.path(), &arguments).output().unwrap(), 1);
    assert!(error.contains("null: not a regular file"), "{error}");
    assert!(std::fs::metadata(&name).unwrap().file_type().is_char_device());
}

#[test]
fn nobody_reads_standard_output() {
    let folder = tempfile::tempdir().unwrap();
    let run = with(&ENDLESS, &["--steps", "2"]);
    let json = with(&run, &["--json"]);
    let failing = with(&run, &["--set", "run.dt=1e-300"]);
    let commands: [(&[&str], i32); 6] = [
        (&["scenes"], 0),
        (&["scenes", "--show", "capsulorhexis"], 0),
        (&["run", "--help"], 0),
        (&run, 0),
        (&json, 0),
        // A failure is one whoever reads.
        (&failing, 1),
    ];
    for (arguments, code) in commands {
        let mut child = rhexis(folder.path(), arguments).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        let error = error_of(&output, code);
        assert!(code == 1 || error.is_empty(), "{arguments:?}: {error}");
    }
}

#[test]
fn a_full_standard_output_is_a_failure() {
    let folder = tempfile::tempdir().unwrap();
    for arguments in [&["scenes"][..], &with(&ENDLESS, &["--steps", "2", "--json"])] {
        let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
        let output = rhexis(folder.path(), arguments).stdout(full).output().unwrap();
        let error = error_of(&output, 1);
        assert!(error.contains("standard output"), "{error}");
    }
}

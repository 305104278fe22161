//! The program as a user runs it: files, exit codes, error texts.

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output, Stdio};

fn rhexis(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rhexis"));
    command.current_dir(folder).args(arguments).stdin(Stdio::null()).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn done(folder: &Path, arguments: &[&str]) -> String {
    let output = rhexis(folder, arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", text(&output.stderr));
    text(&output.stdout)
}

fn refused(folder: &Path, arguments: &[&str], code: i32) -> String {
    let output = rhexis(folder, arguments);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {}", text(&output.stdout));
    assert!(output.stdout.is_empty(), "an error belongs on standard error: {}", text(&output.stdout));
    let error = text(&output.stderr);
    assert!(!error.contains("panicked"), "{error}");
    error
}

fn read(folder: &Path, name: &str) -> String {
    std::fs::read_to_string(folder.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|e| panic!("{e}: {text}"))
}

/// Names in a directory that start and end so.
fn files(folder: &Path, start: &str, end: &str) -> Vec<String> {
    let names = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = names.filter(|n| n.starts_with(start) && n.ends_with(end)).collect();
    names.sort();
    names
}

#[test]
fn a_run_writes_report_series_frames_and_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let pictures =
        ["--set", "output.pictures=2", "--set", "output.frames=3", "--set", "run.advanced.stress_tolerance=1e-5"];
    let summary = done(folder.path(), &[&["run", "fig2", "--steps", "4"], &pictures[..]].concat());
    assert!(summary.contains("fig2: done after 4 of 4 steps, 40.000000 ms simulated"), "{summary}");
    assert!(summary.contains("right: 0.04"), "the grips' force after 0.12 mm of pull: {summary}");
    let out = folder.path().join("out/fig2");

    let report = json(&read(&out, "report.json"));
    assert_eq!(report["end"]["state"], "done");
    assert_eq!(report["steps"], 4);
    assert_eq!(report["simulated_ms"], 40.0);
    assert_eq!(report["bodies"][0]["triangles"], 1500);
    assert_eq!(report["overrides"][0], "output.pictures=2");
    assert!(report["bodies"][0]["elastic_mj"].as_f64().unwrap() > 0.0);
    assert_eq!(report["caveats"], Value::Array(vec![]), "a clean run");
    let [left, right] = [0, 1].map(|i| report["bodies"][0]["reactions"][i]["force_n"][0].as_f64().unwrap());
    // Action and reaction, to ten times the error of the stress that is asked for.
    assert!(right > 0.0 && (left + right).abs() < 1e-4 * right, "{left} {right}");
    let systems: Vec<&str> =
        report["systems"].as_array().unwrap().iter().map(|s| s["name"].as_str().unwrap()).collect();
    let expected: Vec<&str> = rhexis::schedule::STEP.iter().map(|s| s.name).collect();
    assert_eq!(systems, expected);

    let series = read(&out, "series.csv");
    let mut rows = csv::Reader::from_reader(series.as_bytes());
    let header = rows.headers().unwrap().clone();
    assert_eq!(&header[0], "step");
    assert!(header.iter().any(|name| name == "square/right_x_N"), "{header:?}");
    let rows: Vec<csv::StringRecord> = rows.records().map(|r| r.unwrap()).collect();
    assert_eq!(rows.iter().map(|r| r[0].to_owned()).collect::<Vec<_>>(), ["0", "1", "2", "3", "4"]);

    assert_eq!(read(&out, "events.jsonl"), "", "nothing tears here");
    assert_eq!(files(&out, "picture-", ".png"), ["picture-0-000000.png", "picture-0-000004.png"]);
    let frames = ["frames-0-square-000000.vtu", "frames-0-square-000002.vtu", "frames-0-square-000004.vtu"];
    assert_eq!(files(&out, "frames", ".vtu"), frames);
    assert_eq!(read(&out, "frames.pvd").matches("<DataSet").count(), 3);
    assert_eq!(files(&out, "", ".part"), Vec::<String>::new());
}

#[test]
fn a_tear_is_reported_to_its_end() {
    let folder = tempfile::tempdir().unwrap();
    let energy = ["--set", "output.energy=true"];
    let arguments =
        ["run", "fig2-tear", "--out", "torn", "--set", "output.frames=0", "--timings", energy[0], energy[1]];
    let summary = done(folder.path(), &arguments);
    assert!(summary.contains("torn through after"), "{summary}");
    let out = folder.path().join("torn");
    let report = json(&read(&out, "report.json"));
    let tear = &report["bodies"][0]["tear"];
    assert_eq!(report["end"]["state"], "torn_through");
    assert_eq!(tear["tips"], Value::Array(vec![]));
    let [work, imbalance] = ["work_of_holds", "imbalance"].map(|term| report["bodies"][0]["balance_mj"][term].as_f64());
    // Rounding of the sums of 1,600 triangles over a hundred steps.
    assert!(imbalance.unwrap().abs() < 1e-10 * work.unwrap(), "{imbalance:?} of {work:?} mJ");
    let series = read(&out, "series.csv");
    let header = series.lines().next().unwrap();
    assert!(header.contains("numerical_elastic_mJ") && header.contains("dissipated_mJ"), "{header}");
    // Of strengths: no toughness claims anything, and nothing pretends that it were zero.
    assert!(!header.contains("surface_energy") && !header.contains("overshoot"), "{header}");
    let account = &tear["account"];
    assert!(account["surface_energy_mj"].is_null() && account["overshoot_max"].is_null(), "{account}");
    let span = &account["between_advances"];
    let [released, area] = ["released_mj", "torn_area_mm2"].map(|figure| span[figure].as_f64().unwrap());
    assert!(released > 0.0 && area > 0.0 && span["toughness_n_per_mm"].is_null(), "{span}");
    let gone = ["torn_mj", "damping_mj", "drag_mj", "numerical_mj", "other_mj", "kinetic_change_mj"];
    let gone: f64 = gone.iter().map(|figure| span[figure].as_f64().unwrap()).sum();
    // As the imbalance above, and the motion that edits have put in.
    assert!((gone - released).abs() < 1e-6 * released, "{gone} of {released} mJ");
    // The notch of 3 mm and from (15, 27) along 45° to the left grip.
    let whole = 3.0 + 15.0 * 2.0_f64.sqrt();
    assert!((tear["length_mm"].as_f64().unwrap() - whole).abs() < 0.5, "{tear}");
    let notes = report["caveats"].to_string();
    assert!(notes.contains("edges per averaging radius"), "this mesh is coarse for R and the report says so: {notes}");

    let events: Vec<Value> = read(&out, "events.jsonl").lines().map(json).collect();
    assert_eq!(events[0]["kind"], "started");
    let paid: Vec<&Value> = events.iter().filter(|e| e["kind"] == "advances_paid").collect();
    let sum: f64 = paid.iter().map(|span| span["released_mj"].as_f64().unwrap()).sum();
    // The spans add up to the whole.
    assert!((sum - released).abs() < 1e-9 * released, "{sum} of {released} mJ in {} spans", paid.len());
    let kinds = |kind: &str| events.iter().filter(|e| e["kind"] == kind).count() as u64;
    for kind in ["started", "advanced", "ended", "fragment_freed"] {
        assert_eq!(report["events"][kind].as_u64(), Some(kinds(kind)), "{kind}");
        assert!(kinds(kind) > 0, "{kind}");
    }
    assert!(events.iter().all(|e| e["body"] == "square" && e["time_ms"].is_number()));
    assert_eq!(files(&out, "frames", ""), Vec::<String>::new());

    // The systems in the step's order; those without work as skipped.
    let table = summary.split("system ").nth(1).unwrap();
    let places: Vec<usize> =
        rhexis::schedule::STEP.iter().map(|s| table.find(&format!("\n{} ", s.name)).unwrap()).collect();
    assert!(places.is_sorted(), "{table}");
    let line = |name: &str| table.lines().find(|l| l.starts_with(name)).unwrap();
    assert!(line("pressure").ends_with("skipped") && line("split").ends_with('%'), "{table}");
}

#[test]
fn json_alone_on_standard_output_and_a_dump_of_17_digits() {
    let folder = tempfile::tempdir().unwrap();
    let base = ["run", "fig2", "--set", "run.mode=static", "--steps", "1", "--json", "--timings", "--dump", "dump"];
    let output = rhexis(folder.path(), &base);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let report = json(&text(&output.stdout));
    assert_eq!(report["mode"], "static");
    assert!(text(&output.stderr).contains("solve"), "timings stay out of the way of the JSON");

    let dump = folder.path().join("dump");
    let mut positions = csv::Reader::from_path(dump.join("positions.csv")).unwrap();
    let first = positions.records().next().unwrap().unwrap();
    assert_eq!(
        first[2].split('e').next().unwrap().trim_start_matches('-').len(),
        18,
        "17 digits and a point: {first:?}"
    );
    assert_eq!(positions.records().count(), 31 * 26 - 1);
    let mut stresses = csv::Reader::from_path(dump.join("stresses.csv")).unwrap();
    assert_eq!(stresses.records().count(), 1500);
    let reactions = read(&dump, "reactions.csv");
    let right = reactions.lines().find(|l| l.starts_with("square/right,")).unwrap();
    let force: f64 = right.split(',').nth(1).unwrap().parse().unwrap();
    // Both texts name the same bits; the JSON one is the shortest that does.
    assert!(text(&output.stdout).contains(&format!(" {force},")), "{force}");
}

#[test]
fn series_are_the_same_bits_for_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    for threads in ["1", "2"] {
        let set = ["--set", "output.pictures=0", "--set", "output.frames=0", "--quiet"];
        let arguments =
            [&["run", "fig2-tear", "--steps", "40", "--threads", threads, "--out", threads], &set[..]].concat();
        assert_eq!(done(folder.path(), &arguments), "", "--quiet says nothing");
    }
    let [one, two] = ["1", "2"].map(|out| read(&folder.path().join(out), "series.csv"));
    assert_eq!(one.lines().count(), 42);
    assert_eq!(one, two);
}

#[test]
fn the_catalog_is_listed_and_shown() {
    let folder = tempfile::tempdir().unwrap();
    let list = done(folder.path(), &["scenes"]);
    assert_eq!(list.lines().count(), rhexis_scene::catalog::CATALOG.len());
    assert!(list.contains("capsulorhexis  "), "{list}");
    let shown = done(folder.path(), &["scenes", "--show", "fig2"]);
    assert!(shown.contains("[scene]\nname = \"fig2\""), "{shown}");
    // What is shown can be saved, changed and judged.
    std::fs::write(folder.path().join("mine.toml"), shown.replace("nx = 30", "nx = 10")).unwrap();
    let judged = done(folder.path(), &["check", "mine.toml"]);
    assert!(judged.contains("500 triangles") && judged.trim_end().ends_with("ok"), "{judged}");
    assert!(refused(folder.path(), &["scenes", "--show", "fig3"], 1).contains("did you mean `fig2"));
}

#[test]
fn errors_name_file_line_and_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let shown = done(folder.path(), &["scenes", "--show", "fig2"]);
    let bad = shown.replace("young_transverse = 1,", "young_transverse = -1,");
    let line = bad.lines().position(|l| l.contains("young_transverse = -1")).unwrap() + 1;
    std::fs::write(folder.path().join("bad.toml"), bad).unwrap();
    for command in ["check", "run"] {
        let error = refused(folder.path(), &[command, "bad.toml"], 1);
        assert!(error.contains(&format!("bad.toml:{line}:")), "{error}");
        assert!(
            error.contains("-1 MPa is not above zero") && error.contains("help: give a number above zero"),
            "{error}"
        );
    }
    let error = refused(folder.path(), &["run", "fig2-tera"], 1);
    assert!(error.contains("did you mean `fig2-tear`?"), "{error}");
    let error = refused(folder.path(), &["run", "fig2", "--set", "run.td=5"], 1);
    assert!(error.contains("--set run.td=5") && error.contains("valid keys here: mode, dt"), "{error}");
    let error = refused(folder.path(), &["check", "gone.toml"], 1);
    assert!(error.contains("gone.toml") && error.contains("cannot be read"), "{error}");
    std::fs::write(folder.path().join("file"), "").unwrap();
    let error = refused(folder.path(), &["run", "fig2", "--out", "file/inside"], 1);
    assert!(error.contains("cannot write file/inside") && error.contains("--out"), "{error}");
    assert!(!folder.path().join("out").exists(), "a refused scene writes nothing");
}

#[test]
fn a_run_that_cannot_go_on_says_so_and_leaves_what_it_had() {
    let folder = tempfile::tempdir().unwrap();
    // Without its holds the panel is a mechanism: no equilibrium.
    let arguments = ["run", "cook", "--out", "loose", "--set", "bodies.0.holds=[]", "--set", "output.pictures=0"];
    let output = rhexis(folder.path(), &arguments);
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stdout));
    assert!(text(&output.stderr).contains("no equilibrium"), "{}", text(&output.stderr));
    let report = json(&read(&folder.path().join("loose"), "report.json"));
    assert_eq!(report["end"]["state"], "failed");
    assert!(report["caveats"].to_string().contains("no equilibrium"), "{}", report["caveats"]);
}

/// A tube that is twisted by its ends: in pure shear half of the principal stresses are compressive.
#[test]
fn a_static_run_names_compression_of_a_membrane_without_bending() {
    let folder = tempfile::tempdir().unwrap();
    let (around, along) = (36, 40);
    let at = |i: usize| std::f64::consts::TAU * i as f64 / around as f64;
    let mut tube = String::new();
    for (z, i) in (0..=along).flat_map(|z| (0..around).map(move |i| (z, i))) {
        tube += &format!("v {} {} {z}\n", 5.0 * at(i).cos(), 5.0 * at(i).sin());
    }
    for (z, i) in (0..along).flat_map(|z| (0..around).map(move |i| (z, i))) {
        let (a, b) = (z * around + i + 1, z * around + (i + 1) % around + 1);
        tube += &format!("f {a} {b} {}\nf {a} {} {}\n", b + around, b + around, a + around);
    }
    std::fs::write(folder.path().join("tube.obj"), tube).unwrap();
    let scene = "[scene]\nname = \"torsion\"\n[run]\nmode = \"static\"\ndt = 1\nsteps = 1\n[output]\npictures = 0\nframes = 0\n\
        [[bodies]]\nname = \"tube\"\nmesh = { file = \"tube.obj\" }\nmaterial = { young = 1, poisson = 0.3, thickness = 0.1 }\n\
        [[bodies.holds]]\nname = \"foot\"\nregion = { z = 0 }\n\
        [[bodies.holds]]\nname = \"head\"\nregion = { z = 40 }\nrotate = [[0, [0, 0, 0]], [1, [0, 0, 1]]]\n";
    std::fs::write(folder.path().join("tube.toml"), scene).unwrap();
    let output = rhexis(folder.path(), &["run", "tube.toml"]);
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{error}");
    assert!(error.contains("2880 of 2880 triangles of body `tube` are in compression"), "{error}");
    assert!(error.contains("give it `bending = {}`"), "{error}");
    let output = rhexis(folder.path(), &["run", "tube.toml", "--out", "bending", "--set", "bodies.0.bending={}"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
}

#[test]
fn wrong_usage_is_code_2_and_help_shows_units_and_examples() {
    let folder = tempfile::tempdir().unwrap();
    for arguments in [&["run"][..], &["fly"], &["run", "fig2", "--steps", "many"], &[]] {
        refused(folder.path(), arguments, 2);
    }
    let error = refused(folder.path(), &["verify", "cok"], 2);
    assert!(error.contains("did you mean `cook`?"), "{error}");
    let help = done(folder.path(), &["run", "--help"]);
    assert!(help.contains("Examples:") && help.contains("[MPa]"), "{help}");
    assert!(done(folder.path(), &["--version"]).starts_with("rhexis "));
}

#[test]
fn a_run_whose_last_steps_failed_is_no_success() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["run", "fig2", "--out", "torn", "--steps", "2", "--set", "output.pictures=0"];
    // 1/dt² is no number any more.
    let output = rhexis(folder.path(), &[&arguments[..], &["--set", "run.dt=1e-300"]].concat());
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stdout));
    assert!(text(&output.stderr).contains("the last 2 step(s) left no usable state"), "{}", text(&output.stderr));
}

#[test]
fn a_second_run_leaves_no_pictures_of_the_first() {
    let folder = tempfile::tempdir().unwrap();
    let own = folder.path().join("o/picture.png");
    let count = |steps: &str| {
        let more = ["--set", "bodies.0.mesh.grid.nx=4", "--set", "bodies.0.mesh.grid.ny=4", "--quiet"];
        done(folder.path(), &[&["run", "fig2", "--out", "o", "--steps", steps][..], &more].concat());
        std::fs::write(&own, "mine").unwrap();
        let names = std::fs::read_dir(folder.path().join("o")).unwrap().map(|entry| entry.unwrap().file_name());
        names.filter(|name| name.to_string_lossy().contains("-0-")).count()
    };
    assert!(count("5") > count("1"));
    assert!(own.exists(), "a file of the user was taken away");
}

#[test]
fn what_cannot_be_written_is_said_before_the_run() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("file"), "").unwrap();
    for option in ["--out", "--dump"] {
        let error = refused(folder.path(), &["run", "fig2", "--steps", "1", option, "file"], 1);
        assert!(error.contains("file") && error.contains(option), "{error}");
    }
    refused(folder.path(), &["run", "fig2", "--steps", "2000000000"], 2);
}

#[test]
fn verification_prints_verdicts() {
    let folder = tempfile::tempdir().unwrap();
    let lines = done(folder.path(), &["verify", "constitutive"]);
    assert!(lines.contains("ok     constitutive") && lines.contains(" 0 failed"), "{lines}");
    let output = json(&done(folder.path(), &["verify", "constitutive", "--json"]));
    assert_eq!(output["passed"], true);
    assert!(output["rows"].as_array().unwrap().iter().all(|row| row["verdict"] != "FAILED"));
}

#[test]
fn a_reader_that_leaves_early_ends_the_program_quietly() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_rhexis"))
        .args(["scenes", "--show", "capsulorhexis"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(text(&output.stderr), "");
    assert_eq!(output.status.code(), Some(0));
}

#[test]
fn a_killed_run_resumes_to_the_same_results() {
    let folder = tempfile::tempdir().unwrap();
    fn run<'a>(more: &[&'a str]) -> Vec<&'a str> {
        let changes = ["--set", "run.steps=60", "--set", "output.pictures=0", "--set", "output.frames=4", "--quiet"];
        [&["run", "fig2-tear"], &changes[..], more].concat()
    }
    done(folder.path(), &run(&["--out", "whole", "--dump", "whole/dump"]));
    // As one that is killed in step 45: rows beyond its last snapshot, and half of one.
    done(folder.path(), &run(&["--out", "broken", "--steps", "45", "--snapshots", "20"]));
    let series = folder.path().join("broken/series.csv");
    let mut rows = std::fs::read_to_string(&series).unwrap();
    rows.push_str("46,460");
    std::fs::write(&series, rows).unwrap();
    done(folder.path(), &run(&["--out", "broken", "--resume", "--dump", "broken/dump", "--threads", "2"]));
    let names = ["series.csv", "events.jsonl", "dump/positions.csv", "dump/stresses.csv"];
    for name in names.into_iter().filter(|name| folder.path().join("whole").join(name).exists()) {
        let [whole, broken] = ["whole", "broken"].map(|out| read(&folder.path().join(out), name));
        // Frames of the shorter run fall on other steps: of these the list alone is compared below.
        assert!(whole == broken, "{name}");
    }
    let report = |out: &str| json(&read(&folder.path().join(out), "report.json"));
    let (whole, broken) = (report("whole"), report("broken"));
    for key in ["end", "steps", "simulated_ms", "bodies", "solver", "events", "ambiguous"] {
        assert_eq!(whole[key], broken[key], "{key}");
    }

    let error = refused(folder.path(), &run(&["--out", "broken", "--resume", "--set", "run.dt=5"]), 1);
    assert!(error.contains("another scene"), "{error}");
    let error = refused(folder.path(), &run(&["--out", "whole", "--resume"]), 1);
    assert!(error.contains("--snapshots"), "{error}");
    std::fs::write(folder.path().join("broken/run.snapshot"), "no state").unwrap();
    let error = refused(folder.path(), &run(&["--out", "broken", "--resume"]), 1);
    assert!(error.contains("run.snapshot: this is no state of a run"), "{error}");
}

#[test]
fn a_course_is_scored_and_a_resumed_one_alike() {
    let folder = tempfile::tempdir().unwrap();
    fn run<'a>(more: &[&'a str]) -> Vec<&'a str> {
        let few = ["--set", "bodies.0.mesh.cap.triangles=1500", "--set", "bodies.0.refinement.budget=3"];
        let quiet = ["--set", "output.pictures=0", "--set", "output.frames=0"];
        [&["run", "capsulorhexis"], &few[..], &quiet, more].concat()
    }
    let summary = done(folder.path(), &run(&["--out", "whole", "--steps", "130"]));
    assert!(summary.contains("of 100 (pass at 80): diameter 0, "), "{summary}");
    assert!(summary.contains("mN·s above the limit") && summary.contains("tremor"), "{summary}");
    done(folder.path(), &run(&["--out", "broken", "--steps", "115", "--snapshots", "50", "--quiet"]));
    done(folder.path(), &run(&["--out", "broken", "--steps", "130", "--resume", "--quiet"]));
    let course = |out: &str| json(&read(&folder.path().join(out), "report.json"))["bodies"][0]["course"].clone();
    let whole = course("whole");
    assert_eq!(whole, course("broken"));

    let score = &whole["score"];
    assert_eq!((score["pass"].as_f64(), score["is_passed"].as_bool()), (Some(80.0), Some(false)));
    let row = |key: &str| score["measures"].as_array().unwrap().iter().find(|row| row["key"] == key).unwrap();
    assert_eq!(row("diameter_mm")["missing"], "the tear has not closed");
    for key in ["tremor_mm", "tool_path_mm", "force_rms_n", "grasps"] {
        assert_eq!(row(key)["value"].as_f64(), whole[key].as_f64(), "{key}");
        assert!(row(key)["value"].as_f64().unwrap() > 0.0, "{key}");
    }

    let scored = ["--set", "output.scoring=mine.toml"];
    let error = refused(folder.path(), &run(&scored), 1);
    assert!(error.contains("cannot read mine.toml") && error.contains("give \"capsulorhexis\""), "{error}");
    std::fs::write(folder.path().join("mine.toml"), "[limits]\nforce = 9e-3\n").unwrap();
    let error = refused(folder.path(), &run(&scored), 1);
    assert!(error.contains("mine.toml:2:1: unknown key `force`") && error.contains("`force_n`"), "{error}");
}

#[test]
fn a_recorded_run_is_replayed() {
    let folder = tempfile::tempdir().unwrap();
    done(folder.path(), &["run", "fig2-tear", "--steps", "12", "--quiet", "--record", "tear.rec"]);
    let told = done(folder.path(), &["replay", "tear.rec"]);
    assert!(told.contains("12 of them steps") && told.contains("the same hash"), "{told}");
    let error = refused(folder.path(), &["replay", "out/fig2-tear/series.csv"], 1);
    assert!(error.contains("this is no recording"), "{error}");
}

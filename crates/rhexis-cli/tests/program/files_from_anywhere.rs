//! What a user names may be a device, a pipe, a directory or a file without end: an error, before it is read; and names may look like
//! those of others.
#![cfg(unix)]

use rhexis::internal::source::Sources;
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::sync::Arc;

fn rhexis(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rhexis"));
    command.current_dir(folder).args(arguments).stdin(Stdio::null()).output().unwrap()
}

fn refused(folder: &Path, arguments: &[&str]) -> String {
    let output = rhexis(folder, arguments);
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{arguments:?}: {error}");
    assert!(!error.contains("panicked"), "{error}");
    error
}

const SCENE: &str = "[scene]\nname = \"s\"\n[run]\ndt = 5\nsteps = 1\n[output]\npictures = 0\nframes = 0\n";
const MATERIAL: &str = "material = { young = 1, poisson = 0.3, thickness = 0.1 }\n";
const GRID: &str = "mesh = { grid = { width = 6, height = 5, nx = 2, ny = 2 } }\n";

#[test]
fn what_never_ends_is_not_begun() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    for name in ["zero.toml", "zero.obj", "zero.txt", "zero.rec", "zero.csv"] {
        std::os::unix::fs::symlink("/dev/zero", at(name)).unwrap();
    }
    for name in ["pipe.toml", "pipe.obj", "pipe.rec", "pipe.csv"] {
        assert!(Command::new("mkfifo").arg(at(name)).status().unwrap().success());
    }
    // A hole of a terabyte takes no room on the disk.
    for name in ["hole.toml", "hole.obj", "hole.txt", "hole.rec", "hole.csv"] {
        std::fs::File::create(at(name)).unwrap().set_len(1 << 40).unwrap();
    }
    std::fs::create_dir(at("folder.toml")).unwrap();
    std::fs::write(at("good.csv"), "").unwrap();
    let regular = "regular file";
    for (name, told) in [
        ("zero.toml", regular),
        ("pipe.toml", regular),
        ("folder.toml", regular),
        ("/dev/zero", regular),
        ("hole.toml", "larger than the 16 MB"),
    ] {
        for command in ["check", "run"] {
            let error = refused(folder.path(), &[command, name]);
            assert!(error.contains(name) && error.contains(told), "{error}");
        }
    }
    for (name, told) in [("zero", regular), ("pipe", regular), ("hole", "larger than the 8192 MB")] {
        let error = refused(folder.path(), &["replay", &format!("{name}.rec")]);
        assert!(error.contains(&format!("{name}.rec")) && error.contains(told), "{error}");
    }
    for (name, told) in [("zero", regular), ("pipe", regular), ("hole", "larger than the 64 MB")] {
        let error = refused(folder.path(), &["bench", "compare", &format!("{name}.csv"), "good.csv"]);
        assert!(error.contains(&format!("{name}.csv")) && error.contains(told), "{error}");
    }
    for (lines, told) in [
        ("mesh = { file = \"zero.obj\" }", "zero.obj: not a regular file"),
        ("mesh = { file = \"pipe.obj\" }", "pipe.obj: not a regular file"),
        ("mesh = { file = \"hole.obj\" }", "hole.obj: it is larger than the 1024 MB"),
        (&format!("{GRID}fibres = {{ file = \"zero.txt\" }}"), "zero.txt: not a regular file"),
        (&format!("{GRID}fibres = {{ file = \"hole.txt\" }}"), "hole.txt: it is larger than the 1024 MB"),
    ] {
        std::fs::write(at("s.toml"), format!("{SCENE}[[bodies]]\nname = \"b\"\n{MATERIAL}{lines}\n")).unwrap();
        let error = refused(folder.path(), &["check", "s.toml"]);
        let line = 12 + usize::from(lines.contains("fibres"));
        assert!(error.contains(told) && error.contains(&format!("s.toml:{line}:")), "{error}");
    }
}

/// Makes a run of a grid in the directory `o`, with the scene in `s.toml`.
fn run_of_grid(folder: &Path) {
    let body = format!("[[bodies]]\nname = \"b\"\n{MATERIAL}{GRID}");
    std::fs::write(folder.join("s.toml"), [SCENE, &body].concat().replace("= 0\n", "= 1\n")).unwrap();
    let done = rhexis(folder, &["run", "s.toml", "--out", "o", "--snapshots", "1", "--quiet"]);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
}

/// Files of a run or a sweep may have been put there by others.
#[test]
fn what_never_ends_is_not_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    run_of_grid(folder.path());
    std::fs::write(at("sweep.toml"), "scene = \"s.toml\"\n[vary]\n\"run.dt\" = [5]\n").unwrap();
    std::fs::create_dir(at("w")).unwrap();
    for (file, commands) in [
        ("o/report.json", &[&["report", "o"][..]][..]),
        ("o/series.csv", &[&["report", "o"], &["plot", "o"]]),
        ("o/events.jsonl", &[&["report", "o"]]),
        ("o/picture-0-000001.png", &[&["report", "o"]]),
        ("o/frames.pvd", &[&["render", "o"]]),
        ("w/cases.jsonl", &[&["sweep", "sweep.toml", "--out", "w"], &["sweep", "sweep.toml", "--out", "w", "--list"]]),
    ] {
        let kept = std::fs::read(at(file)).unwrap_or_default();
        for kind in ["device", "pipe", "hole"] {
            let _ = std::fs::remove_file(at(file));
            match kind {
                "device" => std::os::unix::fs::symlink("/dev/zero", at(file)).unwrap(),
                "pipe" => assert!(Command::new("mkfifo").arg(at(file)).status().unwrap().success()),
                _ => std::fs::File::create(at(file)).unwrap().set_len(1 << 40).unwrap(),
            }
            let told = if kind == "hole" { "it is larger than the 1024 MB" } else { "not a regular file" };
            for command in commands {
                let error = refused(folder.path(), command);
                assert!(error.contains(file) && error.contains(told), "{command:?}, {kind}: {error}");
            }
        }
        std::fs::remove_file(at(file)).unwrap();
        std::fs::write(at(file), kept).unwrap();
    }
}

/// Bytes of a name or a file that a terminal would obey.
#[test]
fn nothing_of_a_file_commands_a_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let bad = "\u{1b}]0;title\u{7}\u{1b}[31m\u{9b}2J\r\u{202e}";
    let named = bad.chars().map(|c| format!("\\u{:04x}", u32::from(c))).collect::<String>();
    let hold = format!("holds = [{{ name = \"h{named}\", region = {{ x = 0 }} }}]\n");
    let scene = format!("{SCENE}[[bodies]]\nname = \"b{named}\"\n{MATERIAL}{GRID}{hold}");
    std::fs::write(at("s.toml"), scene.replace("name = \"s\"", &format!("name = \"s{named}\""))).unwrap();
    let mesh = |name: &str| format!("{SCENE}[[bodies]]\nname = \"b\"\n{MATERIAL}mesh = {{ file = \"{name}\" }}\n");
    let line = bad.replace('\r', "");
    std::fs::write(at("a.msh"), format!("$MeshFormat\n{line}2 0 8\n$EndMeshFormat\n")).unwrap();
    std::fs::write(at("a.ply"), format!("ply\nformat ascii 1.0\nelement {line}vertex 4\nend_header\n")).unwrap();
    std::fs::write(at("m.toml"), mesh("a.msh")).unwrap();
    std::fs::write(at("p.toml"), mesh("a.ply")).unwrap();
    std::fs::write(at("n.toml"), mesh(&format!("{named}.obj"))).unwrap();
    std::fs::create_dir(at("o")).unwrap();
    std::fs::write(at("o/series.csv"), format!("time_ms,{line}\n0,0\n1,5\n")).unwrap();
    let plain = |c: char| c == '\n' || c == '\t' || !c.is_control() && c != '\u{202e}';
    for command in [
        &["check", "s.toml"][..],
        &["run", "s.toml", "--timings"],
        &["run", "s.toml", "--json"],
        &["check", "m.toml"],
        &["check", "p.toml"],
        &["check", "n.toml"],
        &["check", &format!("{bad}.toml")],
        &["check", "s.toml", bad],
        &["check", "s.toml", "--set", &format!("run.{bad}=1")],
        &["plot", "o", "--y", "none"],
    ] {
        let output = rhexis(folder.path(), command);
        let [out, error] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
        assert!(out.chars().chain(error.chars()).all(plain), "{command:?}: {out:?} {error:?}");
        // The parser of arguments leaves them out.
        let is_shown = [out, error].concat().contains("\\u001b");
        assert!(is_shown || command.contains(&bad), "{command:?} shows where it was");
    }
    // Marks of direction break no line: names keep them, where nobody prints them.
    let scene = format!("{SCENE}[[bodies]]\nname = \"b\\u202e\"\n{MATERIAL}{GRID}");
    std::fs::write(at("t.toml"), scene).unwrap();
    let output = rhexis(folder.path(), &["run", "t.toml", "--json"]);
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["bodies"][0]["name"], "b\u{202e}", "JSON says what it said");
}

#[test]
fn a_picture_or_a_page_takes_no_other_files_place() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    run_of_grid(folder.path());
    std::os::unix::fs::symlink("o/series.csv", at("link.html")).unwrap();
    for name in ["s.toml", "o/series.csv", "o/report.json", "o/picture-0-000001.png", "link.html"] {
        let before = std::fs::read(at(name)).unwrap();
        let error = refused(folder.path(), &["report", "o", "--out", name]);
        assert!(error.contains(name) && error.contains("no page") && error.contains("--out"), "{error}");
        if !name.ends_with(".png") {
            let error = refused(folder.path(), &["render", "o", "--out", name]);
            assert!(error.contains(name) && error.contains("no picture") && error.contains("--out"), "{error}");
        }
        assert!(std::fs::read(at(name)).unwrap() == before, "{name}");
    }
    // A page of before is renewed, and so is a picture.
    for command in [["report", "o"], ["render", "o"]] {
        for _ in 0..2 {
            let output = rhexis(folder.path(), &command);
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        }
    }
}

#[test]
fn a_page_has_no_markup_of_names() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let body = format!("[[bodies]]\nname = \"b<svg onload=a()>\"\n{MATERIAL}{GRID}");
    let hold = "holds = [{ name = \"</text><script>a()</script>\", region = { x = 0 } }]\n";
    std::fs::write(at("s.toml"), [SCENE, &body, hold].concat()).unwrap();
    let made = rhexis(folder.path(), &["run", "s.toml", "--out", "o", "--quiet"]);
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    std::fs::write(at("o/picture-0-\"><img src=x onerror='a()'>.png"), "").unwrap();
    assert!(rhexis(folder.path(), &["report", "o"]).status.success());
    let html = std::fs::read_to_string(at("o/report.html")).unwrap();
    for markup in ["<script", "<svg onload", "<img src", "onerror='"] {
        assert!(!html.contains(markup), "{markup}");
    }
    assert!(html.contains("&lt;img src=x"));
}

/// The option is named that was given.
#[test]
fn too_many_threads_are_wrong_usage() {
    let folder = tempfile::tempdir().unwrap();
    let output = rhexis(folder.path(), &["run", "fig2", "--steps", "1", "--threads", "99999999"]);
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(error.contains("--threads") && error.contains("at most 1024") && !error.contains("--set"), "{error}");
}

/// `a/b/x` is hold `b/x` of body `a`, or hold `x` of body `a/b`.
#[test]
fn a_body_has_the_forces_of_its_own_holds() {
    let folder = tempfile::tempdir().unwrap();
    let body = |name: &str, hold: &str| {
        format!(
            "[[bodies]]\nname = \"{name}\"\n{MATERIAL}{GRID}holds = [{{ name = \"{hold}\", region = {{ x = 0 }} }}]\n"
        )
    };
    let text = [SCENE, &body("a", "c"), &body("a/b", "d"), &body("a/b/e", "f")].concat();
    std::fs::write(folder.path().join("s.toml"), text).unwrap();
    let output = rhexis(folder.path(), &["run", "s.toml", "--json", "--quiet"]);
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let names = report["bodies"].as_array().unwrap().iter().map(|body| body["reactions"].as_array().unwrap());
    let names: Vec<Vec<&str>> = names.map(|list| list.iter().map(|r| r["name"].as_str().unwrap()).collect()).collect();
    assert_eq!(names, [["c"], ["d"], ["f"]]);
}

/// Frames have velocities and forces where the scene asks for them.
#[test]
fn frames_have_what_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let holds = "holds = [{ name = \"l\", region = { x = 0 } }, { name = \"r\", region = { x = 6 }, move = { offset = [1, 0] }, \
                 curve = [[0, 0], [5, 1]] }]\n";
    let text = format!("{SCENE}[[bodies]]\nname = \"b\"\n{MATERIAL}{GRID}{holds}").replace("frames = 0", "frames = 2");
    std::fs::write(folder.path().join("s.toml"), text).unwrap();
    let frame = |more: &[&str]| {
        let output = rhexis(folder.path(), &[&["run", "s.toml", "--quiet"], more].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        rhexis_cli::output::read_vtu(&folder.path().join("out/s/frames-0-b-000001.vtu")).unwrap()
    };
    let plain = frame(&[]);
    assert!(plain.velocities.is_empty() && plain.forces.is_empty(), "nobody asked for them");
    let both = frame(&["--set", "output.velocities=true", "--set", "output.forces=true"]);
    // Vertex 2 lies at the right end, which goes 1 mm in 5 ms; the tissue pulls it back.
    assert!((both.velocities[2].x - 0.2).abs() < 1e-12, "{}", both.velocities[2]);
    assert!(both.forces[2].x < 0.0, "{}", both.forces[2]);
    // Elastic forces add up to none: to rounding, of 9 vertices.
    let sum: f64 = both.forces.iter().map(|force| force.x).sum();
    let size: f64 = both.forces.iter().map(|force| force.x.abs()).sum();
    assert!(sum.abs() < 1e-14 * size, "{sum} of {size}");
    assert!(frame(&["--set", "output.velocities=true"]).forces.is_empty());
}

#[test]
fn files_are_read_once_and_within_one_sum() {
    let folder = tempfile::tempdir().unwrap();
    let [a, b] = ["a", "b"].map(|name| folder.path().join(name));
    std::fs::write(&a, vec![1; 3 << 20]).unwrap();
    std::fs::write(&b, vec![2; 2 << 20]).unwrap();
    let sources = Sources::new(4 << 20);
    let first = sources.read(&a, 3 << 20).unwrap();
    std::fs::remove_file(&a).unwrap();
    assert!(Arc::ptr_eq(&first, &sources.read(&a, 3 << 20).unwrap()), "read once");
    let refused = sources.read(&b, 4 << 20).unwrap_err().to_string();
    assert_eq!(refused, "the files together are larger than the 4 MB that are read");
    assert!(sources.read(&b, 1 << 20).unwrap_err().to_string().contains("larger than the 1 MB"));
    assert_eq!(Sources::new(2 << 20).read(&b, 2 << 20).unwrap().len(), 2 << 20);
}

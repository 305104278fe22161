//! What a user names may be a device, a pipe, a directory or a file without end: an error, before it is read; and names may look like
//! those of others.
#![cfg(unix)]

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output, Stdio};

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

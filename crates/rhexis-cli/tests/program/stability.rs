//! `rhexis stability`: the map of a few cases, printed, written and drawn.

use std::process::{Command, Stdio};

#[test]
fn the_quick_map_is_printed_written_and_drawn_and_the_default_step_is_stable_on_it() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["stability", "--quick", "--out", "map"];
    let mut command = Command::new(env!("CARGO_BIN_EXE_rhexis"));
    let output = command.current_dir(folder.path()).args(arguments).stdin(Stdio::null()).output().unwrap();
    let (printed, errors) = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap()).into();
    assert!(output.status.success(), "{errors}");
    let read = |name: &str| std::fs::read(folder.path().join("map").join(name)).unwrap();
    for name in ["stability", "stability-energy"] {
        assert!(read(&format!("{name}.png")).starts_with(b"\x89PNG"));
        assert!(String::from_utf8(read(&format!("{name}.svg"))).unwrap().contains("textbook"));
    }
    let csv = String::from_utf8(read("stability.csv")).unwrap();
    let rows: Vec<&str> = csv.lines().filter(|line| !line.starts_with('#')).skip(1).collect();
    // Three modes, two time steps, two rotation speeds, two meshes.
    assert_eq!(rows.len(), 24, "{csv}");
    let of = |mode: &str, grade: &str| rows.iter().filter(|row| row.starts_with(mode) && row.contains(grade)).count();
    assert_eq!(of("default", "unstable"), 0, "{printed}");
    assert!(printed.contains("default") && printed.contains("slivers, pressed by 0.2"), "{printed}");
}

#[test]
fn what_many_steps_add_up_to_is_a_table() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["stability", "--drift", "--steps", "20", "--out", "drift"];
    let mut command = Command::new(env!("CARGO_BIN_EXE_rhexis"));
    let output = command.current_dir(folder.path()).args(arguments).stdin(Stdio::null()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let csv = std::fs::read_to_string(folder.path().join("drift/stability-drift.csv")).unwrap();
    let rows: Vec<&str> = csv.lines().filter(|line| !line.starts_with('#')).skip(1).collect();
    // Three modes, three sheets, four time steps.
    assert_eq!(rows.len(), 36, "{csv}");
    assert!(!csv.contains("unstable"), "{csv}");
}

//! `--dump`: forces, velocities and what the criterion says at a tip that rests.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Stdio};

type Row = BTreeMap<String, String>;

fn rows(path: &Path) -> Vec<Row> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    reader.deserialize().map(|row| row.unwrap()).collect()
}

fn number(row: &Row, name: &str) -> f64 {
    row[name].parse().unwrap_or_else(|e| panic!("{name}: {e}: {row:?}"))
}

fn vector(row: &Row, name: &str) -> [f64; 3] {
    ["x", "y", "z"].map(|axis| number(row, &name.replace("{}", axis)))
}

/// Runs and dumps.
fn dump(arguments: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_rhexis"));
    command.current_dir(folder.path()).args(["run", "fig2-tear", "--quiet", "--dump", "."]).args(arguments);
    command.args(["--set", "output.pictures=0", "--set", "output.frames=0"]);
    let output = command.stdin(Stdio::null()).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    folder
}

#[test]
fn a_tip_at_rest_shows_stress_direction_and_decider() {
    let folder = dump(&["--steps", "5"]);
    let tips = rows(&folder.path().join("tips.csv"));
    let [tip] = &tips[..] else { panic!("{tips:?}") };
    assert_eq!(tip["decided_by"], "stress");
    assert_eq!(vector(tip, "rest_{}_mm"), [15.0, 27.0, 0.0], "the end of the notch");
    let criterion = number(tip, "criterion");
    assert!(criterion > 0.0 && criterion < 1.0, "it does not advance: {criterion}");
    let direction = vector(tip, "direction_{}");
    let length: f64 = direction.iter().map(|x| x * x).sum();
    assert!((length - 1.0).abs() < 1e-12, "{direction:?}");
    assert!(number(tip, "xx_MPa") > number(tip, "yy_MPa"), "pulled along x: {tip:?}");
    // The vertex is the one of `vertices.csv` and `positions.csv`.
    let positions = rows(&folder.path().join("positions.csv"));
    let place = positions.iter().find(|row| row["vertex"] == tip["vertex"]).unwrap();
    assert_eq!(vector(place, "{}_mm"), vector(tip, "{}_mm"));
}

#[test]
fn a_decision_by_the_material_force_says_why() {
    let criterion = "bodies.0.energy_criterion={ toughness_along_fibres = 1e-3, toughness_across_fibres = 2e-3 }";
    let folder = dump(&["--steps", "5", "--set", criterion]);
    let tips = rows(&folder.path().join("tips.csv"));
    // The notch is as long as two averaging radii: the disc is not around its crack alone.
    assert!(
        tips.len() == 1 && tips[0]["decided_by"].starts_with("energy by the material force: the ring "),
        "{tips:?}"
    );
}

#[test]
fn forces_of_vertices_balance_the_reactions() {
    let folder = dump(&["--steps", "1", "--set", "run.mode=static"]);
    let [vertices, positions, reactions] =
        ["vertices.csv", "positions.csv", "reactions.csv"].map(|name| rows(&folder.path().join(name)));
    assert_eq!(vertices.len(), positions.len());
    let mut left = [0.0; 3];
    let reaction = reactions.iter().find(|row| row["hold"] == "square/left").unwrap();
    let reaction = ["x_N", "y_N", "z_N"].map(|name| number(reaction, name));
    for (vertex, place) in vertices.iter().zip(&positions) {
        let force = vector(vertex, "elastic_{}_N");
        let x = number(place, "rest_x_mm");
        if x == 0.0 {
            (0..3).for_each(|i| left[i] += force[i]);
        } else if x < 30.0 {
            // Free vertices are in equilibrium, to 1e-9 of the largest corner force, which is below the reaction.
            assert!(force.iter().all(|f| f.abs() < 1e-8 * reaction[0].abs()), "{vertex:?}");
        }
        assert_eq!(vector(vertex, "velocity_{}_mm_per_ms"), [0.0; 3]);
    }
    assert!(reaction[0] < 0.0, "{reaction:?}");
    (0..3).for_each(|i| assert!((left[i] + reaction[i]).abs() < 1e-8 * reaction[0].abs(), "{left:?} {reaction:?}"));

    let folder = dump(&["--steps", "5"]);
    let vertices = rows(&folder.path().join("vertices.csv"));
    let momentum = |axis: &str| -> f64 {
        vertices.iter().map(|v| number(v, "mass_g") * number(v, &format!("velocity_{axis}_mm_per_ms"))).sum()
    };
    assert!(momentum("x") != 0.0);
    // The membrane's forces are inner forces: they add up to nothing but for rounding.
    let sum: f64 = vertices.iter().map(|v| number(v, "elastic_x_N")).sum();
    let largest = vertices.iter().map(|v| number(v, "elastic_x_N").abs()).fold(0.0, f64::max);
    assert!(largest > 0.0 && sum.abs() < 1e-12 * largest * vertices.len() as f64, "{sum} {largest}");
    assert!(vertices.iter().all(|v| v["solved_x_N"].parse::<f64>().is_ok()));
}

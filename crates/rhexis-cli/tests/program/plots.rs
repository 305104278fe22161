//! Curves and pages of runs, as a user makes them.

use std::path::Path;
use std::process::{Command, Output};

fn rhexis(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_rhexis")).current_dir(folder).args(arguments).output().unwrap()
}

fn words(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn a_run_is_drawn_and_told_on_one_page() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let run =
        ["run", "fig2-tear", "--steps", "30", "--quiet", "--set", "output.pictures=2", "--set", "output.frames=0"];
    for out in ["a", "b"] {
        let made = rhexis(folder, &[&run[..], &["--out", out]].concat());
        assert!(made.status.success(), "{}", words(&made.stderr));
    }
    let drawn = rhexis(folder, &["plot", "a"]);
    assert!(drawn.status.success(), "{}", words(&drawn.stderr));
    for name in ["forces", "energies", "tear-length", "criterion", "iterations"] {
        let svg = std::fs::read_to_string(folder.join(format!("a/plots/{name}.svg"))).unwrap();
        assert!(svg.contains("time [ms]"), "{name}");
        assert!(std::fs::read(folder.join(format!("a/plots/{name}.png"))).unwrap().starts_with(b"\x89PNG"));
    }
    let both = rhexis(folder, &["plot", "a", "b", "--y", "tear_length_mm", "--out", "both"]);
    assert!(both.status.success(), "{}", words(&both.stderr));
    let svg = std::fs::read_to_string(folder.join("both/tear-length-mm.svg")).unwrap();
    assert!(svg.contains("a: tear_length_mm") && svg.contains("b: tear_length_mm"));
    let page = rhexis(folder, &["report", "a"]);
    assert!(page.status.success(), "{}", words(&page.stderr));
    let html = std::fs::read_to_string(folder.join("a/report.html")).unwrap();
    // Pictures and curves are inside it, and nothing of it is elsewhere.
    assert!(html.matches("data:image/png;base64,").count() >= 2 && html.matches("<svg").count() == 5);
    assert!(!html.contains("src=\"http") && !html.contains("<script") && !html.contains("<link"));
}

#[test]
fn what_is_no_run_or_no_column_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for command in ["plot", "report"] {
        let refused = rhexis(folder, &[command, "nowhere"]);
        let error = words(&refused.stderr);
        assert!(
            refused.status.code() == Some(1) && error.contains("nowhere") && error.contains("rhexis run"),
            "{error}"
        );
    }
    std::fs::create_dir(folder.join("run")).unwrap();
    std::fs::write(folder.join("run/series.csv"), "step,time_ms\n0,0\n1,5\n").unwrap();
    let refused = rhexis(folder, &["plot", "run", "--y", "tear"]);
    let error = words(&refused.stderr);
    assert!(error.contains("no column `tear`") && error.contains("step, time_ms"), "{error}");
}

#[test]
fn the_plot_of_forces_tells_the_mean_while_it_tears_and_before_advances() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::create_dir(folder.join("run")).unwrap();
    let names = "time_ms,iterations,elastic_mJ,kinetic_mJ,tear_length_mm,max_criterion,advances,sheet/hand_x_N,sheet/hand_y_N,sheet/hand_z_N";
    let forces = [(0.004, 0), (0.001, 1), (0.003, 0), (0.005, 0), (0.001, 1), (0.009, 0)];
    let rows =
        forces.iter().enumerate().map(|(row, (force, advances))| format!("{row},1,0,0,0,0,{advances},0,{force},0"));
    let rows: Vec<String> = std::iter::once(names.to_owned()).chain(rows).collect();
    std::fs::write(folder.join("run/series.csv"), rows.join("\n")).unwrap();
    let drawn = rhexis(folder, &["plot", "run"]);
    assert!(drawn.status.success(), "{}", words(&drawn.stderr));
    let svg = std::fs::read_to_string(folder.join("run/plots/forces.svg")).unwrap();
    assert!(svg.contains("sheet/hand: while it tears 3.000 mN, before advances 5.000"), "{svg}");
    // A dot where each of the two advances was decided.
    assert_eq!(svg.matches("<circle").count(), 2);
}

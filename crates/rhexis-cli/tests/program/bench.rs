//! `rhexis bench` in its quick form: files, columns, and errors that fall with the tolerance. No time is judged.

use std::path::Path;
use std::process::{Command, Output, Stdio};

fn bench(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rhexis"));
    command.current_dir(folder).arg("bench").args(arguments).stdin(Stdio::null()).output().unwrap()
}

fn done(folder: &Path, arguments: &[&str]) -> String {
    let output = bench(folder, arguments);
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {error}");
    String::from_utf8(output.stdout).unwrap()
}

/// The columns of a table that was written, and its rows.
struct Table {
    columns: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    fn read(folder: &Path, name: &str) -> Self {
        let path = folder.join("out/bench").join(format!("{name}.csv"));
        let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let speed = |key: &str| {
            let line = text.lines().find_map(|line| line.strip_prefix(key)).unwrap_or_else(|| panic!("{key}: {text}"));
            line.trim().parse::<f64>().unwrap()
        };
        // The slowest processor with a chance to run this, and far more than the fastest has.
        assert!((0.5..5000.0).contains(&speed("# fma_gflops")) && (0.2..2000.0).contains(&speed("# triad_gbs")));
        let fields = |line: &str| line.split(',').map(str::to_owned).collect::<Vec<String>>();
        let mut rows = text.lines().filter(|line| !line.starts_with('#')).map(fields);
        Self { columns: rows.next().unwrap(), rows: rows.collect() }
    }

    fn column(&self, name: &str) -> usize {
        self.columns.iter().position(|column| column == name).unwrap_or_else(|| panic!("{name}: {:?}", self.columns))
    }

    /// The figures of a column in the rows in which another one has this value.
    fn figures(&self, name: &str, (key, value): (&str, &str)) -> Vec<f64> {
        let (name, key) = (self.column(name), self.column(key));
        let rows = self.rows.iter().filter(|row| row[key] == value);
        rows.map(|row| row[name].parse().unwrap_or_else(|_| panic!("{row:?}"))).collect()
    }
}

#[test]
fn errors_fall_with_the_tolerance_and_plots_are_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let printed = done(folder.path(), &["work-precision", "--quick", "fig2-haptic", "fig2-static"]);
    assert!(printed.contains("the default is on") || printed.contains("the default is off"), "{printed}");
    for (case, least) in [("fig2-haptic", 1e-2), ("fig2-static", 1e-6)] {
        let table = Table::read(folder.path(), &format!("work-precision-{case}-solvers"));
        let errors = table.figures("stress_error", ("setting", "block Jacobi"));
        // Each tolerance is ten or more times the next; a solve may go on to the same iteration for two of them.
        assert!(errors.len() == 6 && errors.windows(2).all(|pair| pair[1] <= pair[0]), "{case}: {errors:?}");
        assert!(errors[5] < least * errors[0], "{case}: {errors:?}");
        assert!(table.figures("median_ms", ("setting", "block Jacobi")).iter().all(|&ms| ms > 0.0));
        assert_eq!(table.figures("tolerance", ("is_default", "true")).len(), 1);
        let finer = Table::read(folder.path(), &format!("work-precision-{case}-discretisation"));
        // The mesh of the paper is several per cent off any finer one.
        assert!(
            finer.figures("stress_error", ("is_default", "true")).iter().all(|&error| (0.01..0.3).contains(&error))
        );
        for kind in ["svg", "png"] {
            for name in [format!("{case}-solvers-1500"), format!("{case}-discretisation")] {
                let path = folder.path().join(format!("out/bench/work-precision-{name}.{kind}"));
                assert!(path.metadata().is_ok_and(|file| file.len() > 1000), "{}", path.display());
            }
        }
    }
}

#[test]
fn the_torn_capsule_is_judged_step_by_step() {
    let folder = tempfile::tempdir().unwrap();
    done(folder.path(), &["work-precision", "--quick", "capsulorhexis"]);
    let table = Table::read(folder.path(), "work-precision-capsulorhexis-solvers");
    let errors = table.figures("stress_error", ("setting", "block Jacobi"));
    assert!(errors.len() == 6 && errors[5] < 1e-2 * errors[0], "{errors:?}");
}

#[test]
fn the_other_benchmarks_leave_their_tables() {
    let folder = tempfile::tempdir().unwrap();
    done(folder.path(), &["systems", "--quick", "--threads", "1"]);
    let systems = Table::read(folder.path(), "systems");
    assert_eq!(systems.figures("median_ms", ("system", "solve")).len(), 3);
    let steps = Table::read(folder.path(), "steps");
    // Positions, velocities, rest data, topology: a body cannot do with less, and must not take more than a few kB.
    let bytes = steps.figures("bytes_per_triangle", ("threads", "1"));
    assert!(bytes.iter().all(|bytes| (300.0..5000.0).contains(bytes)), "{bytes:?}");

    done(folder.path(), &["ladder", "--quick"]);
    let ladder = Table::read(folder.path(), "ladder");
    for solver in ["block Jacobi", "incomplete Cholesky"] {
        // Three states at three tolerances each.
        let errors = ladder.figures("stress_error", ("solver", solver));
        assert!(errors.len() == 9 && errors.chunks(3).all(|state| state[2] < state[0]), "{errors:?}");
    }

    done(folder.path(), &["textbook", "--quick"]);
    let errors = Table::read(folder.path(), "textbook").figures("stress_error", ("triangles", "1500"));
    assert!(errors.len() == 2 && errors.iter().all(|&error| error <= 1e-3), "{errors:?}");

    let printed = done(folder.path(), &["targets", "--quick"]);
    assert!(printed.contains("haptic 1.5k, 1 %"), "{printed}");
    let targets = Table::read(folder.path(), "targets");
    assert!(targets.figures("stress_error", ("triangles", "1500")).iter().all(|&error| error <= 1e-2));

    done(folder.path(), &["ablation", "--quick", "--scene", "fig2-haptic", "--only", "multigrid", "--only", "guess"]);
    let ablation = Table::read(folder.path(), "ablation-fig2-haptic");
    let iterations = |row| ablation.figures("iterations", ("row", row))[0];
    assert!(iterations("initial guess") > iterations("everything on (auto)") && iterations("multigrid") > 0.0);
    assert!(ablation.figures("stress_error", ("scene", "fig2-haptic")).iter().all(|&error| error < 1e-2));

    let file = "out/bench/textbook.csv";
    let printed = done(folder.path(), &["compare", file, file]);
    assert!(printed.contains("0 better, 0 worse"), "{printed}");
}

#[test]
fn wrong_names_are_refused_with_the_right_ones() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, wanted) in [
        (vec!["work-precision", "fig2-hpatic"], "did you mean `fig2-haptic`?"),
        (vec!["targets", "--quick", "nothing"], "no target has `nothing`"),
        (vec!["ablation", "--scene", "fig2-hpatic"], "did you mean `fig2-haptic`?"),
        (vec!["ablation", "--only", "nothing"], "no row has `nothing`"),
        (vec!["systems", "--sizes", "3"], "50.."),
        (vec!["compare", "a.csv", "b.csv"], "a.csv"),
    ] {
        let output = bench(folder.path(), &arguments);
        let error = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code().is_some_and(|code| code > 0) && error.contains(wanted), "{arguments:?}: {error}");
    }
}

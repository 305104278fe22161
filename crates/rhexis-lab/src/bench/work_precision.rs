//! Work–precision: what meshes, solvers, tolerances, time steps and integrators cost, and the error that they leave.
//!
//! Two questions, each with a table and plots. *Solver*: on one mesh at one time step, which solver reaches an error soonest?
//! Reference: the same run solved tightly. *Discretisation*: what do meshes, time steps and integrators leave, with the default
//! solver? Reference: a finer mesh at a shorter step, each step iterated to the end.

use super::Depth::{self, Full, Quick, Usual};
use super::sweep::sweep;
use super::{BenchError, Context, Table};
use rhexis_scene::nearest;

/// A way to solve, by what it sets in the scene.
pub struct Setting {
    /// Name in tables and legends.
    pub name: &'static str,
    /// What it sets.
    pub sets: &'static [&'static str],
    /// Measured from this depth on.
    pub from: Depth,
}

/// A mesh of a case.
pub struct Mesh {
    /// What it sets.
    pub sets: &'static [&'static str],
    /// Measured from this depth on.
    pub from: Depth,
}

/// The times of a run that are measured \[ms\].
#[derive(Clone, Copy)]
pub struct Window {
    /// Not before; the settling in from rest, or the time until a tear begins.
    pub from: f64,
    /// The end.
    pub until: f64,
    /// The end of the quick run.
    pub until_quick: f64,
    /// Between the states that are compared.
    pub every: f64,
}

/// A scene, and what is varied in it.
pub struct Case {
    /// Name on the command line.
    pub name: &'static str,
    /// The catalog's scene.
    pub scene: &'static str,
    /// What is set in all its runs.
    pub sets: &'static [&'static str],
    /// Meshes, the scene's own first.
    pub meshes: &'static [Mesh],
    /// Mesh of the discretisation's reference.
    pub finest: &'static [&'static str],
    /// The key of the tolerance.
    pub tolerance: &'static str,
    /// Its values.
    pub tolerances: &'static [f64],
    /// The scene's own.
    pub default_tolerance: f64,
    /// That of the references.
    pub tight: f64,
    /// Ways to solve, the default first.
    pub settings: &'static [Setting],
    /// Time steps \[ms\], the scene's own first, the shortest last; one for a static case.
    pub time_steps: &'static [f64],
    /// What is measured.
    pub window: Window,
    /// Whether runs part whatever their tolerance, so that errors of solvers are those of single steps.
    pub is_chaotic: bool,
}

const fn setting(name: &'static str, sets: &'static [&'static str], from: Depth) -> Setting {
    Setting { name, sets, from }
}

const fn mesh(sets: &'static [&'static str], from: Depth) -> Mesh {
    Mesh { sets, from }
}

/// Solvers of dynamic steps.
const DYNAMIC: &[Setting] = &[
    setting("default (auto)", &[], Quick),
    setting("incomplete Cholesky", &["run.advanced.preconditioner=incomplete_cholesky"], Usual),
    setting("multigrid", &["run.advanced.preconditioner=multigrid"], Usual),
    setting("Cholesky", &["run.advanced.preconditioner=cholesky"], Usual),
    setting("block Jacobi", &["run.advanced.preconditioner=block_jacobi"], Quick),
    setting(
        "double, block Jacobi",
        &["run.advanced.preconditioner=block_jacobi", "run.advanced.precision=double"],
        Usual,
    ),
];

/// Solvers of static solves.
const STATIC: &[Setting] = &[
    setting("default (auto)", &[], Quick),
    setting("block Jacobi", &["run.advanced.preconditioner=block_jacobi"], Quick),
];

/// How a dynamic step is made of linear solves; the default first.
pub(super) const INTEGRATORS: &[Setting] = &[
    setting("linearly implicit", &[], Quick),
    setting("Newton to 1e-6", &["run.advanced.newton_iterations=20", "run.advanced.newton_tolerance=1e-6"], Usual),
];

const LINEAR: &str = "run.advanced.stress_tolerance";
const LINEAR_TOLERANCES: &[f64] = &[1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6];
const STATIC_TOLERANCES: &[f64] = &[1e-1, 1e-2, 1e-3, 1e-5, 1e-7, 1e-9];

/// Meshes of the square, each part of the finer ones.
const SQUARES: &[Mesh] = &[
    mesh(&["bodies.0.mesh.grid.nx=30", "bodies.0.mesh.grid.ny=25"], Quick),
    mesh(&["bodies.0.mesh.grid.nx=60", "bodies.0.mesh.grid.ny=50"], Usual),
    mesh(&["bodies.0.mesh.grid.nx=120", "bodies.0.mesh.grid.ny=100"], Full),
];
const FINEST_SQUARE: &[&str] = &["bodies.0.mesh.grid.nx=240", "bodies.0.mesh.grid.ny=200"];

/// The cases.
pub const SCENES: &[Case] = &[
    Case {
        name: "fig2-static",
        scene: "fig2",
        sets: &["run.mode=static", "run.steps=1", "run.dt=500"],
        meshes: SQUARES,
        finest: FINEST_SQUARE,
        tolerance: "run.advanced.static_tolerance",
        tolerances: STATIC_TOLERANCES,
        default_tolerance: 1e-9,
        tight: 1e-13,
        settings: STATIC,
        time_steps: &[500.0],
        window: Window { from: 0.0, until: 500.0, until_quick: 500.0, every: 500.0 },
        is_chaotic: false,
    },
    Case {
        name: "fig2-dynamic",
        scene: "fig2",
        sets: &["run.steps=100000"],
        meshes: SQUARES,
        finest: FINEST_SQUARE,
        tolerance: LINEAR,
        tolerances: LINEAR_TOLERANCES,
        default_tolerance: 1e-3,
        tight: 1e-10,
        settings: DYNAMIC,
        time_steps: &[10.0, 50.0, 20.0, 5.0],
        window: Window { from: 0.0, until: 600.0, until_quick: 200.0, every: 100.0 },
        is_chaotic: false,
    },
    Case {
        name: "fig2-haptic",
        scene: "fig2-haptic",
        sets: &["run.steps=100000"],
        meshes: SQUARES,
        finest: &["bodies.0.mesh.grid.nx=120", "bodies.0.mesh.grid.ny=100"],
        tolerance: LINEAR,
        tolerances: LINEAR_TOLERANCES,
        default_tolerance: 1e-3,
        tight: 1e-10,
        settings: DYNAMIC,
        time_steps: &[1.0, 5.0, 2.0, 0.5],
        window: Window { from: 40.0, until: 240.0, until_quick: 80.0, every: 20.0 },
        is_chaotic: false,
    },
    Case {
        name: "capsulorhexis",
        scene: "capsulorhexis",
        sets: &["run.duration=33000"],
        meshes: &[
            mesh(&["bodies.0.mesh.cap.triangles=5000"], Usual),
            mesh(&["bodies.0.mesh.cap.triangles=1500", "bodies.0.refinement.budget=3"], Quick),
        ],
        finest: &["bodies.0.mesh.cap.triangles=10000"],
        tolerance: LINEAR,
        tolerances: &[1e-1, 1e-2, 5e-3, 1e-3, 1e-4, 1e-5],
        default_tolerance: 5e-3,
        tight: 1e-8,
        settings: DYNAMIC,
        time_steps: &[20.0, 10.0, 5.0],
        window: Window { from: 1600.0, until: 2200.0, until_quick: 1700.0, every: 20.0 },
        is_chaotic: true,
    },
    Case {
        name: "cook",
        scene: "cook",
        sets: &[],
        meshes: &[
            mesh(&["bodies.0.mesh.quad.nx=32", "bodies.0.mesh.quad.ny=32"], Quick),
            mesh(&["bodies.0.mesh.quad.nx=16", "bodies.0.mesh.quad.ny=16"], Usual),
            mesh(&["bodies.0.mesh.quad.nx=64", "bodies.0.mesh.quad.ny=64"], Usual),
            mesh(&["bodies.0.mesh.quad.nx=128", "bodies.0.mesh.quad.ny=128"], Full),
        ],
        finest: &["bodies.0.mesh.quad.nx=256", "bodies.0.mesh.quad.ny=256"],
        tolerance: "run.advanced.static_tolerance",
        tolerances: STATIC_TOLERANCES,
        default_tolerance: 1e-9,
        tight: 1e-13,
        settings: STATIC,
        time_steps: &[1.0],
        window: Window { from: 0.0, until: 1.0, until_quick: 1.0, every: 1.0 },
        is_chaotic: false,
    },
    Case {
        name: "fig2-tear",
        scene: "fig2-tear",
        sets: &["run.steps=100000"],
        meshes: SQUARES,
        finest: &["bodies.0.mesh.grid.nx=120", "bodies.0.mesh.grid.ny=100"],
        tolerance: LINEAR,
        tolerances: LINEAR_TOLERANCES,
        default_tolerance: 1e-3,
        tight: 1e-10,
        settings: DYNAMIC,
        time_steps: &[10.0, 20.0, 5.0],
        window: Window { from: 0.0, until: 1000.0, until_quick: 500.0, every: 50.0 },
        is_chaotic: false,
    },
];

impl Case {
    /// The end of the run \[ms\].
    pub fn until(&self, depth: Depth) -> f64 {
        if depth == Quick { self.window.until_quick } else { self.window.until }
    }

    /// Whether it is a static case, which has neither time step nor integrator.
    pub fn is_static(&self) -> bool {
        self.time_steps.len() == 1
    }
}

/// Measures the cases of these names, or all: per case the table of solvers and that of the discretisation, with their plots.
///
/// # Errors
/// For a name that is none of them, and where a reference cannot be computed.
pub fn work_precision(context: &Context, names: &[String]) -> Result<Vec<Table>, BenchError> {
    let chosen = names.iter().map(|name| find(name)).collect::<Result<Vec<&Case>, _>>()?;
    let chosen = if chosen.is_empty() { SCENES.iter().collect() } else { chosen };
    let mut tables = Vec::new();
    for case in chosen {
        for table in sweep(context, case)? {
            // The next case may take an hour.
            table.write(&context.directory)?;
            tables.push(table);
        }
    }
    Ok(tables)
}

fn find(name: &str) -> Result<&'static Case, BenchError> {
    SCENES.iter().find(|case| case.name == name).ok_or_else(|| {
        let names: Vec<&str> = SCENES.iter().map(|case| case.name).collect();
        let near =
            nearest(name, names.iter().copied()).map_or(String::new(), |near| format!("did you mean `{near}`? "));
        BenchError::Unknown(format!(
            "no work–precision case `{name}`\n  help: {near}the cases are {}",
            names.join(", ")
        ))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `bindings/python` makes dictionaries of the rows by these names and forms.
    #[test]
    fn rows_are_keys_and_numbers() {
        let directory = tempfile::tempdir().unwrap();
        let context = Context::quiet(directory.path().to_owned(), Quick);
        let tables = work_precision(&context, &["cook".to_owned()]).unwrap();
        for (table, [name, way, value]) in
            tables.iter().zip([["solvers", "setting", "tolerance"], ["discretisation", "integrator", "time_step"]])
        {
            assert_eq!(table.name, format!("work-precision-cook-{name}"));
            assert_eq!(table.columns[..table.key_count], ["case", "triangles", way, value, "is_default"]);
            assert!(!table.rows.is_empty() && !table.remarks.is_empty());
            for row in &table.rows {
                assert!(
                    row[1].parse::<u64>().is_ok() && row[3].parse::<f64>().is_ok() && row[4].parse::<bool>().is_ok()
                );
                assert!(row[5..].iter().all(|field| field.is_empty() || field.parse::<f64>().is_ok()), "{row:?}");
            }
        }
        assert!(work_precision(&context, &["cok".to_owned()]).unwrap_err().to_string().contains("did you mean `cook`"));
    }
}

//! The rows: changes of the settings, each by itself.

use super::super::BenchError;
use rhexis::components::Sleeping;
use rhexis::settings::ablation::Part;
use rhexis::settings::{Precision, Preconditioner, Settings};
use rhexis::simulation::Simulation;
use rhexis::storage::BodyId;

/// One change.
pub(super) struct Row {
    /// Group of rows.
    pub kind: &'static str,
    /// Name in the table.
    pub name: &'static str,
    /// Change of the settings.
    pub set: fn(&mut Settings),
    /// Whether the body may sleep.
    pub may_sleep: bool,
}

const fn row(kind: &'static str, name: &'static str, set: fn(&mut Settings)) -> Row {
    Row { kind, name, set, may_sleep: false }
}

const BASE: &str = "-";
const PRECONDITIONER: &str = "preconditioner";
const GUARD: &str = "remedy off";
const STEP: &str = "solve off";
const SPEED: &str = "speed path off";

/// All rows, the one with everything on first.
pub(super) const ROWS: &[Row] = &[
    row(BASE, "everything on (auto)", |_| {}),
    row(PRECONDITIONER, "block Jacobi", |s| s.advanced.preconditioner = Preconditioner::BlockJacobi),
    row(PRECONDITIONER, "incomplete Cholesky", |s| s.advanced.preconditioner = Preconditioner::IncompleteCholesky),
    row(PRECONDITIONER, "multigrid", |s| s.advanced.preconditioner = Preconditioner::Multigrid),
    row(PRECONDITIONER, "Cholesky", |s| s.advanced.preconditioner = Preconditioner::Cholesky),
    row(GUARD, "energy guard", |s| s.without = Some(Part::EnergyGuard)),
    row(GUARD, "Newton corrections", |s| s.advanced.newton_corrections = 0),
    row(GUARD, "local relaxation", |s| s.without = Some(Part::LocalRelaxation)),
    row(GUARD, "step halving", |s| s.advanced.max_step_halvings = 0),
    row(GUARD, "undo", |s| s.without = Some(Part::Undo)),
    row(GUARD, "increment limit", |s| s.without = Some(Part::IncrementLimit)),
    row(STEP, "solve for the tips", |s| s.without = Some(Part::TipSolve)),
    row(STEP, "tear passes", |s| s.max_tear_passes = 0),
    row(STEP, "contact rounds", |s| s.without = Some(Part::ContactRounds)),
    row(SPEED, "initial guess", |s| s.without = Some(Part::InitialGuess)),
    row(SPEED, "stop by positions", |s| s.position_tolerance = f64::INFINITY),
    row(SPEED, "stop by stress", |s| s.advanced.linear.stress_tolerance = f64::INFINITY),
    row(SPEED, "budget", |s| s.budget = None),
    row(SPEED, "single precision", |s| s.advanced.precision = Precision::Double),
    row(SPEED, "wide lanes", |s| s.portable_instructions = true),
    Row { kind: "speed path added", name: "sleep", set: |_| {}, may_sleep: true },
];

impl Row {
    /// Settings of the row, from those of the scene.
    pub(super) fn settings(&self, of_scene: &Settings) -> Settings {
        let mut settings = *of_scene;
        (self.set)(&mut settings);
        settings
    }

    /// Makes the change in a simulation.
    pub(super) fn apply(&self, simulation: &mut Simulation, body: BodyId) -> Result<(), BenchError> {
        let settings = self.settings(simulation.settings());
        simulation.set_settings(settings)?;
        if self.may_sleep {
            simulation.set(body, Sleeping::default()).map_err(|e| BenchError::State(e.to_string()))?;
        }
        Ok(())
    }
}

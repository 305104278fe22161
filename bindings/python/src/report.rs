//! What a step did.

use crate::events::named;
use crate::world::World;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use rhexis::report::{BodyReport, Report as EngineReport};

/// Summary of a step.
#[pyclass(frozen, get_all, eq, module = "rhexis", skip_from_py_object)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Report {
    /// Steps done so far.
    step: u64,
    /// Time reached \[ms\].
    time: f64,
    /// Iterations of linear solves, of all bodies.
    iterations: u64,
    /// Tear tips that are alive, of all bodies.
    tip_count: u64,
    /// Steps of bodies, or parts of them, that were undone and retried.
    rolled_back: u32,
    /// Whether a body's step was given up; an event says why.
    has_failed: bool,
    /// Whether a solve has stopped because its time was up.
    is_late: bool,
    /// Whether tears were due that the limits of the step have left to the next one.
    is_cut_short: bool,
}

impl From<&EngineReport> for Report {
    fn from(report: &EngineReport) -> Self {
        let bodies = &report.bodies;
        let any = |is: fn(&BodyReport) -> bool| bodies.iter().any(is);
        Self {
            step: report.step,
            time: report.time,
            iterations: bodies.iter().map(|body| u64::from(body.iterations)).sum(),
            tip_count: bodies.iter().map(|body| body.tip_count as u64).sum(),
            rolled_back: report.rolled_back,
            has_failed: report.has_failed,
            is_late: any(|body| body.is_late),
            is_cut_short: any(|body| body.is_tear_cut_short),
        }
    }
}

#[pymethods]
impl Report {
    fn __repr__(&self) -> String {
        format!(
            "Report(step={}, time={}, iterations={}, tip_count={}, rolled_back={}, has_failed={})",
            self.step,
            self.time,
            self.iterations,
            self.tip_count,
            self.rolled_back,
            if self.has_failed { "True" } else { "False" }
        )
    }
}

#[pymethods]
impl World {
    /// The whole report of the last step: bodies, and systems with their times \[ms\].
    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.look(|state| {
            let report = state.simulation().report();
            let whole = PyDict::new(py);
            whole.set_item("step", report.step)?;
            whole.set_item("time", report.time)?;
            whole.set_item("rolled_back", report.rolled_back)?;
            whole.set_item("has_failed", report.has_failed)?;
            let bodies = PyList::empty(py);
            for body in &report.bodies {
                let told = named(py, body)?;
                told.set_item("body", state.handle(body.body))?;
                told.set_item("name", state.name(body.body))?;
                bodies.append(told)?;
            }
            whole.set_item("bodies", bodies)?;
            let systems = PyDict::new(py);
            for system in report.systems.iter().filter(|system| system.bodies > 0) {
                let time = system.time.as_secs_f64() * 1e3;
                let before = systems.get_item(system.name)?.map_or(Ok(0.0), |before| before.extract::<f64>())?;
                systems.set_item(system.name, before + time)?;
            }
            whole.set_item("systems", systems)?;
            Ok(whole)
        })
    }
}

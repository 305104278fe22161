//! The loosest tolerance of the stress that still reaches an error: where two ways to solve are compared.

use super::BenchError;
use super::errors::Errors;
use super::trace::{Plan, Trace};

/// Tolerances are tried from 10⁻⁰·⁵ down,
const LOOSEST: f64 = 0.316_227_766_016_837_94;
/// by 10⁰·²⁵ each.
const TIGHTER: f64 = 0.562_341_325_190_349_1;
/// The tightest.
const TIGHTEST: f64 = 1e-9;

/// A run that reaches the error.
#[derive(Debug)]
pub(super) struct Reached {
    /// Its tolerance.
    pub tolerance: f64,
    /// The run.
    pub trace: Trace,
    /// Its errors against the tight run.
    pub errors: Errors,
}

/// The plan with a tolerance, and nothing that stops a solve before it.
pub(super) fn at_tolerance(plan: &Plan, tolerance: f64) -> Plan {
    let mut plan = plan.clone();
    let sets = [format!("run.advanced.stress_tolerance={tolerance:e}"), "run.advanced.linear_tolerance=1".to_owned()];
    plan.solver.extend(sets.into_iter().chain(["run.advanced.linear_iterations=100000".to_owned()]));
    plan
}

/// Loosens the solves of the plan as far as the stress error of its worst state stays within `level`, then measures for some
/// seconds. Where no tolerance reaches it, the tightest run.
pub(super) fn loosest(plan: &Plan, exact: &Trace, level: f64, seconds: f64) -> Result<Reached, BenchError> {
    let mut tolerance = LOOSEST;
    loop {
        let plan = at_tolerance(plan, tolerance);
        let trace = Trace::record(&Plan { until: plan.compared_until, ..plan.clone() }, 0.0)?;
        let errors = Errors::against(&trace, exact);
        if errors.stress <= level || tolerance < 2.0 * TIGHTEST {
            let is_whole = seconds == 0.0 && plan.until == plan.compared_until;
            let trace = if is_whole { trace } else { Trace::record(&plan, seconds)? };
            return Ok(Reached { tolerance, trace, errors });
        }
        tolerance *= TIGHTER;
    }
}

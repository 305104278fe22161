//! Settings of `[run]`: the preset of its `accuracy`, with the keys that the scene gives.

use super::error::{Fault, positive};
use super::schema::{
    AccuracySpec, AdvancedSpec, IntegratorSpec, PrecisionSpec, PreconditionerSpec, RunSpec, TangentSpec,
};
use rhexis::settings::{Accuracy, Advanced, Integrator, LinearParams, Precision, Preconditioner, Settings, Tangent};
use std::time::Duration;

/// Settings of a run.
pub(super) fn of_run(spec: &RunSpec) -> Result<Settings, Fault> {
    if spec.threads > 1024 {
        return Err(Fault::new(
            "run.threads",
            format!("{} threads are too many", spec.threads),
            "give 0 for one per core",
        ));
    }
    let base = Settings::new(match spec.accuracy {
        AccuracySpec::Fast => Accuracy::Fast,
        AccuracySpec::Haptic => Accuracy::Haptic,
        AccuracySpec::Game => Accuracy::Game,
        AccuracySpec::Accurate => Accuracy::Accurate,
        AccuracySpec::Static => Accuracy::Static,
    });
    Ok(Settings {
        budget: match spec.budget {
            Some(0) => None,
            Some(given) => Some(counted("budget", given, 1_000_000)?),
            None => base.budget,
        },
        threads: spec.threads,
        max_tear_passes: limited("max_tear_passes", spec.max_tear_passes, base.max_tear_passes, 1000, A_SOLVE)?,
        // Infinite: not asked for.
        position_tolerance: tolerance("position_tolerance", spec.position_tolerance, base.position_tolerance)?,
        portable_instructions: spec.portable_instructions,
        advanced: advanced(&spec.advanced, &base.advanced)?,
        without: base.without,
    })
}

fn advanced(spec: &AdvancedSpec, base: &Advanced) -> Result<Advanced, Fault> {
    let static_iterations = spec.static_iterations.unwrap_or(base.static_iterations);
    Ok(Advanced {
        linear: linear(spec, &base.linear)?,
        tangent: match spec.tangent {
            Some(TangentSpec::Rotated) => Tangent::Rotated,
            Some(TangentSpec::Exact) => Tangent::Exact,
            Some(TangentSpec::Projected) => Tangent::Projected,
            Some(TangentSpec::Weighted) => Tangent::Weighted,
            None => base.tangent,
        },
        integrator: match spec.integrator {
            Some(IntegratorSpec::BackwardEuler) => Integrator::BackwardEuler,
            Some(IntegratorSpec::TrBdf2) => Integrator::TrBdf2,
            None => base.integrator,
        },
        preconditioner: match spec.preconditioner {
            PreconditionerSpec::Auto => Preconditioner::Auto,
            PreconditionerSpec::BlockJacobi => Preconditioner::BlockJacobi,
            PreconditionerSpec::IncompleteCholesky => Preconditioner::IncompleteCholesky,
            PreconditionerSpec::Multigrid => Preconditioner::Multigrid,
            PreconditionerSpec::Cholesky => Preconditioner::Cholesky,
        },
        precision: match spec.precision {
            PrecisionSpec::Mixed => Precision::Mixed,
            PrecisionSpec::Double => Precision::Double,
        },
        newton_iterations: match spec.newton_iterations {
            Some(given) => counted("advanced.newton_iterations", given, 1_000)?,
            None => base.newton_iterations,
        },
        newton_tolerance: tolerance("advanced.newton_tolerance", spec.newton_tolerance, base.newton_tolerance)?,
        static_iterations: counted("advanced.static_iterations", static_iterations, 10_000)?,
        newton_corrections: limited(
            "advanced.newton_corrections",
            spec.newton_corrections,
            base.newton_corrections,
            100,
            A_SOLVE,
        )?,
        max_step_halvings: limited(
            "advanced.max_step_halvings",
            spec.max_step_halvings,
            base.max_step_halvings,
            20,
            "a millionth of dt is the smallest part then",
        )?,
    })
}

fn linear(spec: &AdvancedSpec, base: &LinearParams) -> Result<LinearParams, Fault> {
    Ok(LinearParams {
        tolerance: tolerance("advanced.linear_tolerance", spec.linear_tolerance, base.tolerance)?,
        // Infinite: not asked for.
        stress_tolerance: tolerance("advanced.stress_tolerance", spec.stress_tolerance, base.stress_tolerance)?,
        iterations: counted("advanced.linear_iterations", spec.linear_iterations, 1_000_000)?,
        time: match spec.solve_milliseconds {
            Some(ms) => {
                let seconds = 1e-3 * positive("run.advanced.solve_milliseconds".to_owned(), ms, "ms")?;
                // More than there can be is no limit.
                Duration::try_from_secs_f64(seconds).ok()
            }
            None => None,
        },
    })
}

const A_SOLVE: &str = "each is one more solve";

fn tolerance(name: &str, given: Option<f64>, default: f64) -> Result<f64, Fault> {
    given.map_or(Ok(default), |given| positive(format!("run.{name}"), given, ""))
}

fn counted(name: &str, count: u32, most: u32) -> Result<u32, Fault> {
    match count {
        0 => Err(Fault::new(format!("run.{name}"), "there must be at least one", "give 1 or more")),
        _ if count > most => {
            Err(Fault::new(format!("run.{name}"), format!("{count} are too many"), format!("give {most} at most")))
        }
        _ => Ok(count),
    }
}

fn limited(name: &str, given: Option<u32>, default: u32, most: u32, cost: &str) -> Result<u32, Fault> {
    let count = given.unwrap_or(default);
    if count > most {
        let hint = format!("give {most} or less: {cost}");
        return Err(Fault::new(format!("run.{name}"), format!("{count} are too many"), hint));
    }
    Ok(count)
}

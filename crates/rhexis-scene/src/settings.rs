//! The settings that `[run]` asks for.

use super::error::{Fault, positive};
use super::schema::{Accuracy, IntegratorSpec, PrecisionSpec, PreconditionerSpec, RunSpec, TangentSpec};
use rhexis::settings::{Integrator, LinearParams, Precision, Preconditioner, Settings, Tangent};
use std::time::Duration;

/// Those of its `accuracy`, but where it says otherwise.
pub(super) fn of_run(spec: &RunSpec) -> Result<Settings, Fault> {
    let counted = |name: &str, count: u32, most: u32| match count {
        0 => Err(Fault::new(format!("run.{name}"), "there must be at least one", "give 1 or more")),
        _ if count > most => {
            Err(Fault::new(format!("run.{name}"), format!("{count} are too many"), format!("give {most} at most")))
        }
        _ => Ok(count),
    };
    if spec.threads > 1024 {
        return Err(Fault::new(
            "run.threads",
            format!("{} threads are too many", spec.threads),
            "give 0 for one per core",
        ));
    }
    let base = match spec.accuracy {
        Accuracy::Fast => Settings::default(),
        Accuracy::Accurate => Settings::accurate(),
        Accuracy::Haptic => Settings::haptic(),
        Accuracy::Game => Settings::game(),
        Accuracy::Static => Settings::equilibrium(),
    };
    let (resumes, halvings) = (spec.resumes.unwrap_or(base.resumes), spec.halvings.unwrap_or(base.halvings));
    if resumes > 1000 {
        let hint = "give 1000 or less: each is one more solve";
        return Err(Fault::new("run.resumes", format!("{resumes} resumes are too many"), hint));
    }
    let corrections = spec.corrections.unwrap_or(base.corrections);
    if corrections > 100 {
        let hint = "give 100 or less: each is one more solve";
        return Err(Fault::new("run.corrections", format!("{corrections} corrections are too many"), hint));
    }
    if halvings > 20 {
        let hint = "give 20 or less: a millionth of dt is the smallest part then";
        return Err(Fault::new("run.halvings", format!("{halvings} halvings are too many"), hint));
    }
    let tolerance = |name: &str, given: Option<f64>, default: f64| match given {
        Some(given) => positive(format!("run.{name}"), given, ""),
        None => Ok(default),
    };
    Ok(Settings {
        linear: LinearParams {
            tolerance: tolerance("linear_tolerance", spec.linear_tolerance, base.linear.tolerance)?,
            // Infinite: not asked for.
            stress_tolerance: tolerance("stress_tolerance", spec.stress_tolerance, base.linear.stress_tolerance)?,
            position_tolerance: tolerance(
                "position_tolerance",
                spec.position_tolerance,
                base.linear.position_tolerance,
            )?,
            iterations: counted("linear_iterations", spec.linear_iterations, 1_000_000)?,
            time: match spec.solve_milliseconds {
                Some(ms) => {
                    let seconds = 1e-3 * positive("run.solve_milliseconds".to_owned(), ms, "ms")?;
                    // More than there can be is no limit.
                    Duration::try_from_secs_f64(seconds).ok()
                }
                None => None,
            },
        },
        tangent: match spec.tangent {
            Some(TangentSpec::Rotated) => Tangent::Rotated,
            Some(TangentSpec::Exact) => Tangent::Exact,
            Some(TangentSpec::Projected) => Tangent::Projected,
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
            Some(given) => counted("newton_iterations", given, 1_000)?,
            None => base.newton_iterations,
        },
        newton_tolerance: tolerance("newton_tolerance", spec.newton_tolerance, base.newton_tolerance)?,
        static_iterations: counted(
            "static_iterations",
            spec.static_iterations.unwrap_or(base.static_iterations),
            10_000,
        )?,
        resumes,
        corrections,
        halvings,
        budget: match spec.budget {
            Some(given) => Some(counted("budget", given, 1_000_000)?),
            None => base.budget,
        },
        threads: spec.threads,
        portable_instructions: spec.portable_instructions,
    })
}

//! Settings in saved bytes: their fields in the order of the format.

use crate::settings::{Advanced, Integrator, LinearParams, Precision, Preconditioner, Settings, Tangent};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::time::Duration;

/// Settings as they are saved.
#[derive(Serialize, Deserialize)]
struct Saved {
    linear: Linear,
    preconditioner: Preconditioner,
    precision: Precision,
    tangent: Tangent,
    integrator: Integrator,
    newton_iterations: u32,
    newton_tolerance: f64,
    static_iterations: u32,
    max_tear_passes: u32,
    newton_corrections: u32,
    max_step_halvings: u32,
    budget: Option<u32>,
    threads: usize,
    portable_instructions: bool,
}

/// Limits of linear solves as they are saved.
#[derive(Serialize, Deserialize)]
struct Linear {
    tolerance: f64,
    stress_tolerance: f64,
    position_tolerance: f64,
    iterations: u32,
    time: Option<Duration>,
}

pub(crate) fn serialize<S: Serializer>(settings: &Settings, serializer: S) -> Result<S::Ok, S::Error> {
    let &Settings { budget, threads, max_tear_passes, position_tolerance, portable_instructions, advanced, without: _ } =
        settings;
    let LinearParams { tolerance, stress_tolerance, iterations, time } = advanced.linear;
    let saved = Saved {
        linear: Linear { tolerance, stress_tolerance, position_tolerance, iterations, time },
        preconditioner: advanced.preconditioner,
        precision: advanced.precision,
        tangent: advanced.tangent,
        integrator: advanced.integrator,
        newton_iterations: advanced.newton_iterations,
        newton_tolerance: advanced.newton_tolerance,
        static_iterations: advanced.static_iterations,
        max_tear_passes,
        newton_corrections: advanced.newton_corrections,
        max_step_halvings: advanced.max_step_halvings,
        budget,
        threads,
        portable_instructions,
    };
    saved.serialize(serializer)
}

pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Settings, D::Error> {
    let saved = Saved::deserialize(deserializer)?;
    let Linear { tolerance, stress_tolerance, position_tolerance, iterations, time } = saved.linear;
    let advanced = Advanced {
        preconditioner: saved.preconditioner,
        precision: saved.precision,
        tangent: saved.tangent,
        integrator: saved.integrator,
        newton_iterations: saved.newton_iterations,
        newton_tolerance: saved.newton_tolerance,
        static_iterations: saved.static_iterations,
        newton_corrections: saved.newton_corrections,
        max_step_halvings: saved.max_step_halvings,
        linear: LinearParams { tolerance, stress_tolerance, iterations, time },
    };
    Ok(Settings {
        budget: saved.budget,
        threads: saved.threads,
        max_tear_passes: saved.max_tear_passes,
        position_tolerance,
        portable_instructions: saved.portable_instructions,
        advanced,
        without: None,
    })
}

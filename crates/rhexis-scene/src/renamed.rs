//! Keys of settings that have another name or place now.

/// Old and new place of keys of `[run]`.
const OF_RUN: [(&str, &str); 16] = [
    ("resumes", "max_tear_passes"),
    ("corrections", "advanced.newton_corrections"),
    ("halvings", "advanced.max_step_halvings"),
    ("integrator", "advanced.integrator"),
    ("newton_iterations", "advanced.newton_iterations"),
    ("newton_tolerance", "advanced.newton_tolerance"),
    ("linear_tolerance", "advanced.linear_tolerance"),
    ("stress_tolerance", "advanced.stress_tolerance"),
    ("solve_milliseconds", "advanced.solve_milliseconds"),
    ("linear_iterations", "advanced.linear_iterations"),
    ("tangent", "advanced.tangent"),
    ("preconditioner", "advanced.preconditioner"),
    ("precision", "advanced.precision"),
    ("static_tolerance", "advanced.static_tolerance"),
    ("static_iterations", "advanced.static_iterations"),
    ("static_advances", "advanced.static_advances"),
];

/// Old and new place of keys of the engine's `Settings`.
const OF_SETTINGS: [(&str, &str); 11] = [
    ("resumes", "max_tear_passes"),
    ("corrections", "advanced.newton_corrections"),
    ("halvings", "advanced.max_step_halvings"),
    ("linear", "advanced.linear"),
    ("integrator", "advanced.integrator"),
    ("newton_iterations", "advanced.newton_iterations"),
    ("newton_tolerance", "advanced.newton_tolerance"),
    ("tangent", "advanced.tangent"),
    ("preconditioner", "advanced.preconditioner"),
    ("precision", "advanced.precision"),
    ("static_iterations", "advanced.static_iterations"),
];

/// The old key that is there, with its new place.
pub(super) fn of_run(is_there: impl Fn(&str) -> bool) -> Option<(&'static str, &'static str)> {
    OF_RUN.into_iter().find(|(old, _)| is_there(old))
}

/// New place of a key of `Settings`.
pub(super) fn of_settings(old: &str) -> Option<&'static str> {
    OF_SETTINGS.into_iter().find_map(|(name, new)| (name == old).then_some(new))
}

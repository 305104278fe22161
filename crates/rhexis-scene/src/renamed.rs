//! Keys that have another name or place now: they are refused with the present one.

/// Former keys with their present names. A strength and a toughness are named by the direction of the tear: that of the stress that
/// opens it is across.
const RENAMED: [(&str, &str); 4] = [
    ("strength_fibre", "strength_across_fibres"),
    ("strength_transverse", "strength_along_fibres"),
    ("toughness_along", "toughness_along_fibres"),
    ("toughness_across", "toughness_across_fibres"),
];

/// Remedy for a former key: its present name or its replacement. `None` for other keys.
pub(crate) fn remedy(key: &str) -> Option<String> {
    if key == "max_tear_speed" {
        let remedy = "leave it out: no tear is faster than Rayleigh waves; a toughness that grows with speed is `rate = { speed = …, exponent = … }`";
        return Some(remedy.to_owned());
    }
    let (_, now) = RENAMED.iter().find(|(former, _)| *former == key)?;
    Some(format!("write `{now}`, by the direction of the tear; the value stays"))
}

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
pub(crate) fn of_run(is_there: impl Fn(&str) -> bool) -> Option<(&'static str, &'static str)> {
    OF_RUN.into_iter().find(|(old, _)| is_there(old))
}

/// New place of a key of `Settings`.
pub(crate) fn of_settings(old: &str) -> Option<&'static str> {
    OF_SETTINGS.into_iter().find_map(|(name, new)| (name == old).then_some(new))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Document;

    #[test]
    fn former_keys_are_refused_with_their_present_names() {
        for (former, now) in RENAMED {
            let table = if former.starts_with("strength") { "tearing" } else { "energy_criterion" };
            let mut document = Document::named("fig2-tear").unwrap();
            document.set(&format!("bodies.0.{table}.{former}=0.5")).unwrap();
            let error = document.scene().unwrap_err();
            assert_eq!(error.what, format!("there is no `{former}` here"));
            assert!(error.hint.contains(&format!("`{now}`")), "{error}");
        }
        let text = Document::named("fig2-tear").unwrap().text().replace("strength_along_fibres", "strength_transverse");
        let error = Document::new(text, "torn.toml").scene().unwrap_err();
        assert!(error.position.is_some() && error.hint.contains("`strength_along_fibres`"), "{error}");
    }

    #[test]
    fn a_largest_speed_is_refused_with_the_rate_that_stands_in_its_place() {
        let mut document = Document::named("fig2-tear").unwrap();
        document.set("bodies.0.tearing.max_tear_speed=0.1").unwrap();
        let error = document.scene().unwrap_err();
        assert_eq!(error.what, "there is no `max_tear_speed` here");
        assert!(error.hint.contains("`rate = {"), "{error}");
    }

    #[cfg(feature = "snapshot")]
    #[test]
    fn components_refuse_former_keys_likewise() {
        let text = "strength_transverse = 0.5";
        let error = crate::patch::patched(
            "Tearing",
            Some(&rhexis::components::Tearing::default()),
            toml::from_str(text).unwrap(),
        )
        .unwrap_err();
        assert!(error.contains("`strength_transverse`") && error.contains("`strength_along_fibres`"), "{error}");
    }
}

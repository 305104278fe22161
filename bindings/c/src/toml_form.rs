//! Components and settings as TOML: what is there, with what a text changes of it.

use crate::status::{Answer, unreadable};
use rhexis_scene::patch;
use serde::{Serialize, de::DeserializeOwned};

/// A value as text.
pub(crate) fn text(what: &str, value: &impl Serialize) -> Answer<String> {
    toml::to_string(value).map_err(|error| unreadable(format!("{what}: {error}")))
}

/// A value with what a text changes of it; a key that it does not have is refused.
pub(crate) fn patched<T: Serialize + DeserializeOwned>(what: &str, base: Option<&T>, text: &str) -> Answer<T> {
    let patch = toml::from_str(text).map_err(|error| unreadable(format!("{what}: {error}")))?;
    patch::patched(what, base, patch).map_err(unreadable)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::status::RhexisStatus;
    use rhexis::components::{Gravity, Hold, Holds, Tearing};
    use rhexis::settings::Settings;

    #[test]
    fn what_a_text_does_not_name_stays() {
        let base = Tearing { radius: 7.0, ..Tearing::default() };
        let changed = patched("Tearing", Some(&base), "strength_across_fibres = 3\nmode = \"Edge\"").unwrap();
        assert_eq!((changed.radius, changed.strength_across_fibres), (7.0, 3.0));
        let settings = patched("settings", Some(&Settings::default()), "advanced.linear.tolerance = 1e-6").unwrap();
        assert_eq!(settings.advanced.linear.tolerance, 1e-6);
        assert_eq!(settings.advanced.linear.iterations, Settings::default().advanced.linear.iterations);
    }

    #[test]
    fn unknown_missing_and_wrong_keys_are_refused_with_a_remedy() {
        let error = patched("Tearing", Some(&Tearing::default()), "strength_across_fibre = 3").unwrap_err();
        assert_eq!(error.status, RhexisStatus::Scene);
        assert_eq!(
            error.message,
            "Tearing: there is no key `strength_across_fibre`: did you mean `strength_across_fibres`?"
        );
        let error = patched::<Gravity>("Gravity", None, "").unwrap_err();
        assert!(error.message.contains("missing field `acceleration`"), "{}", error.message);
        let error = patched::<Gravity>("Gravity", None, "acceleration = 3").unwrap_err();
        assert!(error.message.starts_with("Gravity: invalid type"), "{}", error.message);
        assert!(patched::<Gravity>("Gravity", None, "acceleration = [").is_err());
    }

    #[test]
    fn an_old_name_of_a_setting_is_refused_with_its_new_one() {
        let error = |text| patched("settings", Some(&Settings::default()), text).unwrap_err().message;
        assert_eq!(error("resumes = 3"), "settings: the key `resumes` is now `max_tear_passes`");
        assert_eq!(error("halvings = 3"), "settings: the key `halvings` is now `advanced.max_step_halvings`");
        assert_eq!(error("linear.tolerance = 1"), "settings: the key `linear` is now `advanced.linear`");
    }

    #[test]
    fn attached_values_need_no_history() {
        let text = r#"groups = [{ name = "left", axes = [true, true, true], curve = { points = [[0, 1]] },
            members = { rows = [0, 4], values = [[0, 0, 1], [0, 0, 2]] } }]"#;
        let Holds { groups } = patched("Holds", None, text).unwrap();
        let Hold { name, members, .. } = &groups[0];
        assert_eq!((name.as_str(), members.rows()), ("left", &[0, 4][..]));
    }
}

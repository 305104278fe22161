//! Components and settings that change by tables of TOML: what is there, with what a table says of it.

use crate::nearest;
use serde::{Serialize, de::DeserializeOwned};
use toml::{Table, Value};

/// A table of TOML of a value.
///
/// # Errors
/// A message that begins with `what`, for a value that TOML cannot say.
pub fn table(what: &str, value: &impl Serialize) -> Result<Table, String> {
    Table::try_from(value).map_err(|error| format!("{what}: {error}"))
}

/// A value with what a table changes of it: of `base`, or of nothing.
///
/// # Errors
/// A message that begins with `what`, for a key that is unknown, missing or of a wrong type.
pub fn patched<T: Serialize + DeserializeOwned>(what: &str, base: Option<&T>, mut patch: Table) -> Result<T, String> {
    patch.iter_mut().for_each(|(_, value)| complete(value));
    let base = base.map_or(Ok(Table::new()), |base| table(what, base))?;
    let read = |is_deep: bool| {
        let mut all = base.clone();
        merge(&mut all, &patch, is_deep);
        T::deserialize(Value::Table(all))
    };
    // A table of one kind in place of one of another kind does not mix with it.
    let value = read(true).or_else(|error| read(false).map_err(|_| error));
    let value = value.map_err(|error| format!("{what}: {}", error.to_string().trim_end()))?;
    known(what, &patch, &table(what, &value)?)?;
    Ok(value)
}

/// Values attached to rows need not say that none of them was ever removed.
fn complete(value: &mut Value) {
    match value {
        Value::Table(table) => {
            table.iter_mut().for_each(|(_, value)| complete(value));
            if table.contains_key("rows") && table.contains_key("values") && !table.contains_key("buried") {
                table.insert("buried".to_owned(), Value::Array(Vec::new()));
            }
        }
        Value::Array(list) => list.iter_mut().for_each(complete),
        _ => {}
    }
}

fn merge(all: &mut Table, patch: &Table, is_deep: bool) {
    for (key, value) in patch {
        match (all.get_mut(key), value) {
            (Some(Value::Table(old)), Value::Table(new)) if is_deep => merge(old, new, true),
            _ => _ = all.insert(key.clone(), value.clone()),
        }
    }
}

/// Refuses keys that were not understood: those that what was read does not have.
fn known(path: &str, patch: &Table, read: &Table) -> Result<(), String> {
    for (key, value) in patch {
        let Some(there) = read.get(key) else {
            let hint = nearest(key, read.keys().map(String::as_str));
            let hint = hint.map_or(String::new(), |near| format!(": did you mean `{near}`?"));
            return Err(format!("{path}: there is no key `{key}`{hint}"));
        };
        known_in(&format!("{path}.{key}"), value, there)?;
    }
    Ok(())
}

fn known_in(path: &str, given: &Value, read: &Value) -> Result<(), String> {
    match (given, read) {
        (Value::Table(given), Value::Table(read)) => known(path, given, read),
        (Value::Array(given), Value::Array(read)) => {
            let mut pairs = given.iter().zip(read).enumerate();
            pairs.try_for_each(|(i, (given, read))| known_in(&format!("{path}.{i}"), given, read))
        }
        _ => Ok(()),
    }
}

/// Calls a macro with the components that a host may change, each with the value that a new one has for keys that are not given.
///
/// ```
/// macro_rules! names {
///     ($($component:ident $(or $default:expr)?;)*) => { [$(stringify!($component)),*] };
/// }
/// assert!(rhexis_scene::for_each_component!(names).contains(&"Tearing"));
/// ```
#[macro_export]
macro_rules! for_each_component {
    ($calls:ident) => {
        $calls! {
            Attributes or Attributes::default();
            Bending or Bending::default();
            Blade;
            Contact or Contact::default();
            Damping;
            Drag;
            EdgeLoads or EdgeLoads::default();
            EnergyCriterion;
            Forceps;
            Gravity;
            Grips or Grips::default();
            HoldGuides or HoldGuides::default();
            HoldTurns or HoldTurns::default();
            Holds or Holds::default();
            HolzapfelGasserOgden or HolzapfelGasserOgden::default();
            Obstacle;
            ObstaclePath;
            PointLoads or PointLoads::default();
            PreStretch;
            Pressure;
            Refinement or Refinement::default();
            Sleeping or Sleeping::default();
            Springs;
            StiffeningFibres;
            Tearing or Tearing::default();
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhexis::components::{Gravity, Hold, Holds, Tearing};
    use rhexis::settings::Settings;

    fn of_text<T: Serialize + DeserializeOwned>(what: &str, base: Option<&T>, text: &str) -> Result<T, String> {
        patched(what, base, toml::from_str(text).unwrap())
    }

    #[test]
    fn what_a_text_does_not_name_stays() {
        let base = Tearing { radius: 7.0, ..Tearing::default() };
        let changed = of_text("Tearing", Some(&base), "strength_fibre = 3\nmode = \"Edge\"").unwrap();
        assert_eq!((changed.radius, changed.strength_fibre), (7.0, 3.0));
        let settings = of_text("settings", Some(&Settings::default()), "linear.tolerance = 1e-6").unwrap();
        assert_eq!(settings.linear.tolerance, 1e-6);
        assert_eq!(settings.linear.iterations, Settings::default().linear.iterations);
    }

    #[test]
    fn unknown_missing_and_wrong_keys_are_refused_with_a_remedy() {
        let error = of_text("Tearing", Some(&Tearing::default()), "strength_fibres = 3").unwrap_err();
        assert_eq!(error, "Tearing: there is no key `strength_fibres`: did you mean `strength_fibre`?");
        let error = of_text::<Gravity>("Gravity", None, "").unwrap_err();
        assert!(error.contains("missing field `acceleration`"), "{error}");
        let error = of_text::<Gravity>("Gravity", None, "acceleration = 3").unwrap_err();
        assert!(error.starts_with("Gravity: invalid type"), "{error}");
    }

    #[test]
    fn attached_values_need_no_history() {
        let text = r#"groups = [{ name = "left", axes = [true, true, true], curve = { points = [[0, 1]] },
            members = { rows = [0, 4], values = [[0, 0, 1], [0, 0, 2]] } }]"#;
        let Holds { groups } = of_text("Holds", None, text).unwrap();
        let Hold { name, members, .. } = &groups[0];
        assert_eq!((name.as_str(), members.rows()), ("left", &[0, 4][..]));
    }
}

//! Components and settings as TOML: what is there, with what a table changes of it.

use crate::{nearest, renamed};
#[cfg(feature = "snapshot")]
use rhexis::{
    components::{Obstacle, Rigid},
    simulation::Simulation,
    storage::ObstacleId,
};
use serde::{Serialize, de::DeserializeOwned};
use toml::{Table, Value};

/// The table of a value.
///
/// # Errors
/// Says of `what` why TOML has no form for it.
pub fn to_table(what: &str, value: &impl Serialize) -> Result<Table, String> {
    Table::try_from(value).map_err(|error| format!("{what}: {error}"))
}

/// A value with what a table changes of it; keys that the table does not name stay.
///
/// # Errors
/// Names `what` and the key that is missing, wrong or not there, with the nearest that there is.
pub fn patched<T: Serialize + DeserializeOwned>(what: &str, base: Option<&T>, mut patch: Table) -> Result<T, String> {
    patch.iter_mut().for_each(|(_, value)| complete(value));
    let base = base.map_or(Ok(Table::new()), |base| to_table(what, base))?;
    let read = |is_deep: bool| {
        let mut all = base.clone();
        merge(&mut all, &patch, is_deep);
        T::deserialize(Value::Table(all))
    };
    // A table of one kind in place of one of another kind does not mix with it.
    let value = read(true).or_else(|error| read(false).map_err(|_| error));
    let value = value.map_err(|error| format!("{what}: {}", error.to_string().trim_end()))?;
    known(what, &patch, &to_table(what, &value)?)?;
    Ok(value)
}

/// Motion of a rigid obstacle with the keys of a table changed: of its present motion, or of the solid of its shape where the table has a mass. An
/// empty table takes the mass away.
///
/// # Errors
/// For no such obstacle, an unknown key, a wrong value, and a new body without a mass or of a plane.
#[cfg(feature = "snapshot")]
pub fn patched_rigid(simulation: &Simulation, obstacle: ObstacleId, patch: Table) -> Result<Option<Rigid>, String> {
    if patch.is_empty() {
        return Ok(None);
    }
    let present = simulation.rigid(obstacle).map_err(|error| error.to_string())?;
    let base = match present {
        Some(rigid) => rigid,
        None => {
            let world = simulation.world();
            let shape = world.get::<&Obstacle>(obstacle.entity()).map_err(|error| error.to_string())?.shape.clone();
            let mass = patch.get("mass").and_then(|mass| mass.as_float().or(mass.as_integer().map(|mass| mass as f64)));
            let mass = mass.ok_or("Rigid: give `mass` [g], from which centre and inertia follow")?;
            Rigid::of(&shape, mass).ok_or("Rigid: a half space has no mass: give a box")?
        }
    };
    patched("Rigid", Some(&base), patch).map(Some)
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
            if let (true, Some(new)) = (path == "settings", renamed::of_settings(key)) {
                return Err(format!("settings: the key `{key}` is now `{new}`"));
            }
            let near = || nearest(key, read.keys().map(String::as_str)).map(|near| format!("did you mean `{near}`?"));
            let hint = renamed::remedy(key).or_else(near).map_or(String::new(), |hint| format!(": {hint}"));
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

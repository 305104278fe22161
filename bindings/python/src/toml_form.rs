//! Components and settings as TOML and dictionaries: what is there, with what is given changes of it.

use crate::error::{Answer, Failure, unreadable};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyTuple};
use pythonize::pythonize;
use rhexis_scene::nearest;
use serde::{Serialize, de::DeserializeOwned};
use toml::{Table, Value};

/// Table of a text, of a dictionary, of keyword arguments, or of both: keywords win.
pub(crate) fn given(
    what: &str,
    values: Option<&Bound<'_, PyAny>>,
    keywords: Option<&Bound<'_, PyDict>>,
) -> Answer<Table> {
    let mut all = match values {
        None => Table::new(),
        Some(values) => match (values.extract::<String>(), values.cast::<PyDict>()) {
            (Ok(text), _) => toml::from_str(&text).map_err(|error| unreadable(format!("{what}: {error}")))?,
            (_, Ok(values)) => of_dict(what, values)?,
            _ => return Err(Failure::input(format!("{what}: give TOML text or a dictionary"))),
        },
    };
    all.extend(keywords.map_or(Ok(Table::new()), |keywords| of_dict(what, keywords))?);
    Ok(all)
}

fn of_dict(what: &str, values: &Bound<'_, PyDict>) -> Answer<Table> {
    let mut table = Table::new();
    for (key, value) in values {
        let key = key.extract::<String>().map_err(|_| Failure::input(format!("{what}: the key {key} is no text")))?;
        // TOML has no nothing: the key is left as it is.
        if !value.is_none() {
            let value = of_value(&format!("{what}.{key}"), &value)?;
            table.insert(key, value);
        }
    }
    Ok(table)
}

fn of_value(what: &str, value: &Bound<'_, PyAny>) -> Answer<Value> {
    if let Ok(value) = value.cast::<PyBool>() {
        return Ok(Value::Boolean(value.is_true()));
    }
    if value.is_instance_of::<PyInt>() {
        let value = value.extract().map_err(|_| Failure::input(format!("{what}: {value} is beyond 64 bits")))?;
        return Ok(Value::Integer(value));
    }
    if value.is_instance_of::<PyFloat>() {
        return value.extract().map(Value::Float).map_err(|_| Failure::input(format!("{what}: no number")));
    }
    if let Ok(value) = value.extract::<String>() {
        return Ok(Value::String(value));
    }
    if let Ok(value) = value.cast::<PyDict>() {
        return of_dict(what, value).map(Value::Table);
    }
    // Arrays and scalars of NumPy.
    if let Ok(plain) = value.call_method0("tolist") {
        return of_value(what, &plain);
    }
    if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        let items = value.try_iter().map_err(|error| Failure::input(format!("{what}: {error}")))?;
        let items = items.enumerate().map(|(i, item)| {
            let item = item.map_err(|error| Failure::input(format!("{what}: {error}")))?;
            of_value(&format!("{what}.{i}"), &item)
        });
        return items.collect::<Answer<_>>().map(Value::Array);
    }
    Err(Failure::input(format!("{what}: {value} is nothing that TOML can say")))
}

/// A value as a dictionary of Python.
pub(crate) fn to_python<'py>(py: Python<'py>, what: &str, value: &impl Serialize) -> PyResult<Bound<'py, PyAny>> {
    // By way of TOML, so that what is given back is what can be given.
    Ok(pythonize(py, &table(what, value)?)?)
}

fn table(what: &str, value: &impl Serialize) -> Answer<Table> {
    Table::try_from(value).map_err(|error| unreadable(format!("{what}: {error}")))
}

/// A value with what is given changes of it; a key that it does not have is refused.
pub(crate) fn patched<T: Serialize + DeserializeOwned>(what: &str, base: Option<&T>, mut patch: Table) -> Answer<T> {
    patch.iter_mut().for_each(|(_, value)| complete(value));
    let base = base.map_or(Ok(Table::new()), |base| table(what, base))?;
    let read = |is_deep: bool| {
        let mut all = base.clone();
        merge(&mut all, &patch, is_deep);
        T::deserialize(Value::Table(all))
    };
    // A table of one kind in place of one of another kind does not mix with it.
    let value = read(true).or_else(|error| read(false).map_err(|_| error));
    let value = value.map_err(|error| unreadable(format!("{what}: {}", error.to_string().trim_end())))?;
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
fn known(path: &str, patch: &Table, read: &Table) -> Answer<()> {
    for (key, value) in patch {
        let Some(there) = read.get(key) else {
            let hint = nearest(key, read.keys().map(String::as_str));
            let hint = hint.map_or(String::new(), |near| format!(": did you mean `{near}`?"));
            return Err(unreadable(format!("{path}: there is no key `{key}`{hint}")));
        };
        known_in(&format!("{path}.{key}"), value, there)?;
    }
    Ok(())
}

fn known_in(path: &str, given: &Value, read: &Value) -> Answer<()> {
    match (given, read) {
        (Value::Table(given), Value::Table(read)) => known(path, given, read),
        (Value::Array(given), Value::Array(read)) => {
            let mut pairs = given.iter().zip(read).enumerate();
            pairs.try_for_each(|(i, (given, read))| known_in(&format!("{path}.{i}"), given, read))
        }
        _ => Ok(()),
    }
}

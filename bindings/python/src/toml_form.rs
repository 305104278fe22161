//! Components and settings as TOML and dictionaries: what is there, with what is given changes of it.

use crate::error::{Answer, Failure, unreadable};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyTuple};
use pythonize::pythonize;
use rhexis_scene::patch;
use serde::{Serialize, de::DeserializeOwned};
use toml::{Table, Value};

/// Maximum levels of dictionaries and lists in each other; components have five.
const MAX_DEPTH: usize = 32;

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
            (_, Ok(values)) => of_dict(what, values, 0)?,
            _ => return Err(Failure::input(format!("{what}: give TOML text or a dictionary"))),
        },
    };
    all.extend(keywords.map_or(Ok(Table::new()), |keywords| of_dict(what, keywords, 0))?);
    Ok(all)
}

fn of_dict(what: &str, values: &Bound<'_, PyDict>, depth: usize) -> Answer<Table> {
    let mut table = Table::new();
    for (key, value) in values {
        let key = key.extract::<String>().map_err(|_| Failure::input(format!("{what}: the key {key} is no text")))?;
        // TOML has no nothing: the key is left as it is.
        if !value.is_none() {
            let value = of_value(&format!("{what}.{key}"), &value, depth + 1)?;
            table.insert(key, value);
        }
    }
    Ok(table)
}

fn of_value(what: &str, value: &Bound<'_, PyAny>, depth: usize) -> Answer<Value> {
    if depth > MAX_DEPTH {
        let limit = format!("more than {MAX_DEPTH} dictionaries and lists in each other");
        return Err(Failure::input(format!("{what}: {limit}, or one that holds itself: give plain values")));
    }
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
        return of_dict(what, value, depth).map(Value::Table);
    }
    // Arrays and scalars of NumPy.
    if let Ok(plain) = value.call_method0("tolist") {
        return of_value(what, &plain, depth + 1);
    }
    if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        let items = value.try_iter().map_err(|error| Failure::input(format!("{what}: {error}")))?;
        let items = items.enumerate().map(|(i, item)| {
            let item = item.map_err(|error| Failure::input(format!("{what}: {error}")))?;
            of_value(&format!("{what}.{i}"), &item, depth + 1)
        });
        return items.collect::<Answer<_>>().map(Value::Array);
    }
    Err(Failure::input(format!("{what}: {value} is nothing that TOML can say")))
}

/// A value as a dictionary of Python.
pub(crate) fn to_python<'py>(py: Python<'py>, what: &str, value: &impl Serialize) -> PyResult<Bound<'py, PyAny>> {
    // By way of TOML, so that what is given back is what can be given.
    Ok(pythonize(py, &patch::to_table(what, value).map_err(unreadable)?)?)
}

/// A value with what is given changes of it; a key that it does not have is refused.
pub(crate) fn patched<T: Serialize + DeserializeOwned>(what: &str, base: Option<&T>, patch: Table) -> Answer<T> {
    patch::patched(what, base, patch).map_err(unreadable)
}

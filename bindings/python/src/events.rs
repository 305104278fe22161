//! What has happened, as dictionaries.

use crate::error::Failure;
use crate::world::{State, World};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyString};
use pythonize::pythonize;
use rhexis::event::Event;
use serde::Serialize;

/// A record of the engine as a dictionary, keys of vertices, triangles and tips as numbers.
pub(crate) fn named<'py>(py: Python<'py>, value: &impl Serialize) -> PyResult<Bound<'py, PyDict>> {
    let told = pythonize(py, value)?;
    let told = told.cast_into::<PyDict>().map_err(|_| Failure::input("a record of the engine has no names"))?;
    plain(&told)?;
    Ok(told)
}

/// Numbers instead of keys in their parts, in a dictionary and all below it.
fn plain(dict: &Bound<'_, PyDict>) -> PyResult<()> {
    let inner: Vec<_> = dict.iter().filter_map(|(key, value)| Some((key, value.cast_into::<PyDict>().ok()?))).collect();
    for (key, value) in inner {
        match (value.get_item("idx")?, value.get_item("version")?) {
            (Some(index), Some(version)) if value.len() == 2 => {
                let bits = version.extract::<u64>()? << 32 | index.extract::<u64>()?;
                dict.set_item(key, bits)?;
            }
            _ => plain(&value)?,
        }
    }
    Ok(())
}

/// `FragmentFreed` as `fragment_freed`.
fn snake(name: &str) -> String {
    let mut snake = String::new();
    for letter in name.chars() {
        if letter.is_uppercase() && !snake.is_empty() {
            snake.push('_');
        }
        snake.extend(letter.to_lowercase());
    }
    snake
}

fn told<'py>(py: Python<'py>, state: &State, event: &Event) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    let kind = pythonize(py, &event.kind)?;
    // Kinds without fields are text, others a dictionary of one entry.
    let (name, fields) = match kind.cast::<PyDict>() {
        Ok(kind) => match kind.iter().next() {
            Some((name, fields)) => (name, fields.cast_into::<PyDict>().ok()),
            None => (PyString::new(py, "other").into_any(), None),
        },
        Err(_) => (kind.clone(), None),
    };
    all.set_item("kind", snake(&name.extract::<String>()?))?;
    all.set_item("step", event.step)?;
    all.set_item("time", event.time)?;
    all.set_item("body", state.handle(event.body))?;
    if let Some(fields) = fields {
        plain(&fields)?;
        for (key, value) in fields {
            let is_word = ["by", "course"].iter().any(|word| key.eq(word).unwrap_or(false));
            match value.extract::<String>() {
                Ok(word) if is_word => all.set_item(key, snake(&word))?,
                _ => all.set_item(key, value)?,
            }
        }
    }
    Ok(all)
}

#[pymethods]
impl World {
    /// Takes the events since the last call, in order.
    fn events<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        self.look_mut(|state| {
            let events = state.take_events();
            let list = PyList::empty(py);
            for event in &events {
                list.append(told(py, state, event)?)?;
            }
            Ok(list)
        })
    }
}

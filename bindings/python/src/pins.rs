//! Vertices held and let go, and what holds bear.

use crate::arrays::{keys, of_points, of_vector, points};
use crate::entity::BodyRef;
use crate::error::{Answer, Failure, refused};
use crate::world::World;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rhexis::glam::DVec3;
use rhexis::simulation::Pin;
use rhexis::storage::VertexKey;
use slotmap::{Key, KeyData};
use std::collections::HashMap;

/// Key of a vertex; bits that no key has are refused.
pub(crate) fn key(bits: u64) -> Answer<VertexKey> {
    let data = KeyData::from_ffi(bits);
    let wrong = || Failure::input(format!("{bits:#x} is no key of a vertex: take keys from vertex_keys"));
    (data.as_ffi() == bits).then(|| data.into()).ok_or_else(wrong)
}

/// Keys of vertices from an array.
pub(crate) fn vertex_keys(value: &Bound<'_, PyAny>) -> Answer<Vec<VertexKey>> {
    keys("vertices", value)?.into_iter().map(key).collect()
}

fn by_name<'py>(py: Python<'py>, list: Vec<(String, DVec3)>) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    list.into_iter().try_for_each(|(name, vector)| dict.set_item(name, of_vector(py, vector)))?;
    Ok(dict)
}

#[pymethods]
impl World {
    /// Holds vertices where they are now, under a name.
    #[pyo3(signature = (name, vertices, body = None))]
    fn pin(&self, py: Python<'_>, name: &str, vertices: &Bound<'_, PyAny>, body: Option<BodyRef>) -> PyResult<()> {
        let vertices = vertex_keys(vertices)?;
        self.with(py, |state| {
            let body = state.body(body.as_ref())?;
            state.simulation_mut().pin(body, name, &vertices).map_err(refused)
        })
    }

    /// Lets vertices go, whoever holds them.
    #[pyo3(signature = (vertices, body = None))]
    fn unpin(&self, py: Python<'_>, vertices: &Bound<'_, PyAny>, body: Option<BodyRef>) -> PyResult<()> {
        let vertices = vertex_keys(vertices)?;
        self.with(py, |state| {
            let body = state.body(body.as_ref())?;
            state.simulation_mut().unpin(body, &vertices).map_err(refused)
        })
    }

    /// Lets go what is pinned under a name.
    #[pyo3(signature = (name, body = None))]
    fn unpin_all(&self, py: Python<'_>, name: &str, body: Option<BodyRef>) -> PyResult<()> {
        self.with(py, |state| {
            let body = state.body(body.as_ref())?;
            state.simulation_mut().unpin_all(body, name).map_err(refused)
        })
    }

    /// What is pinned under a name, in the order of rows: keys, rest positions, places.
    #[pyo3(signature = (name, body = None))]
    fn pins<'py>(&self, py: Python<'py>, name: &str, body: Option<BodyRef>) -> PyResult<Bound<'py, PyDict>> {
        self.look_mut(|state| {
            let body = state.body(body.as_ref())?;
            let pins = state.simulation_mut().pins(body, name).map_err(refused)?;
            let list = |of: fn(&Pin) -> DVec3| of_points(py, &pins.iter().map(of).collect::<Vec<_>>());
            let told = PyDict::new(py);
            let vertices: Vec<u64> = pins.iter().map(|pin| pin.vertex.data().as_ffi()).collect();
            told.set_item("vertices", PyArray1::from_vec(py, vertices))?;
            told.set_item("rest_positions", list(|pin| pin.rest_position)?)?;
            told.set_item("places", list(|pin| pin.place)?)?;
            Ok(told)
        })
    }

    /// Moves what is pinned under a name by a way \[mm\], reached at the end of the next step.
    #[pyo3(signature = (name, way, body = None))]
    fn shift_pins(&self, py: Python<'_>, name: &str, way: [f64; 3], body: Option<BodyRef>) -> PyResult<()> {
        let way = DVec3::from_array(way);
        self.with(py, |state| {
            let body = state.body(body.as_ref())?;
            state.simulation_mut().move_pins(body, name, |pin| pin.place + way).map_err(refused)
        })
    }

    /// Moves what is pinned under a name to places \[mm\] in the order of `pins`, reached at the end of the next step.
    #[pyo3(signature = (name, places, body = None))]
    fn move_pins(&self, py: Python<'_>, name: &str, places: &Bound<'_, PyAny>, body: Option<BodyRef>) -> PyResult<()> {
        let places = points("places", places)?;
        self.with(py, |state| {
            let body = state.body(body.as_ref())?;
            let pins = state.simulation_mut().pins(body, name).map_err(refused)?;
            if pins.len() != places.len() {
                let message = format!("{} vertices are pinned, {} places are given", pins.len(), places.len());
                return Err(Failure::input(message));
            }
            let places: HashMap<_, _> = pins.iter().map(|pin| pin.vertex).zip(places).collect();
            let place = |pin: Pin| places.get(&pin.vertex).map_or(pin.place, |place| *place);
            state.simulation_mut().move_pins(body, name, place).map_err(refused)
        })
    }

    /// Forces \[N\] of holds and pins on a body at the last step, by name.
    #[pyo3(signature = (body = None))]
    fn reactions<'py>(&self, py: Python<'py>, body: Option<BodyRef>) -> PyResult<Bound<'py, PyDict>> {
        self.look(|state| {
            let body = state.body(body.as_ref())?;
            by_name(py, state.simulation().reactions(body).map_err(refused)?)
        })
    }

    /// Torques \[N mm\] of holds on a body at the last step, by name.
    #[pyo3(signature = (body = None))]
    fn torques<'py>(&self, py: Python<'py>, body: Option<BodyRef>) -> PyResult<Bound<'py, PyDict>> {
        self.look(|state| {
            let body = state.body(body.as_ref())?;
            by_name(py, state.simulation().torques(body).map_err(refused)?)
        })
    }

    /// Pushes a vertex with a force \[N\] for the next step.
    #[pyo3(signature = (vertex, force, body = None))]
    fn apply_force(&self, py: Python<'_>, vertex: u64, force: [f64; 3], body: Option<BodyRef>) -> PyResult<()> {
        let vertex = key(vertex)?;
        self.with(py, |state| {
            let body = state.body(body.as_ref())?;
            state.simulation_mut().apply_force(body, vertex, force.into()).map_err(refused)
        })
    }
}

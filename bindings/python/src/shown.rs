//! What bodies look like: arrays that are copies of Python's own, or lent where that is asked for.

use crate::arrays::{of_points, of_points_f32, table};
use crate::entity::BodyRef;
use crate::error::{Answer, Failure, Kind, refused};
use crate::lent::Column;
use crate::world::World;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rhexis::components::{ChangeSet, Changes};
use rhexis::glam::{DMat3, DVec3};
use rhexis::simulation::{BodyView, Tip};
use slotmap::Key;
use std::ops::Range;

impl World {
    fn copied<R>(&self, body: Option<BodyRef>, look: impl FnOnce(&BodyView<'_>) -> Answer<R>) -> PyResult<R> {
        self.show(body, |_, view, _| Ok(look(view)?))
    }

    /// Points of a body: Python's own, or read-only where the engine has them.
    fn points<'py>(
        &self,
        py: Python<'py>,
        (body, copy): (Option<BodyRef>, bool),
        column: Column,
        of: for<'a> fn(&BodyView<'a>) -> &'a [DVec3],
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.show(body, |body, view, loans| match copy {
            true => Ok(of_points(py, of(view))?),
            false => loans.points(py, body, column, of(view)),
        })
    }
}

fn ranges<'py>(py: Python<'py>, ranges: &[Range<u32>]) -> Answer<Bound<'py, PyArray2<u32>>> {
    table(py, 2, ranges.iter().flat_map(|range| [range.start, range.end]).collect())
}

#[pymethods]
impl World {
    /// Positions \[mm\], shape (n, 3).
    #[pyo3(signature = (body = None, *, copy = true))]
    fn positions<'py>(
        &self,
        py: Python<'py>,
        body: Option<BodyRef>,
        copy: bool,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.points(py, (body, copy), Column::Positions, |view| view.positions)
    }

    /// Positions \[mm\] in single precision.
    #[pyo3(signature = (body = None))]
    fn positions_f32<'py>(&self, py: Python<'py>, body: Option<BodyRef>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        self.copied(body, |view| of_points_f32(py, view.positions))
    }

    /// Positions at a time `behind` \[ms\] before now, on straight lines from where the last step began.
    #[pyo3(signature = (behind, body = None))]
    fn positions_before<'py>(
        &self,
        py: Python<'py>,
        behind: f64,
        body: Option<BodyRef>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.copied(body, |view| {
            if !behind.is_finite() {
                return Err(Failure::input(format!("a time of {behind} ms: it must be finite")));
            }
            let mut before = Vec::new();
            view.positions_before(behind, &mut before);
            of_points(py, &before)
        })
    }

    /// Positions of the rest shape \[mm\].
    #[pyo3(signature = (body = None, *, copy = true))]
    fn rest_positions<'py>(
        &self,
        py: Python<'py>,
        body: Option<BodyRef>,
        copy: bool,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.points(py, (body, copy), Column::RestPositions, |view| view.rest_positions)
    }

    /// Velocities \[mm/ms\].
    #[pyo3(signature = (body = None, *, copy = true))]
    fn velocities<'py>(
        &self,
        py: Python<'py>,
        body: Option<BodyRef>,
        copy: bool,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.points(py, (body, copy), Column::Velocities, |view| view.velocities)
    }

    /// Unit normals by vertex.
    #[pyo3(signature = (body = None))]
    fn normals<'py>(&self, py: Python<'py>, body: Option<BodyRef>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.copied(body, |view| {
            let mut normals = Vec::new();
            view.normals(&mut normals);
            of_points(py, &normals)
        })
    }

    /// Unit normals by vertex in single precision.
    #[pyo3(signature = (body = None))]
    fn normals_f32<'py>(&self, py: Python<'py>, body: Option<BodyRef>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        self.copied(body, |view| {
            let mut normals = Vec::new();
            view.normals(&mut normals);
            of_points_f32(py, &normals)
        })
    }

    /// Corners of the triangles, shape (m, 3).
    #[pyo3(signature = (body = None, *, copy = true))]
    fn indices<'py>(&self, py: Python<'py>, body: Option<BodyRef>, copy: bool) -> PyResult<Bound<'py, PyArray2<u32>>> {
        self.show(body, |body, view, loans| match copy {
            true => Ok(table(py, 3, view.triangles.as_flattened().to_vec())?),
            false => loans.corners(py, body, view),
        })
    }

    /// Keys of the vertices: they name a vertex as long as it lives.
    #[pyo3(signature = (body = None))]
    fn vertex_keys<'py>(&self, py: Python<'py>, body: Option<BodyRef>) -> PyResult<Bound<'py, PyArray1<u64>>> {
        self.copied(body, |view| {
            Ok(PyArray1::from_vec(py, view.vertex_keys.iter().map(|key| key.data().as_ffi()).collect()))
        })
    }

    /// Keys of the triangles.
    #[pyo3(signature = (body = None))]
    fn triangle_keys<'py>(&self, py: Python<'py>, body: Option<BodyRef>) -> PyResult<Bound<'py, PyArray1<u64>>> {
        self.copied(body, |view| {
            Ok(PyArray1::from_vec(py, view.triangle_keys.iter().map(|key| key.data().as_ffi()).collect()))
        })
    }

    /// Numbers of the host's own per vertex, shape (n, stride), of a body with the component Attributes.
    #[pyo3(signature = (body = None))]
    fn attributes<'py>(&self, py: Python<'py>, body: Option<BodyRef>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.copied(body, |view| {
            let none = || Failure::new(Kind::NotFound, "the body has no component Attributes: give it one by set");
            let attributes = view.attributes.ok_or_else(none)?;
            table(py, attributes.stride, attributes.values.clone())
        })
    }

    /// Keeps from now on what changes in a body's mesh; the first answer of `changes` is the whole mesh.
    #[pyo3(signature = (body = None))]
    fn track_changes(&self, body: Option<BodyRef>) -> PyResult<()> {
        self.look_mut(|state| {
            let body = state.body(body.as_ref())?;
            // It is there.
            let _ = state.simulation_mut().world_mut().insert_one(body.entity(), Changes::default());
            Ok(())
        })
    }

    /// Which rows of a body's mesh have changed since the last call, as ranges of shape (k, 2).
    #[pyo3(signature = (body = None))]
    fn changes<'py>(&self, py: Python<'py>, body: Option<BodyRef>) -> PyResult<Bound<'py, PyDict>> {
        self.look_mut(|state| {
            let body = state.body(body.as_ref())?;
            if state.simulation().world().get::<&Changes>(body.entity()).is_err() {
                return Err(Failure::new(Kind::NotFound, "nothing is kept: call track_changes first").into());
            }
            let mut set = ChangeSet::default();
            state.simulation_mut().drain_changes(body, &mut set).map_err(refused)?;
            let told = PyDict::new(py);
            told.set_item("is_whole", set.is_whole)?;
            told.set_item("vertex_count", set.vertex_count)?;
            told.set_item("triangle_count", set.triangle_count)?;
            told.set_item("vertices", ranges(py, &set.vertices)?)?;
            told.set_item("triangles", ranges(py, &set.triangles)?)?;
            Ok(told)
        })
    }

    /// Tear tips that are alive: keys, vertices, positions, rest positions, directions.
    #[pyo3(signature = (body = None))]
    fn tips<'py>(&self, py: Python<'py>, body: Option<BodyRef>) -> PyResult<Bound<'py, PyDict>> {
        self.look(|state| {
            let body = state.body(body.as_ref())?;
            let tips = state.simulation().tips(body).map_err(refused)?;
            let list = |of: fn(&Tip) -> DVec3| of_points(py, &tips.iter().map(of).collect::<Vec<_>>());
            let keys = |of: fn(&Tip) -> u64| PyArray1::from_vec(py, tips.iter().map(of).collect());
            let told = PyDict::new(py);
            told.set_item("keys", keys(|tip| tip.key.data().as_ffi()))?;
            told.set_item("vertices", keys(|tip| tip.vertex.data().as_ffi()))?;
            told.set_item("positions", list(|tip| tip.position)?)?;
            told.set_item("rest_positions", list(|tip| tip.rest_position)?)?;
            told.set_item("directions", list(|tip| tip.direction)?)?;
            Ok(told)
        })
    }

    /// Fragments that a body has come apart into: number by vertex and by triangle, and areas \[mm²\].
    #[pyo3(signature = (body = None))]
    fn fragments<'py>(&self, py: Python<'py>, body: Option<BodyRef>) -> PyResult<Bound<'py, PyDict>> {
        self.look(|state| {
            let body = state.body(body.as_ref())?;
            let fragments = state.simulation().fragments(body).map_err(refused)?;
            let told = PyDict::new(py);
            told.set_item("count", fragments.count())?;
            told.set_item("of_vertex", PyArray1::from_vec(py, fragments.of_vertex))?;
            told.set_item("of_triangle", PyArray1::from_vec(py, fragments.of_triangle))?;
            told.set_item("areas", PyArray1::from_vec(py, fragments.areas))?;
            Ok(told)
        })
    }

    /// Elastic and kinetic energy of a body \[mJ\].
    #[pyo3(signature = (body = None))]
    fn energies<'py>(&self, py: Python<'py>, body: Option<BodyRef>) -> PyResult<Bound<'py, PyDict>> {
        self.look_mut(|state| {
            let body = state.body(body.as_ref())?;
            let energies = state.simulation_mut().energies(body).map_err(refused)?;
            let told = PyDict::new(py);
            told.set_item("elastic", energies.elastic)?;
            told.set_item("kinetic", energies.kinetic)?;
            Ok(told)
        })
    }

    /// Fields of a body per triangle: stress \[MPa\], principal stress, fibre, and the tear criterion where it can tear.
    #[pyo3(signature = (body = None))]
    fn fields<'py>(&self, py: Python<'py>, body: Option<BodyRef>) -> PyResult<Bound<'py, PyDict>> {
        self.look_mut(|state| {
            let body = state.body(body.as_ref())?;
            let place = state.simulation().bodies().iter().position(|&other| other == body);
            let mut frame = state.simulation_mut().frame();
            let none = || Failure::handle("the body is not in the picture");
            let place = place.filter(|&place| place < frame.bodies.len()).ok_or_else(none)?;
            let shown = frame.bodies.swap_remove(place);
            let told = PyDict::new(py);
            let stress = shown.stress.iter().flat_map(DMat3::to_cols_array).collect();
            told.set_item("stress", table::<f64>(py, 9, stress)?)?;
            let principal = shown.principal_stress.iter().flat_map(|pair| pair.to_array()).collect();
            told.set_item("principal_stress", table::<f64>(py, 2, principal)?)?;
            told.set_item("fibre", of_points(py, &shown.fibres)?)?;
            told.set_item("force", of_points(py, &shown.forces)?)?;
            if !shown.criterion.is_empty() {
                told.set_item("criterion", PyArray1::from_vec(py, shown.criterion))?;
            }
            Ok(told)
        })
    }
}

//! Figures of a rhexis: how a tear drawn by forceps has gone round.

use crate::arrays::of_vector;
use crate::entity::BodyRef;
use crate::error::{Failure, Kind};
use crate::world::World;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use pythonize::pythonize;
use rhexis_scene::course::CourseReport;
use rhexis_scene::measures::TearCourse;

#[pymethods]
impl World {
    /// Follows the tears of a body from its present state on; its figures are those of `course`.
    #[pyo3(signature = (body = None))]
    fn follow_course(&self, body: Option<BodyRef>) -> PyResult<()> {
        self.look_mut(|state| {
            let body = state.body(body.as_ref())?;
            // What has happened until now is no part of the course.
            let before = state.take_events();
            state.events = before;
            let simulation = state.simulation();
            let course = TearCourse::new(simulation.world(), body, simulation.time());
            let none = || Failure::input("the body has no rim that a tear could go round in");
            let course = course.ok_or_else(none)?;
            state.courses.retain(|course| course.body() != body);
            state.courses.push(course);
            Ok(())
        })
    }

    /// Figures of a tear's course, with the keys of `course` in `report.json`, and the axis.
    #[pyo3(signature = (body = None))]
    fn course<'py>(&self, py: Python<'py>, body: Option<BodyRef>) -> PyResult<Bound<'py, PyDict>> {
        self.look(|state| {
            let body = state.body(body.as_ref())?;
            let none = || Failure::new(Kind::NotFound, "the body's tears are not followed: call follow_course first");
            let course = state.courses.iter().find(|course| course.body() == body).ok_or_else(none)?;
            let told = pythonize(py, &CourseReport::of(course))?.cast_into::<PyDict>()?;
            told.set_item("axis_point", of_vector(py, course.axis().point))?;
            told.set_item("axis_direction", of_vector(py, course.axis().direction))?;
            Ok(told)
        })
    }
}

//! Figures of a rhexis: how a tear drawn by forceps has gone round.

use crate::arrays::of_vector;
use crate::entity::BodyRef;
use crate::error::{Failure, Kind};
use crate::world::World;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use rhexis::report::{CourseFigures, Opening, Outcome, TearCourse};

fn figures_told<'py>(py: Python<'py>, figures: &CourseFigures) -> PyResult<Bound<'py, PyDict>> {
    let outcome = match figures.outcome {
        Outcome::Closed => "closed",
        Outcome::RanOut => "ran_out",
        Outcome::TornOff => "torn_off",
        Outcome::Unfinished => "unfinished",
    };
    let (opening, lies) = (figures.opening.as_ref(), figures.opening_as_it_lies.as_ref());
    let of = |opening: Option<&Opening>, figure: fn(&Opening) -> f64| opening.map(figure);
    let told = PyDict::new(py);
    told.set_item("outcome", outcome)?;
    told.set_item("completion_deg", figures.completion.to_degrees())?;
    told.set_item("diameter_mm", of(opening, |o| o.diameter))?;
    told.set_item("circularity", of(opening, |o| o.circularity))?;
    told.set_item("decentration_mm", of(opening, |o| o.decentration))?;
    told.set_item("diameter_as_it_lies_mm", of(lies, |o| o.diameter))?;
    told.set_item("circularity_as_it_lies", of(lies, |o| o.circularity))?;
    told.set_item("largest_radius_mm", opening.map_or(figures.largest_radius, |o| o.largest_radius))?;
    told.set_item("grasps", figures.grasps)?;
    told.set_item("time_ms", figures.time)?;
    told.set_item("force_rms_n", figures.force_rms)?;
    told.set_item("force_peak_n", figures.force_peak)?;
    Ok(told)
}

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
            let told = figures_told(py, &course.figures())?;
            let grasps = PyList::empty(py);
            for grasp in course.grasps() {
                let row = PyDict::new(py);
                row.set_item("from_ms", grasp.from)?;
                row.set_item("until_ms", grasp.until)?;
                row.set_item("force_mean_n", grasp.force_mean)?;
                row.set_item("force_rms_n", grasp.force_rms)?;
                row.set_item("force_peak_n", grasp.force_peak)?;
                grasps.append(row)?;
            }
            told.set_item("force_by_grasp", grasps)?;
            told.set_item("axis_point", of_vector(py, course.axis().point))?;
            told.set_item("axis_direction", of_vector(py, course.axis().direction))?;
            Ok(told)
        })
    }
}

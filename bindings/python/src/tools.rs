//! Forceps, blade and needle, cuts, and what they point at.

use crate::arrays::{of_points, of_vector, points};
use crate::entity::{BodyRef, Entity};
use crate::error::{Answer, Failure, refused};
use crate::pins::vertex_keys;
use crate::world::World;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rhexis::components::{Jaws, Pose, Slip};
use rhexis::glam::{DQuat, DVec3};
use rhexis::simulation::{Cut, Grasp, Hit};
use rhexis::storage::{BladeId, ForcepsId};
use slotmap::Key;

type Ray = ([f64; 3], [f64; 3], f64);

/// The one grasp that the keywords name; the nearest point within 1 mm where they name none.
fn grasp(
    nearest: Option<f64>,
    ray: Option<Ray>,
    point: Option<[f64; 3]>,
    vertices: Option<&Bound<'_, PyAny>>,
) -> Answer<Grasp> {
    match (nearest, ray, point, vertices) {
        (None, None, None, None) => Ok(Grasp::Nearest { reach: 1.0 }),
        (Some(reach), None, None, None) => Ok(Grasp::Nearest { reach }),
        (None, Some((origin, direction, reach)), None, None) => {
            Ok(Grasp::Ray { origin: origin.into(), direction: direction.into(), reach })
        }
        (None, None, Some(point), None) => Ok(Grasp::Point(point.into())),
        (None, None, None, Some(vertices)) => vertex_keys(vertices).map(Grasp::Vertices),
        _ => Err(Failure::input("jaws close about one thing: give one of nearest, ray, point and vertices")),
    }
}

fn cut_told<'py>(py: Python<'py>, cut: &Cut) -> PyResult<Bound<'py, PyDict>> {
    let told = PyDict::new(py);
    told.set_item("asked", cut.asked)?;
    told.set_item("made", cut.made)?;
    told.set_item("off_line", cut.off_line)?;
    told.set_item("smallest_angle", cut.smallest_angle)?;
    told.set_item("strokes", cut.strokes.len())?;
    told.set_item("tips", cut.tips.iter().map(|tip| tip.data().as_ffi()).collect::<Vec<u64>>())?;
    told.set_item("fragments", cut.fragment_count)?;
    told.set_item("path", of_points(py, &cut.path)?)?;
    Ok(told)
}

fn hit_told<'py>(py: Python<'py>, hit: Option<Hit>) -> PyResult<Option<Bound<'py, PyDict>>> {
    let Some(hit) = hit else { return Ok(None) };
    let told = PyDict::new(py);
    told.set_item("triangle", hit.triangle.data().as_ffi())?;
    told.set_item("corners", hit.corners.map(|key| key.data().as_ffi()))?;
    told.set_item("weights", hit.barycentric)?;
    told.set_item("position", of_vector(py, hit.position))?;
    told.set_item("rest_position", of_vector(py, hit.rest_position))?;
    told.set_item("normal", of_vector(py, hit.normal))?;
    told.set_item("distance", hit.distance)?;
    Ok(Some(told))
}

#[pymethods]
impl World {
    /// Puts open forceps into the world.
    #[pyo3(signature = (name = "forceps", position = [0.0; 3], orientation = [0.0, 0.0, 0.0, 1.0], *, radius = 0.2, stiffness = None, force_limit = None, slides = false))]
    #[allow(clippy::too_many_arguments, reason = "keywords of Python")]
    fn spawn_forceps(
        &self,
        py: Python<'_>,
        name: &str,
        position: [f64; 3],
        orientation: [f64; 4],
        radius: f64,
        stiffness: Option<f64>,
        force_limit: Option<f64>,
        slides: bool,
    ) -> PyResult<Entity> {
        let pose = Pose { position: position.into(), orientation: DQuat::from_array(orientation) };
        let slip = if slides { Slip::Slide } else { Slip::LetGo };
        let jaws = Jaws { radius, stiffness, force_limit, slip };
        self.with(py, |state| {
            let made = state.simulation_mut().spawn_forceps(name, jaws, pose).map_err(refused)?;
            Ok::<_, Failure>(state.handle(made))
        })
    }

    /// Closes forceps on a body; tells how many vertices they hold.
    #[pyo3(signature = (forceps, body = None, *, nearest = None, ray = None, point = None, vertices = None))]
    #[allow(clippy::too_many_arguments, reason = "keywords of Python")]
    fn close_forceps(
        &self,
        py: Python<'_>,
        forceps: Entity,
        body: Option<BodyRef>,
        nearest: Option<f64>,
        ray: Option<Ray>,
        point: Option<[f64; 3]>,
        vertices: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<usize> {
        let grasp = grasp(nearest, ray, point, vertices)?;
        self.with(py, |state| {
            let (forceps, body) = (ForcepsId::from(state.entity(forceps)?), state.body(body.as_ref())?);
            state.simulation_mut().close_forceps(forceps, body, &grasp).map_err(refused)
        })
    }

    /// Moves forceps to a pose, evenly within a time \[ms\]; without an orientation they keep theirs.
    #[pyo3(signature = (forceps, position, orientation = None, *, within))]
    fn move_forceps(
        &self,
        py: Python<'_>,
        forceps: Entity,
        position: [f64; 3],
        orientation: Option<[f64; 4]>,
        within: f64,
    ) -> PyResult<()> {
        self.with(py, |state| {
            let forceps = ForcepsId::from(state.entity(forceps)?);
            let simulation = state.simulation_mut();
            let now = simulation.forceps(forceps).map_err(refused)?.motion.at(simulation.time());
            let orientation = orientation.map_or(now.orientation, DQuat::from_array);
            let pose = Pose { position: position.into(), orientation };
            simulation.move_forceps(forceps, pose, within).map_err(refused)
        })
    }

    /// Opens forceps: they let go.
    fn open_forceps(&self, py: Python<'_>, forceps: Entity) -> PyResult<bool> {
        self.with(py, |state| {
            let forceps = ForcepsId::from(state.entity(forceps)?);
            state.simulation_mut().open_forceps(forceps).map_err(refused)
        })
    }

    /// State of forceps: pose, held vertices, force, and distance \[mm\] of the hand ahead of the jaws.
    fn forceps<'py>(&self, py: Python<'py>, forceps: Entity) -> PyResult<Bound<'py, PyDict>> {
        self.look(|state| {
            let forceps = ForcepsId::from(state.entity(forceps)?);
            let tool = state.simulation().forceps(forceps).map_err(refused)?;
            let pose = tool.motion.at(state.simulation().time());
            let told = PyDict::new(py);
            told.set_item("name", &tool.name)?;
            told.set_item("position", of_vector(py, pose.position))?;
            told.set_item("orientation", numpy::PyArray1::from_slice(py, &pose.orientation.to_array()))?;
            told.set_item("force", of_vector(py, tool.force))?;
            told.set_item("torque", of_vector(py, tool.torque))?;
            told.set_item("body", tool.body.map(|body| state.handle(body)))?;
            told.set_item("hand_ahead", state.simulation().hand_ahead(forceps).map_err(refused)?)?;
            Ok(told)
        })
    }

    /// Cuts a body along a line through points of the rest shape \[mm\].
    #[pyo3(signature = (line, body = None))]
    fn cut<'py>(
        &self,
        py: Python<'py>,
        line: &Bound<'_, PyAny>,
        body: Option<BodyRef>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let line = points("the line", line)?;
        let made = self.with(py, |state| {
            let body = state.body(body.as_ref())?;
            state.simulation_mut().cut(body, &line).map_err(refused)
        })?;
        cut_told(py, &made)
    }

    /// Punctures a body where its surface is nearest to a point \[mm\]: a slit of a length along a direction.
    #[pyo3(signature = (point, direction, length, body = None))]
    fn puncture<'py>(
        &self,
        py: Python<'py>,
        point: [f64; 3],
        direction: [f64; 3],
        length: f64,
        body: Option<BodyRef>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (point, direction) = (DVec3::from_array(point), DVec3::from_array(direction));
        let made = self.with(py, |state| {
            let body = state.body(body.as_ref())?;
            state.simulation_mut().puncture(body, point, direction, length).map_err(refused)
        })?;
        cut_told(py, &made)
    }

    /// Puts a blade into the world, out of any tissue.
    #[pyo3(signature = (reach, least))]
    fn spawn_blade(&self, py: Python<'_>, reach: f64, least: f64) -> PyResult<Entity> {
        self.with(py, |state| {
            let made = state.simulation_mut().spawn_blade(reach, least).map_err(refused)?;
            Ok::<_, Failure>(state.handle(made))
        })
    }

    /// Draws the edge of a blade to a point \[mm\]; tells what it has cut, or nothing where the stroke is saved up.
    #[pyo3(signature = (blade, edge, body = None))]
    fn draw_blade<'py>(
        &self,
        py: Python<'py>,
        blade: Entity,
        edge: [f64; 3],
        body: Option<BodyRef>,
    ) -> PyResult<Option<Bound<'py, PyDict>>> {
        let made = self.with(py, |state| {
            let (blade, body) = (BladeId::from(state.entity(blade)?), state.body(body.as_ref())?);
            state.simulation_mut().draw_blade(blade, body, edge.into()).map_err(refused)
        })?;
        made.as_ref().map(|made| cut_told(py, made)).transpose()
    }

    /// The point of a body's surface that is nearest to a point, no farther than `within` \[mm\].
    #[pyo3(signature = (point, within, body = None))]
    fn nearest<'py>(
        &self,
        py: Python<'py>,
        point: [f64; 3],
        within: f64,
        body: Option<BodyRef>,
    ) -> PyResult<Option<Bound<'py, PyDict>>> {
        self.look(|state| {
            let body = state.body(body.as_ref())?;
            hit_told(py, state.simulation().nearest(body, point.into(), within))
        })
    }

    /// The first point of a body's surface on a ray, no farther than `within` \[mm\].
    #[pyo3(signature = (origin, direction, within, body = None))]
    fn cast_ray<'py>(
        &self,
        py: Python<'py>,
        origin: [f64; 3],
        direction: [f64; 3],
        within: f64,
        body: Option<BodyRef>,
    ) -> PyResult<Option<Bound<'py, PyDict>>> {
        self.look(|state| {
            let body = state.body(body.as_ref())?;
            hit_told(py, state.simulation().cast_ray(body, origin.into(), direction.into(), within))
        })
    }

    /// Where a point of the rest shape is now.
    #[pyo3(signature = (rest_point, body = None))]
    fn current<'py>(
        &self,
        py: Python<'py>,
        rest_point: [f64; 3],
        body: Option<BodyRef>,
    ) -> PyResult<Option<Bound<'py, PyDict>>> {
        self.look(|state| {
            let body = state.body(body.as_ref())?;
            hit_told(py, state.simulation().current(body, rest_point.into()))
        })
    }
}

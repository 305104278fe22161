//! Bodies from arrays, and obstacles.

use crate::arrays::{points, triangles};
use crate::entity::{BodyRef, Entity};
use crate::error::{Answer, Failure, refused, unreadable};
use crate::toml_form::{given, patched, to_python};
use crate::world::{World, equip};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rhexis::components::{Fibres, Material, Obstacle};
use rhexis::membrane::Membrane;
use rhexis::storage::TriangleMesh;
use rhexis_scene::patch::patched_rigid;
use serde::{Deserialize, Serialize};
use toml::Table;

/// Material as TOML and dictionaries give it; keys that are not named are those of Figure 2.
#[derive(Serialize, Deserialize)]
struct MaterialValues {
    young_fibre: f64,
    young_transverse: f64,
    poisson_major: f64,
    shear_modulus: f64,
    thickness: f64,
    density: f64,
}

fn material(values: Option<&Bound<'_, PyAny>>) -> Answer<Material> {
    let base = Material::allard_2009();
    let base = MaterialValues {
        young_fibre: base.young_fibre,
        young_transverse: base.young_transverse,
        poisson_major: base.poisson_major,
        // Zero for Huber's.
        shear_modulus: base.shear_modulus.unwrap_or(0.0),
        thickness: base.thickness,
        density: base.density,
    };
    let MaterialValues { young_fibre, young_transverse, poisson_major, shear_modulus, thickness, density } =
        patched("material", Some(&base), given("material", values, None)?)?;
    let shear_modulus = (shear_modulus != 0.0).then_some(shear_modulus);
    Ok(Material { young_fibre, young_transverse, poisson_major, shear_modulus, thickness, density })
}

/// One direction of shape (3,), or one per triangle of shape (m, 3).
fn fibres(value: Option<&Bound<'_, PyAny>>) -> Answer<Fibres> {
    let Some(value) = value else { return Ok(Fibres::at_degrees(0.0)) };
    match value.extract::<[f64; 3]>() {
        Ok(direction) => Ok(Fibres::Uniform(direction.into())),
        Err(_) => points("fibres", value).map(Fibres::PerTriangle),
    }
}

fn components(given_all: Option<&Bound<'_, PyDict>>) -> Answer<Vec<(String, Table)>> {
    let all = given_all.into_iter().flatten();
    let read = |(name, values): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
        let name = name.extract::<String>().map_err(|_| Failure::input(format!("components: {name} is no name")))?;
        let values = given(&name, Some(&values), None)?;
        Ok((name, values))
    };
    all.map(read).collect()
}

#[pymethods]
impl World {
    /// Puts a body into the world; the arrays are copied.
    #[pyo3(signature = (vertices, triangles, fibres = None, *, name = "body", material = None, planar = false, components = None))]
    #[allow(clippy::too_many_arguments, reason = "keywords of Python")]
    fn spawn(
        &self,
        py: Python<'_>,
        vertices: &Bound<'_, PyAny>,
        triangles: &Bound<'_, PyAny>,
        fibres: Option<&Bound<'_, PyAny>>,
        name: &str,
        material: Option<&Bound<'_, PyAny>>,
        planar: bool,
        components: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Entity> {
        let positions = points("vertices", vertices)?;
        let triangles = self::triangles("triangles", triangles)?;
        let mesh = TriangleMesh { positions, triangles, fibres: None };
        let membrane = Membrane::new(name, mesh, self::material(material)?).fibres(self::fibres(fibres)?);
        let membrane = if planar { membrane.planar() } else { membrane };
        let components = self::components(components)?;
        self.with(py, |state| {
            let body = state.simulation_mut().spawn(membrane).map_err(refused)?;
            equip(state, body, components)?;
            Ok::<_, Failure>(state.handle(body))
        })
    }

    /// Gives all triangles of a body another material while it runs; keys that are not named are those of Figure 2.
    #[pyo3(signature = (material, body = None))]
    fn set_material(&self, py: Python<'_>, material: &Bound<'_, PyAny>, body: Option<BodyRef>) -> PyResult<()> {
        let material = self::material(Some(material))?;
        self.with(py, |state| {
            let body = state.body(body.as_ref())?;
            state.simulation_mut().set_material(body, |_, _| material).map_err(refused)
        })
    }

    /// Puts an obstacle into the world.
    #[pyo3(signature = (values = None, /, **keywords))]
    fn spawn_obstacle(
        &self,
        py: Python<'_>,
        values: Option<&Bound<'_, PyAny>>,
        keywords: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Entity> {
        let shape: Obstacle = patched("Obstacle", None, given("Obstacle", values, keywords)?)?;
        self.with(py, |state| {
            let made = state.simulation_mut().spawn_obstacle(shape).map_err(refused)?;
            Ok::<_, Failure>(state.handle(made))
        })
    }

    /// Makes an obstacle a rigid body that tissue pushes, or changes its motion; without keywords it yields to nothing any more.
    #[pyo3(signature = (obstacle, /, **keywords))]
    fn set_rigid(&self, py: Python<'_>, obstacle: Entity, keywords: Option<&Bound<'_, PyDict>>) -> PyResult<()> {
        let patch = given("Rigid", None, keywords)?;
        self.with(py, |state| {
            let obstacle = state.obstacle(obstacle)?;
            let rigid = patched_rigid(state.simulation(), obstacle, patch).map_err(unreadable)?;
            state.simulation_mut().set_rigid(obstacle, rigid).map_err(refused)
        })
    }

    /// Mass and motion of a rigid obstacle, and the impulse of tissue in the last step; None for one that yields to nothing.
    fn rigid<'py>(&self, py: Python<'py>, obstacle: Entity) -> PyResult<Option<Bound<'py, PyAny>>> {
        let found = self.look(|state| Ok(state.simulation().rigid(state.obstacle(obstacle)?).map_err(refused)?))?;
        found.map(|rigid| to_python(py, "Rigid", &rigid)).transpose()
    }
}

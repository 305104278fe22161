//! Components of bodies, obstacles and tools, by their names.

use crate::entity::BodyRef;
use crate::error::{Answer, Failure, Kind, refused};
use crate::toml_form::{given, patched, to_python};
use crate::world::World;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rhexis::components::*;
use rhexis::hecs::Entity;
use rhexis::simulation::{Parameter, Simulation};
use serde::{Serialize, de::DeserializeOwned};
use toml::Table;

/// What can be done with a component by its name.
pub(crate) struct Entry {
    name: &'static str,
    pub(crate) set: fn(&mut Simulation, Entity, Table) -> Answer<()>,
    unset: fn(&mut Simulation, Entity) -> Answer<bool>,
    get: Getter,
}

type Getter = for<'py> fn(&Simulation, Entity, Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>>;

macro_rules! entries {
    ($($component:ident $(or $default:expr)?;)*) => {
        const ENTRIES: &[Entry] = &[$(Entry {
            name: stringify!($component),
            set: |simulation, entity, values| {
                let default: Option<$component> = None$(.or(Some($default)))?;
                set::<$component>(simulation, entity, default, values)
            },
            unset: |simulation, entity| simulation.unset::<$component>(entity).map_err(refused),
            get: |simulation, entity, py| {
                let found = simulation.world().get::<&$component>(entity);
                found.ok().map(|found| to_python(py, <$component as Parameter>::NAME, &*found)).transpose()
            },
        },)*];
    };
}

rhexis::recorded_components!(entries);

fn set<C: Parameter + Serialize + DeserializeOwned>(
    simulation: &mut Simulation,
    entity: Entity,
    default: Option<C>,
    values: Table,
) -> Answer<()> {
    let present = simulation.world().get::<&C>(entity).ok().map(|present| (*present).clone());
    let component = patched(C::NAME, present.or(default).as_ref(), values)?;
    simulation.set(entity, component).map_err(refused)
}

pub(crate) fn entry(name: &str) -> Answer<&'static Entry> {
    ENTRIES.iter().find(|entry| entry.name == name).ok_or_else(|| {
        let names = || ENTRIES.iter().map(|entry| entry.name);
        let near =
            rhexis_scene::nearest(name, names()).map_or(String::new(), |near| format!("did you mean `{near}`? "));
        let known = names().collect::<Vec<_>>().join(", ");
        Failure::new(Kind::NotFound, format!("there is no component `{name}`; {near}there are {known}"))
    })
}

/// Names of all components, in order.
#[pyfunction]
pub(crate) fn component_names() -> Vec<&'static str> {
    ENTRIES.iter().map(|entry| entry.name).collect()
}

#[pymethods]
impl World {
    /// Gives an entity a component, or changes keys of the one that it has.
    #[pyo3(signature = (entity, component, values = None, /, **keywords))]
    fn set(
        &self,
        py: Python<'_>,
        entity: BodyRef,
        component: &str,
        values: Option<&Bound<'_, PyAny>>,
        keywords: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<()> {
        let entry = entry(component)?;
        let values = given(component, values, keywords)?;
        self.with(py, |state| {
            let entity = state.any(&entity)?;
            (entry.set)(state.simulation_mut(), entity, values)
        })
    }

    /// Takes a component off; tells whether it was there.
    fn unset(&self, py: Python<'_>, entity: BodyRef, component: &str) -> PyResult<bool> {
        let entry = entry(component)?;
        self.with(py, |state| {
            let entity = state.any(&entity)?;
            (entry.unset)(state.simulation_mut(), entity)
        })
    }

    /// The component of an entity as a dictionary that `set` reads.
    fn get<'py>(&self, py: Python<'py>, entity: BodyRef, component: &str) -> PyResult<Bound<'py, PyAny>> {
        let entry = entry(component)?;
        self.look(|state| {
            let entity = state.any(&entity)?;
            let found = (entry.get)(state.simulation(), entity, py)?;
            let none = || Failure::new(Kind::NotFound, format!("the entity has no component {component}"));
            Ok(found.ok_or_else(none)?)
        })
    }

    /// Settings of the next steps as a dictionary.
    #[getter]
    fn settings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.look(|state| to_python(py, "settings", state.simulation().settings()))
    }

    /// Changes settings of the next steps by TOML, a dictionary or keywords.
    #[pyo3(signature = (values = None, /, **keywords))]
    fn set_settings(
        &self,
        py: Python<'_>,
        values: Option<&Bound<'_, PyAny>>,
        keywords: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<()> {
        let values = given("settings", values, keywords)?;
        self.with(py, |state| {
            let changed = patched("settings", Some(state.simulation().settings()), values)?;
            state.simulation_mut().set_settings(changed).map_err(refused)
        })
    }
}

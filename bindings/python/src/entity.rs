//! Handles of bodies, obstacles and tools.

use crate::error::{Answer, Failure};
use pyo3::prelude::*;
use rhexis::hecs;

/// Handle of a body, an obstacle or a tool of one world.
#[pyclass(frozen, eq, hash, module = "rhexis", from_py_object)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Entity {
    /// Number of the world.
    world: u64,
    entity: hecs::Entity,
}

impl Entity {
    pub(crate) fn new(world: u64, entity: hecs::Entity) -> Self {
        Self { world, entity }
    }

    /// The engine's handle, for the world of this number.
    pub(crate) fn of(self, world: u64) -> Answer<hecs::Entity> {
        if self.world == world {
            return Ok(self.entity);
        }
        Err(Failure::handle(format!("{} is of another world than this one, number {world}", self.__repr__())))
    }
}

#[pymethods]
impl Entity {
    /// Index and generation as one number.
    #[getter]
    fn bits(&self) -> u64 {
        self.entity.to_bits().get()
    }

    fn __repr__(&self) -> String {
        format!("<rhexis.Entity {:?} of world {}>", self.entity, self.world)
    }
}

/// A body by its handle or by its name.
#[derive(FromPyObject)]
pub(crate) enum BodyRef {
    #[pyo3(transparent)]
    Entity(Entity),
    #[pyo3(transparent)]
    Name(String),
}

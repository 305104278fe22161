//! Content of a body's compartment.

use super::Simulation;
use crate::components::CompartmentState;
use crate::storage::BodyId;
use hecs::Ref;

impl Simulation {
    /// Volume, content, pressure and leaks of a body's [`Compartment`](crate::components::Compartment); `None` where it has none.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// use rhexis::components::{Compartment, Content};
    ///
    /// let content = Content { density: 1.1e-3, ..Content::default() };
    /// simulation.set(body, Compartment { content, chamber: 100.0, ..Compartment::default() })?;
    /// let state = simulation.compartment(body).ok_or("no compartment")?;
    /// assert_eq!([state.pressure, state.leaked, state.opening], [0.0; 3]);
    /// assert!(state.volume == state.content && state.volume > 0.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn compartment(&self, body: BodyId) -> Option<Ref<'_, CompartmentState>> {
        self.world.get::<&CompartmentState>(body.entity()).ok()
    }
}

//! Forces of the host that act in one step.

use crate::components::BodyError;
use crate::components::check::{Check, Host, at_row, finite};
use crate::storage::EditRecord;
use glam::DVec3;

/// Forces on single vertices in the next step or static solve, which uses them up; given by
/// [`Simulation::apply_force`](crate::simulation::Simulation::apply_force). *State.*
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct StepForces {
    /// Vertex row and force \[N\], in the order in which they were given.
    pub list: Vec<(u32, DVec3)>,
}

impl StepForces {
    /// Follows an edit as [`PointLoads`](crate::components::PointLoads) do: a force stays whole with its vertex, or goes to the heir of one
    /// that is collapsed.
    pub fn follow(&mut self, record: &EditRecord) {
        self.list.iter_mut().for_each(|(row, _)| *row = record.heir(*row));
    }
}

impl Check for StepForces {
    fn check(&self, host: &Host<'_>) -> Result<(), BodyError> {
        host.rows("StepForces", || "a force".to_owned(), self.list.iter().map(|(row, _)| row))?;
        let is_right =
            |&(row, force): &(u32, DVec3)| finite("StepForces", "force", force.to_array()).map_err(at_row(row));
        self.list.iter().try_for_each(is_right)
    }
}

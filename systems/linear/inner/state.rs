//! What an inner solver is made of anew. All but the numbers that multigrid keeps from solve to solve follows from the mesh.

use super::InnerSolver;
use super::multigrid::{Multigrid, MultigridState};
use crate::storage::{Topology, Triangles, Vertices};

/// What a snapshot keeps of an inner solver.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct InnerState {
    multigrid: MultigridState,
}

impl InnerSolver {
    /// What a snapshot keeps, of a body with these triangles.
    pub fn state(&self, triangles: &Triangles) -> InnerState {
        InnerState { multigrid: self.multigrid.state(self.corners == triangles.corners) }
    }

    /// The solver of a state, which goes on as the one did that it was kept of; `None` where it is not of this mesh.
    pub fn of_state(state: &InnerState, mesh: (&Vertices, &Triangles, &Topology)) -> Option<Self> {
        let mut solver = Self::default();
        if Multigrid::is_numbered(&state.multigrid) {
            solver.follow(&mesh.1.corners, mesh.2);
        }
        solver.multigrid = Multigrid::of_state(&state.multigrid, &solver.partition, &solver.order, mesh)?;
        Some(solver)
    }
}

//! Data to remake a mixed-precision solver from: multigrid's part from solve to solve, the order of the rows, and the
//! triangles that the order was found for. The order is kept because edits of the mesh leave rows where they are. The rest follows.

use super::dissection::Dissection;
use super::multigrid::{Multigrid, MultigridState};
use super::{MixedSolver, Order, partition};
use crate::storage::{Revision, Topology, Triangles, Vertices};

/// Saved state of a mixed-precision solver.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct MixedState {
    corners: Vec<[u32; 3]>,
    /// The vertex of every row.
    vertex: Vec<u32>,
    changed: u32,
    dissection: Dissection,
    multigrid: MultigridState,
}

impl MixedSolver {
    /// Snapshot state, of a body with these triangles.
    pub fn state(&self, triangles: &Triangles) -> MixedState {
        let corners = self.corners();
        let is_current = corners == triangles.corners;
        MixedState {
            corners,
            vertex: self.order.vertex.clone(),
            changed: self.order.changed as u32,
            dissection: self.order.dissection,
            multigrid: self.multigrid.state(is_current),
        }
    }

    /// The corners of the triangles that it is of, which the partition has as rows.
    fn corners(&self) -> Vec<[u32; 3]> {
        self.partition.all_rows().map(|rows| rows.map(|row| self.order.vertex[row as usize])).collect()
    }

    /// The solver of a state, which goes on as the one did that it was kept of; `None` where it is not of this mesh.
    pub fn of_state(state: &MixedState, mesh: (&Vertices, &Triangles, &Topology)) -> Option<Self> {
        let MixedState { corners, vertex, changed, dissection, multigrid } = state;
        let is_current = *corners == mesh.1.corners;
        let followed = if is_current { mesh.2.log.now() } else { Revision::default() };
        let mut solver = Self { followed, ..Self::default() };
        *solver.order = Order::of_vertices(vertex, *changed as usize, *dissection)?;
        let is_in_order = corners.iter().flatten().all(|&v| (v as usize) < vertex.len());
        if !is_in_order || is_current && vertex.len() != mesh.2.incident.len() {
            return None;
        }
        let rows = corners.iter().map(|corners| corners.map(|v| solver.order.row[v as usize]));
        if !partition::is_cut(dissection.cut) || !dissection.are_of(vertex.len(), rows) {
            return None;
        }
        if !corners.is_empty() {
            solver.partition.rebuild(corners, &solver.order.row);
        }
        *solver.multigrid = Multigrid::of_state(multigrid, is_current, &solver.partition, &solver.order, mesh)?;
        Some(solver)
    }
}

//! Springs to ground.

use super::StepContext;
use crate::components::{ExternalStiffness, Forces, SolverScratch, Springs};
use crate::storage::{Topology, Triangles, Vertices};
use glam::{DMat3, DVec3};

/// Adds the springs' forces and stiffness.
pub fn springs(world: &mut hecs::World, _: &StepContext) -> usize {
    let mut count = 0;
    type Query<'a> = (
        (&'a Vertices, &'a Triangles, &'a Topology, &'a Springs, &'a SolverScratch),
        &'a mut Forces,
        &'a mut ExternalStiffness,
    );
    for ((vertices, triangles, topology, springs, scratch), forces, external) in world.query_mut::<Query>() {
        if scratch.is_converged {
            continue;
        }
        count += 1;
        for (&row, anchor) in springs.anchors.rows().iter().zip(springs.anchors.values()) {
            let v = row as usize;
            let stiffness = anchor.stiffness * topology.vertex_area(triangles, row);
            forces.nodal[v] += (anchor.point - vertices.position[v]) * stiffness;
            external.block[v] += DMat3::from_diagonal(DVec3::splat(stiffness));
        }
    }
    count
}

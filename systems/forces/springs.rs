//! Springs to ground.

use crate::components::{ExternalStiffness, Forces, SolveResult, Springs};
use crate::math::Sym3;
use crate::storage::{Topology, Triangles, Vertices};
use crate::systems::{StepContext, parallel};

/// Adds the springs' forces and stiffness.
pub fn springs(world: &mut hecs::World, _: &StepContext) -> usize {
    type Query<'a> = (
        (&'a Vertices, &'a Triangles, &'a Topology, &'a Springs, &'a SolveResult),
        &'a mut Forces,
        &'a mut ExternalStiffness,
    );
    parallel::for_bodies::<Query>(
        world,
        |((_, _, _, springs, result), _, _)| result.rows_to_solve(springs.anchors.rows().len()),
        |((vertices, triangles, topology, springs, _), forces, external)| {
            for (&row, anchor) in springs.anchors.rows().iter().zip(springs.anchors.values()) {
                let v = row as usize;
                let stiffness = anchor.stiffness * topology.vertex_area(triangles, row);
                forces.nodal[v] += (anchor.point - vertices.position[v]) * stiffness;
                external.block[v] += Sym3::isotropic(stiffness);
            }
        },
    )
}

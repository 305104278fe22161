//! Frictionless contact with rigid obstacles, by a penalty that is implicit in the step.

use super::{StepContext, parallel};
use crate::components::{Contact, ExternalStiffness, Forces, Obstacle, SolverScratch};
use crate::storage::{Topology, Triangles, Vertices};
use glam::{DMat3, DVec3};

/// Pushes vertices that are inside an obstacle back along its normal: pressure = stiffness · depth over the vertex' rest area.
pub fn contact(world: &mut hecs::World, _: &StepContext) -> usize {
    let obstacles: smallvec::SmallVec<[Obstacle; 8]> = world.query_mut::<&Obstacle>().into_iter().copied().collect();
    if obstacles.is_empty() {
        return 0;
    }
    type Query<'a> = (
        (&'a Vertices, &'a Triangles, &'a Topology, &'a SolverScratch, &'a Contact),
        &'a mut Forces,
        &'a mut ExternalStiffness,
    );
    parallel::for_bodies::<Query>(
        world,
        |((vertices, _, _, scratch, _), _, _)| scratch.rows_to_solve(vertices.len()),
        |((vertices, triangles, topology, _, contact), forces, external)| {
            for obstacle in &obstacles {
                let push = |v: usize| {
                    let (distance, normal) = obstacle.shape.distance(vertices.position[v])?;
                    let stiffness = contact.stiffness * topology.vertex_area(triangles, v as u32);
                    (distance < 0.0).then_some((-distance * stiffness, stiffness, normal))
                };
                parallel::for_rows(&mut forces.nodal, |v, f| {
                    *f += push(v).map_or(DVec3::ZERO, |(force, _, normal)| normal * force);
                });
                parallel::for_rows(&mut external.block, |v, k| {
                    if let Some((_, stiffness, n)) = push(v) {
                        *k += DMat3::from_cols(n * n.x, n * n.y, n * n.z) * stiffness;
                    }
                });
            }
        },
    )
}

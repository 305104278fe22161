//! Dead loads on vertices and boundary edges.

use crate::components::{EdgeLoads, Forces, PointLoads, SolveResult, StepForces};
use crate::storage::Vertices;
use crate::systems::{StepContext, parallel};

/// Adds point loads.
pub fn point_loads(world: &mut hecs::World, step: &StepContext) -> usize {
    parallel::for_bodies::<(&PointLoads, &SolveResult, &mut Forces)>(
        world,
        |(loads, result, _)| result.rows_to_solve(loads.groups.iter().map(|load| load.rows.len()).sum()),
        |(loads, _, forces)| {
            for load in &loads.groups {
                let force = load.force * load.curve.at(step.time);
                load.rows.iter().for_each(|&row| forces.nodal[row as usize] += force);
            }
        },
    )
}

/// Adds the forces that the host has given for this step.
pub fn step_forces(world: &mut hecs::World, _: &StepContext) -> usize {
    parallel::for_bodies::<(&StepForces, &SolveResult, &mut Forces)>(
        world,
        |(forces, result, _)| result.rows_to_solve(forces.list.len()),
        |(given, _, forces)| given.list.iter().for_each(|&(row, force)| forces.nodal[row as usize] += force),
    )
}

/// Adds edge loads: half of traction · rest length to each end.
pub fn edge_loads(world: &mut hecs::World, step: &StepContext) -> usize {
    parallel::for_bodies::<(&Vertices, &EdgeLoads, &SolveResult, &mut Forces)>(
        world,
        |(_, loads, result, _)| result.rows_to_solve(loads.groups.iter().map(|load| load.edges.len()).sum()),
        |(vertices, loads, _, forces)| {
            for load in &loads.groups {
                let half = load.traction * (0.5 * load.curve.at(step.time));
                for &[a, b] in &load.edges {
                    let (a, b) = (a as usize, b as usize);
                    let force = half * vertices.rest_position[a].distance(vertices.rest_position[b]);
                    forces.nodal[a] += force;
                    forces.nodal[b] += force;
                }
            }
        },
    )
}

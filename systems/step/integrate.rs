//! Moves the vertices by the solve's answer: x = x_start + u, and v as the step's formula says, u/dt in backward Euler.

use crate::components::{Increment, SolverScratch};
use crate::storage::Vertices;
use crate::systems::{StepContext, parallel};
use glam::DVec3;

/// Adds the last solve's change to the displacement of the step and updates positions and velocities. A static solve has
/// no velocities.
pub fn integrate(world: &mut hecs::World, step: &StepContext) -> usize {
    parallel::for_bodies::<(&mut Vertices, &mut Increment, &SolverScratch)>(
        world,
        |(vertices, _, scratch)| scratch.rows_to_solve(vertices.len()),
        |(vertices, increment, _)| {
            let Increment { displacement, delta, .. } = &mut *increment;
            parallel::for_rows(displacement, |v, u| *u += delta[v]);
            let Increment { start, displacement, .. } = &*increment;
            parallel::for_rows(&mut vertices.position, |v, x| *x = start[v] + displacement[v]);
            let rate = step.rate();
            parallel::for_rows(&mut vertices.velocity, |v, x| *x = step.travel(increment, v) * rate);
            if !step.is_static {
                increment.delta.fill(DVec3::ZERO);
            }
        },
    )
}

//! Weight.

use super::{StepContext, parallel};
use crate::components::{Forces, Gravity, SolverScratch};
use crate::storage::Vertices;

/// Adds mass · acceleration to every vertex.
pub fn gravity(world: &mut hecs::World, _: &StepContext) -> usize {
    parallel::for_bodies::<(&Vertices, &Gravity, &SolverScratch, &mut Forces)>(
        world,
        |(vertices, _, scratch, _)| scratch.rows_to_solve(vertices.len()),
        |(vertices, gravity, _, forces)| {
            parallel::for_rows(&mut forces.nodal, |v, f| *f += gravity.acceleration * vertices.mass[v]);
        },
    )
}

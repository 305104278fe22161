//! Weight.

use crate::components::{Forces, Gravity, SolveResult};
use crate::storage::Vertices;
use crate::systems::{StepContext, parallel};

/// Adds mass · acceleration to every vertex.
pub fn gravity(world: &mut hecs::World, _: &StepContext) -> usize {
    parallel::for_bodies::<(&Vertices, &Gravity, &SolveResult, &mut Forces)>(
        world,
        |(vertices, _, result, _)| result.rows_to_solve(vertices.len()),
        |(vertices, gravity, _, forces)| {
            parallel::for_rows(&mut forces.nodal, |v, f| *f += gravity.acceleration * vertices.mass[v]);
        },
    )
}

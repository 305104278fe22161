//! Weight.

use super::{StepContext, parallel};
use crate::components::{Forces, Gravity, SolverScratch};
use crate::storage::Vertices;

/// Adds mass · acceleration to every vertex.
pub fn gravity(world: &mut hecs::World, _: &StepContext) -> usize {
    let mut count = 0;
    for (vertices, gravity, scratch, forces) in world.query_mut::<(&Vertices, &Gravity, &SolverScratch, &mut Forces)>()
    {
        if scratch.is_converged {
            continue;
        }
        count += 1;
        parallel::for_rows(&mut forces.nodal, |v, f| *f += gravity.acceleration * vertices.mass[v]);
    }
    count
}

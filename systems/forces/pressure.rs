//! Follower pressure: p · A · n of every triangle, a third to each corner.

use crate::components::{Forces, Pressure, SolveResult};
use crate::storage::{Topology, Triangles, Vertices};
use crate::systems::{StepContext, parallel};

/// Adds the pressure's forces at the current positions. Static solves of bodies without a free rim have their load stiffness in the
/// tangent; dynamic steps, whose masses outweigh it, leave it out.
pub fn pressure(world: &mut hecs::World, step: &StepContext) -> usize {
    type Query<'a> = (&'a Vertices, &'a Triangles, &'a Topology, &'a Pressure, &'a SolveResult, &'a mut Forces);
    parallel::for_bodies::<Query>(
        world,
        |(vertices, _, _, _, result, _)| result.rows_to_solve(vertices.len()),
        |(vertices, triangles, topology, pressure, _, forces)| {
            let sixth = pressure.curve.at(step.time) / 6.0;
            parallel::for_rows(&mut forces.nodal, |v, f| {
                for &c in &topology.incident[v] {
                    let [a, b, d] = triangles.corners[c as usize / 3].map(|v| vertices.position[v as usize]);
                    *f += (b - a).cross(d - a) * sixth;
                }
            });
        },
    )
}

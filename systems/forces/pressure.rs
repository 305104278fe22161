//! Follower pressure: p · A · n of every triangle, a third to each corner.

use crate::components::{Forces, Pressure, SolveResult, TearLog};
use crate::storage::{Closure, Topology, Triangles, Vertices};
use crate::systems::{StepContext, parallel};

/// Adds the pressure's forces at the current positions. Fragments that tears have cut off have fluid on both sides: none acts on them. Static solves of
/// bodies without a free rim have their load stiffness in the tangent; dynamic steps, whose masses outweigh it, leave it out.
pub fn pressure(world: &mut hecs::World, step: &StepContext) -> usize {
    type Mesh<'a> = (&'a Vertices, &'a Triangles, &'a Topology, Option<&'a TearLog>);
    type Query<'a> = (Mesh<'a>, &'a Pressure, &'a SolveResult, &'a mut Forces);
    parallel::for_bodies::<Query>(
        world,
        |((vertices, ..), _, result, _)| result.rows_to_solve(vertices.len()),
        |((vertices, triangles, topology, log), pressure, _, forces)| {
            let sixth = pressure.curve.at(step.time) / 6.0;
            let mut closure = Closure::default();
            if log.is_some_and(|log| log.fragment_count > 0) {
                closure.find(triangles, topology);
            }
            parallel::for_rows(&mut forces.nodal, |v, f| {
                for &c in topology.incident[v].iter().filter(|c| closure.has(**c as usize / 3)) {
                    let [a, b, d] = triangles.corners[c as usize / 3].map(|v| vertices.position[v as usize]);
                    *f += (b - a).cross(d - a) * sixth;
                }
            });
        },
    )
}

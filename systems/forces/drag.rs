//! Drag of the surrounding fluid.

use crate::components::{Drag, ExternalStiffness, Forces, Increment, SolveResult};
use crate::math::Sym3;
use crate::storage::{Topology, Triangles};
use crate::systems::{StepContext, parallel};

/// Adds −c · (rest area of the vertex) · velocity, and its derivative. A static solve has no velocity and no drag.
pub fn drag(world: &mut hecs::World, step: &StepContext) -> usize {
    if step.is_static {
        return 0;
    }
    type Query<'a> = (
        (&'a Triangles, &'a Topology, &'a Increment, &'a SolveResult, &'a Drag),
        &'a mut Forces,
        &'a mut ExternalStiffness,
    );
    parallel::for_bodies::<Query>(
        world,
        |((_, _, increment, result, _), _, _)| result.rows_to_solve(increment.displacement.len()),
        |((triangles, topology, increment, _, drag), forces, external)| {
            let factor = drag.coefficient * step.inv_effective_dt();
            let per_vertex = |v: usize| factor * topology.vertex_area(triangles, v as u32);
            parallel::for_pairs(&mut forces.nodal, &mut external.block, |first, nodal, blocks| {
                for (v, (f, k)) in (first..).zip(nodal.iter_mut().zip(blocks)) {
                    let drag = per_vertex(v);
                    *f -= step.velocity_displacement(increment, v) * drag;
                    *k += Sym3::isotropic(drag);
                }
            });
        },
    )
}

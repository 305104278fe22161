//! Bending: moments against changes of the angles between triangles.

mod folds;

pub use folds::{BendingPasses, Dihedral, DihedralAngles};

use crate::components::{Bending, Damping, Forces, Frames, Increment, SolveResult};
use crate::storage::{Topology, Triangles, Vertices};
use crate::systems::{Formula, StepContext, parallel};

/// Brings the rest angles up to the mesh, finds the angles and adds their forces.
pub fn bending(world: &mut hecs::World, step: &StepContext) -> usize {
    type Query<'a> = (
        (&'a Vertices, &'a Triangles, &'a Topology, &'a Increment, &'a SolveResult),
        (&'a Bending, &'a mut DihedralAngles, &'a mut BendingPasses),
        (&'a Frames, &'a mut Forces, Option<&'a Damping>),
    );
    parallel::for_bodies::<Query>(
        world,
        |((_, triangles, _, _, result), ..)| result.rows_to_solve(triangles.len()),
        |((vertices, triangles, topology, increment, _), (bending, folds, passes), (frames, forces, damping))| {
            folds.refresh((vertices, triangles, topology), bending, passes);
            let viscosity = damping.map_or(0.0, |d| d.time) * step.inv_effective_dt();
            folds.evaluate(&triangles.corners, &vertices.position, 1.0 + viscosity, passes);
            if !step.is_static && step.newton_iterations == 1 && step.formula == Formula::BackwardEuler {
                folds.leave_out_taut(triangles, frames);
            }
            let velocity_displacement = |v: usize| step.velocity_displacement(increment, v);
            folds.add_forces(&triangles.corners, topology, velocity_displacement, &mut forces.nodal, passes);
        },
    )
}

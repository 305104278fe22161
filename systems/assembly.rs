//! Force assembly: elastic and viscous membrane forces, gathered per vertex.

use super::kernels::membrane;
use super::kernels::membrane_lanes::CornerForces;
use super::{Formula, StepContext, parallel};
use crate::components::{Damping, ExternalStiffness, Forces, Frames, Increment, SolverScratch};
use crate::storage::{Topology, Triangles, Vertices};
use glam::{DMat3, DVec3};

/// Starts the nodal forces with those of the membrane, and empties the external stiffness.
pub fn assembly(world: &mut hecs::World, step: &StepContext) -> usize {
    type Query<'a> = (
        (&'a Vertices, &'a Triangles, &'a Topology, &'a Frames, &'a Increment, &'a SolverScratch),
        &'a mut Forces,
        Option<&'a mut ExternalStiffness>,
        Option<&'a Damping>,
    );
    parallel::for_bodies::<Query>(
        world,
        |((_, triangles, _, _, _, scratch), _, _, _)| scratch.rows_to_solve(triangles.len()),
        |((vertices, triangles, topology, frames, increment, _), forces, external, damping)| {
            if let Some(external) = external {
                external.block.clear();
                external.block.resize(vertices.len(), DMat3::ZERO);
            }
            // At the start of a step by backward Euler nothing has moved yet: there is no rate.
            let is_at_rest =
                step.formula == Formula::BackwardEuler && increment.displacement.iter().all(|u| *u == DVec3::ZERO);
            let viscosity = if is_at_rest { 0.0 } else { damping.map_or(0.0, |d| d.time) * step.rate() };
            membrane_forces(triangles, frames, |v| step.travel(increment, v), viscosity, forces);
            gather(topology, forces, vertices.len());
        },
    )
}

/// Corner forces of every triangle. `viscosity` is β/s with the span s of the step's formula, by which the stretch rate of what
/// the vertices `travel` in it adds to the strain, at the present stiffness.
pub fn membrane_forces(
    triangles: &Triangles,
    frames: &Frames,
    travel: impl Fn(usize) -> DVec3 + Sync,
    viscosity: f64,
    forces: &mut Forces,
) {
    forces.corner.resize(triangles.len(), [DVec3::ZERO; 3]);
    if viscosity == 0.0 {
        let (state, Triangles { rest, thickness, .. }) = (&frames.state, triangles);
        return parallel::for_chunks(&mut forces.corner, &CornerForces { state, rest, thickness });
    }
    parallel::for_rows(&mut forces.corner, |t, corner| {
        let state = &frames.state[t];
        let rest = &triangles.rest[t];
        let u = triangles.corners[t].map(|v| travel(v as usize));
        let rate = membrane::stretch_rate(&state.polar, rest, u);
        let stress = state.stress + frames.stiffness(triangles, t).coupled_stress(frames.coupling(t), rate * viscosity);
        *corner = membrane::nodal_forces(&state.polar, stress, rest, rest.area * triangles.thickness[t]);
    });
}

/// Sums every vertex' corner forces in the order of triangle rows.
pub fn gather(topology: &Topology, forces: &mut Forces, vertex_count: usize) {
    // An incident entry is three times its triangle plus the corner: an index into the corners laid end to end.
    let corner = forces.corner.as_flattened();
    forces.nodal.resize(vertex_count, DVec3::ZERO);
    parallel::for_rows(&mut forces.nodal, |v, nodal| {
        *nodal = topology.incident[v].iter().map(|&c| corner[c as usize]).sum();
    });
}

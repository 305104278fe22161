//! Force assembly: elastic and viscous membrane forces, gathered per vertex.

use crate::components::{Damping, ExternalStiffness, Forces, Frames, Increment, SolveResult};
use crate::math::Sym3;
use crate::storage::room::grow;
use crate::storage::{Topology, Triangles, Vertices};
use crate::systems::forces::corners;
use crate::systems::kernels::lanes::Lanes;
use crate::systems::kernels::membrane;
use crate::systems::kernels::membrane_lanes::CornerForces;
use crate::systems::kernels::simd::Kernel;
use crate::systems::{Formula, StepContext, parallel};
use glam::DVec3;

/// Starts the nodal forces with those of the membrane, and empties the external stiffness.
pub fn assembly(world: &mut hecs::World, step: &StepContext) -> usize {
    type Query<'a> = (
        (&'a Vertices, &'a Triangles, &'a Topology, &'a Frames, &'a Increment, &'a SolveResult),
        &'a mut Forces,
        Option<&'a mut ExternalStiffness>,
        Option<&'a Damping>,
    );
    parallel::for_bodies::<Query>(
        world,
        |((_, triangles, _, _, _, result), _, _, _)| result.rows_to_solve(triangles.len()),
        |((vertices, triangles, topology, frames, increment, _), forces, external, damping)| {
            if let Some(external) = external {
                external.block.clear();
                external.coupled.pairs.clear();
                external.coupled.pair_block.clear();
                external.coupled.rigid.clear();
                grow(&mut external.block, vertices.len(), vertices.position.capacity());
                external.block.resize(vertices.len(), Sym3::ZERO);
            }
            // At the start of a step by backward Euler nothing has moved yet: there is no rate.
            let is_at_rest =
                step.formula == Formula::BackwardEuler && increment.displacement.iter().all(|u| *u == DVec3::ZERO);
            let viscosity = if is_at_rest { 0.0 } else { damping.map_or(0.0, |d| d.time) * step.inv_effective_dt() };
            let mesh = (triangles, topology);
            forces.has_scale = step.newton_iterations > 1;
            membrane_forces(mesh, frames, |v| step.velocity_displacement(increment, v), viscosity, forces);
        },
    )
}

/// Sets the nodal forces to those of the membrane. `viscosity` is β/s with the span s of the step's formula, by which the
/// stretch rate of the displacements `velocity_displacement` over that span adds to the strain, at the present stiffness.
pub fn membrane_forces(
    (triangles, topology): (&Triangles, &Topology),
    frames: &Frames,
    velocity_displacement: impl Fn(usize) -> DVec3 + Sync,
    viscosity: f64,
    forces: &mut Forces,
) {
    let Forces { nodal, corner, has_scale, scale } = forces;
    grow(nodal, topology.incident.len(), topology.incident.capacity());
    nodal.resize(topology.incident.len(), DVec3::ZERO);
    *scale = 0.0;
    let seen = |corner: &[[DVec3; 3]]| {
        if *has_scale {
            *scale = corner.iter().flatten().map(|f| f.length()).fold(*scale, f64::max);
        }
    };
    let mesh = (triangles.corners.as_slice(), topology);
    if viscosity == 0.0 {
        let (rest, thickness) = (&triangles.rest, triangles.thickness.by_row());
        return if frames.is_planar() {
            corners::add_up(mesh, corner, nodal, &CornerForces { state: &frames.flat, rest, thickness }, seen)
        } else {
            corners::add_up(mesh, corner, nodal, &CornerForces { state: &frames.solid, rest, thickness }, seen)
        };
    }
    corners::add_up(mesh, corner, nodal, &Viscous { triangles, frames, velocity_displacement, viscosity }, seen);
}

/// The forces of stress and strain rate.
struct Viscous<'a, F> {
    triangles: &'a Triangles,
    frames: &'a Frames,
    velocity_displacement: F,
    viscosity: f64,
}

impl<F: Fn(usize) -> DVec3 + Sync> Kernel<[DVec3; 3]> for Viscous<'_, F> {
    #[inline(always)]
    fn run<L: Lanes>(&self, _: L, first: usize, rows: &mut [[DVec3; 3]]) {
        let Self { triangles, frames, velocity_displacement, viscosity } = self;
        for (i, corner) in rows.iter_mut().enumerate() {
            let t = first + i;
            let state = frames.state(t);
            let rest = &triangles.rest[t];
            let u = triangles.corners[t].map(|v| velocity_displacement(v as usize));
            let rate = membrane::stretch_rate(&state.polar, rest, u) * *viscosity;
            let stress = state.stress + frames.stiffness(triangles, t).coupled_stress(frames.coupling(t), rate);
            *corner = membrane::nodal_forces(&state.polar, stress, rest, rest.area * triangles.thickness[t]);
        }
    }
}

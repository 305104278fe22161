//! Rotation, stretch and stress of every triangle at the current positions.

use super::{StepContext, kernels::membrane, parallel};
use crate::components::{Frames, Planar, PreStretch, SolverScratch};
use crate::math::{ElementState, Sym2};
use crate::settings::Tangent;
use crate::storage::{Triangles, Vertices};

/// Fills [`Frames`].
pub fn corotation(world: &mut hecs::World, step: &StepContext) -> usize {
    type Query<'a> =
        (&'a Vertices, &'a Triangles, &'a mut Frames, &'a SolverScratch, Option<&'a Planar>, Option<&'a PreStretch>);
    parallel::for_bodies::<Query>(
        world,
        |(_, triangles, _, scratch, _, _)| scratch.rows_to_solve(triangles.len()),
        |(vertices, triangles, frames, scratch, planar, pre_stretch)| {
            evaluate(vertices, triangles, frames, planar.is_some(), pre_stretch);
            let is_exact = step.tangent == Tangent::Exact && !scratch.fell_back;
            geometric_stiffness(frames, triangles, planar.is_some(), is_exact);
        },
    )
}

/// State of every triangle at the vertices' positions.
pub fn evaluate(
    vertices: &Vertices,
    triangles: &Triangles,
    frames: &mut Frames,
    is_planar: bool,
    pre_stretch: Option<&PreStretch>,
) {
    let unstretched = PreStretch::unstretched(pre_stretch);
    frames.state.resize(triangles.len(), ElementState::REST);
    parallel::for_rows(&mut frames.state, |t, state| {
        let x = triangles.corners[t].map(|v| vertices.position[v as usize]);
        *state = membrane::state(x, &triangles.rest[t], &triangles.stiffness[t], is_planar, unstretched);
    });
}

fn geometric_stiffness(frames: &mut Frames, triangles: &Triangles, is_planar: bool, is_exact: bool) {
    let state = &frames.state;
    frames.shear.resize(state.len(), 0.0);
    parallel::for_rows(&mut frames.shear, |t, shear| {
        let ElementState { polar, stress } = state[t];
        *shear = if is_exact { 0.0 } else { membrane::shear_majorant(stress, polar.stretch, &triangles.stiffness[t]) };
    });
    frames.normal.resize(state.len(), Sym2::ZERO);
    if is_planar {
        frames.normal.fill(Sym2::ZERO);
        return;
    }
    parallel::for_rows(&mut frames.normal, |t, normal| {
        let s = membrane::second_piola(state[t].stress, state[t].polar.stretch);
        *normal = if is_exact { s } else { s.positive_part() };
    });
}

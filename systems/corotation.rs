//! Rotation, stretch and stress of every triangle at the current positions.

use super::kernels::membrane;
use super::kernels::membrane_lanes::{Geometric, States};
use super::{Formula, StepContext, parallel};
use crate::components::{FibreResponse, Frames, Planar, PreStretch, SolverScratch, StiffeningFibres};
use crate::math::{ElementState, GeometricStiffness, Orthotropic, Polar, Sym2};
use crate::settings::Tangent;
use crate::storage::{Triangles, Vertices};

/// Fills [`Frames`].
pub fn corotation(world: &mut hecs::World, step: &StepContext) -> usize {
    type Query<'a> = (
        (&'a Vertices, &'a Triangles, &'a mut Frames, &'a SolverScratch),
        (Option<&'a Planar>, Option<&'a PreStretch>, Option<&'a StiffeningFibres>),
    );
    parallel::for_bodies::<Query>(
        world,
        |((_, triangles, _, scratch), _)| scratch.rows_to_solve(triangles.len()),
        |((vertices, triangles, frames, scratch), (planar, pre_stretch, fibres))| {
            evaluate(vertices, triangles, frames, planar.is_some(), pre_stretch, fibres);
            // Nothing is solved for at the start of a step of two stages.
            if step.formula != Formula::Start {
                geometric_stiffness(frames, triangles, planar.is_some(), step.tangent_of(scratch), step.reserve());
            }
        },
    )
}

/// State of every triangle at the vertices' positions, and its stiffness where fibres stiffen.
pub fn evaluate(
    vertices: &Vertices,
    triangles: &Triangles,
    frames: &mut Frames,
    is_planar: bool,
    pre_stretch: Option<&PreStretch>,
    fibres: Option<&StiffeningFibres>,
) {
    let unstretched = PreStretch::unstretched(pre_stretch);
    frames.state.resize(triangles.len(), ElementState::REST);
    let (Triangles { corners, rest, stiffness, .. }, position) = (triangles, &vertices.position);
    parallel::for_chunks(&mut frames.state, &States { corners, position, rest, stiffness, is_planar, unstretched });
    match fibres {
        None => frames.stiffened.clear(),
        Some(fibres) => stiffen(frames, stiffness, unstretched, fibres),
    }
}

/// Adds what the fibres do beyond the linear law to the stress, and fills in the stiffness.
fn stiffen(frames: &mut Frames, material: &[Orthotropic], unstretched: Sym2, fibres: &StiffeningFibres) {
    let Frames { state, stiffened, .. } = frames;
    let response = |polar: &Polar| fibres.response(polar.stretch.xx - unstretched.xx);
    parallel::for_rows(state, |_, state| state.stress.xx += response(&state.polar).stress);
    stiffened.clear();
    stiffened.extend_from_slice(material);
    parallel::for_rows(stiffened, |t, law| {
        let FibreResponse { stiffness, .. } = response(&state[t].polar);
        law.q11 += stiffness;
    });
}

/// Geometric stiffness of every triangle at its state, as the tangent needs it.
pub fn geometric_stiffness(
    frames: &mut Frames,
    triangles: &Triangles,
    is_planar: bool,
    tangent: Tangent,
    reserve: f64,
) {
    let Frames { state, geometric, stiffened } = frames;
    geometric.resize(state.len(), GeometricStiffness::default());
    let stiffness = if stiffened.is_empty() { &triangles.stiffness } else { &*stiffened };
    if tangent == Tangent::Rotated {
        return parallel::for_chunks(geometric, &Geometric { state, stiffness, is_planar, reserve });
    }
    parallel::for_rows(geometric, |t, geometric| {
        let ElementState { polar, stress } = state[t];
        let normal = if is_planar { Sym2::ZERO } else { membrane::second_piola(stress, polar.stretch) };
        *geometric = match tangent {
            Tangent::Projected => GeometricStiffness {
                normal: normal.positive_part(),
                in_plane: membrane::spin_majorant(stress, polar.stretch, &stiffness[t]),
            },
            _ => GeometricStiffness { normal, in_plane: 0.0 },
        };
    });
}

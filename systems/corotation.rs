//! Rotation, stretch and stress of every triangle at the current positions.

use super::kernels::membrane;
use super::kernels::membrane_lanes::{Geometric, States};
use super::kernels::simd;
use super::{Formula, StepContext, parallel};
use crate::components::{Frames, Planar, PreStretch, SolverScratch, StiffeningFibres};
use crate::math::{CoupledStiffness, ElementState, Faded, GeometricStiffness, Orthotropic, Sym2};
use crate::settings::Tangent;
use crate::storage::room::grow;
use crate::storage::{Alike, Triangles, Vertices};
use std::sync::atomic::AtomicBool;

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
            let is_planar = planar.is_some();
            let tangent = step.tangent_of(scratch);
            if step.formula != Formula::Start && tangent == Tangent::Rotated && fibres.is_none() {
                let unstretched = PreStretch::unstretched(pre_stretch);
                return evaluate_rotated(vertices, triangles, frames, is_planar, unstretched, step.reserve());
            }
            evaluate(vertices, triangles, frames, is_planar, pre_stretch, fibres);
            // Nothing is solved for at the start of a step of two stages.
            if step.formula != Formula::Start {
                geometric_stiffness(frames, triangles, is_planar, tangent, step.reserve());
            }
        },
    )
}

/// State and geometric stiffness of the rotated tangent at the vertices' positions, where no fibres stiffen: [`evaluate`] and
/// [`geometric_stiffness`] in one pass.
fn evaluate_rotated(
    vertices: &Vertices,
    triangles: &Triangles,
    frames: &mut Frames,
    is_planar: bool,
    unstretched: Sym2,
    reserve: f64,
) {
    frames.is_planar = is_planar;
    grow(&mut frames.state, triangles.len(), triangles.corners.capacity());
    frames.state.resize(triangles.len(), ElementState::REST);
    grow(&mut frames.geometric, triangles.len(), triangles.corners.capacity());
    frames.geometric.resize(triangles.len(), GeometricStiffness::default());
    let (Triangles { corners, rest, .. }, position) = (triangles, &vertices.position);
    let stiffness = triangles.stiffness.by_row();
    let states =
        States { corners, position, rest, stiffness, is_planar, unstretched, has_faded: AtomicBool::new(false) };
    parallel::for_pairs(&mut frames.state, &mut frames.geometric, |first, state, geometric| {
        simd::run(&states, first, state);
        simd::run(&Geometric { state, start: first, stiffness, is_planar, reserve }, first, geometric);
    });
    stiffen(frames, &triangles.stiffness, unstretched, states.has_faded.into_inner(), None);
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
    frames.is_planar = is_planar;
    grow(&mut frames.state, triangles.len(), triangles.corners.capacity());
    frames.state.resize(triangles.len(), ElementState::REST);
    let (Triangles { corners, rest, .. }, position) = (triangles, &vertices.position);
    let stiffness = triangles.stiffness.by_row();
    let states =
        States { corners, position, rest, stiffness, is_planar, unstretched, has_faded: AtomicBool::new(false) };
    parallel::for_chunks(&mut frames.state, &states);
    stiffen(frames, &triangles.stiffness, unstretched, states.has_faded.into_inner(), fibres);
}

/// Fills in the stiffness where it is not that of the material, and adds to the stress what fibres do beyond the linear law.
fn stiffen(
    Frames { state, stiffened, is_planar, .. }: &mut Frames,
    material: &Alike<Orthotropic>,
    unstretched: Sym2,
    has_faded: bool,
    fibres: Option<&StiffeningFibres>,
) {
    stiffened.clear();
    if fibres.is_none() && !has_faded {
        return;
    }
    stiffened.extend(material.iter().map(|law| CoupledStiffness { law: *law, q16: 0.0 }));
    parallel::for_rows(stiffened, |t, stiffened| {
        let stretch = state[t].polar.stretch;
        if let Some(faded) = Faded::at(stretch, *is_planar) {
            stiffened.law = faded.majorant(&stiffened.law, stretch, unstretched);
        }
        if let Some(fibres) = fibres {
            *stiffened = fibres.stiffness(stretch, unstretched, &stiffened.law);
        }
    });
    if fibres.is_some() {
        parallel::for_rows(state, |_, state| {
            state.stress = StiffeningFibres::stiffen(fibres, state.polar.stretch, unstretched, state.stress);
        });
    }
}

/// Geometric stiffness of every triangle at its state, as the tangent needs it.
pub fn geometric_stiffness(
    frames: &mut Frames,
    triangles: &Triangles,
    is_planar: bool,
    tangent: Tangent,
    reserve: f64,
) {
    let Frames { state, geometric, stiffened, .. } = frames;
    grow(geometric, state.len(), triangles.corners.capacity());
    geometric.resize(state.len(), GeometricStiffness::default());
    if tangent == Tangent::Rotated {
        let stiffness = triangles.stiffness.by_row();
        return parallel::for_chunks(geometric, &Geometric { state, start: 0, stiffness, is_planar, reserve });
    }
    parallel::for_rows(geometric, |t, geometric| {
        let ElementState { polar, stress } = state[t];
        let normal = if is_planar { Sym2::ZERO } else { membrane::second_piola(stress, polar.stretch) };
        *geometric = match tangent {
            Tangent::Projected => GeometricStiffness {
                normal: normal.positive_part(),
                in_plane: match stiffened.get(t) {
                    None => membrane::spin_majorant(stress, polar.stretch, &triangles.stiffness[t], 0.0),
                    Some(CoupledStiffness { law, q16 }) => membrane::spin_majorant(stress, polar.stretch, law, *q16),
                },
            },
            _ => GeometricStiffness { normal, in_plane: 0.0 },
        };
    });
}

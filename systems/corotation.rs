//! Rotation, stretch and stress of every triangle at the current positions.

use super::kernels::membrane;
use super::kernels::membrane_lanes::{Geometric, States};
use super::kernels::simd::{self, Kernel};
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
    let room = triangles.corners.capacity();
    let (Triangles { corners, rest, .. }, position) = (triangles, &vertices.position);
    let stiffness = triangles.stiffness.by_row();
    let states =
        States { corners, position, rest, stiffness, is_planar, unstretched, has_faded: AtomicBool::new(false) };
    let Frames { state, geometric, in_plane, .. } = &mut *frames;
    if is_planar {
        geometric.clear();
        states_and_stiffness(&states, state, in_plane, room, reserve);
    } else {
        in_plane.clear();
        states_and_stiffness(&states, state, geometric, room, reserve);
    }
    stiffen(frames, &triangles.stiffness, unstretched, states.has_faded.into_inner(), None);
}

fn states_and_stiffness<T: Clone + Default + Send>(
    states: &States,
    state: &mut [ElementState],
    list: &mut Vec<T>,
    room: usize,
    reserve: f64,
) where
    for<'a> Geometric<'a>: Kernel<T>,
{
    grow(list, state.len(), room);
    list.resize(state.len(), T::default());
    parallel::for_pairs(state, list, |first, state, list| {
        simd::run(states, first, state);
        simd::run(&Geometric { state, start: first, stiffness: states.stiffness, reserve }, first, list);
    });
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
    let Frames { state, geometric, in_plane, stiffened, .. } = frames;
    let room = triangles.corners.capacity();
    if is_planar {
        geometric.clear();
        grow(in_plane, state.len(), room);
        in_plane.resize(state.len(), 0.0);
    } else {
        in_plane.clear();
        grow(geometric, state.len(), room);
        geometric.resize(state.len(), GeometricStiffness::default());
    }
    if tangent == Tangent::Rotated {
        let kernel = Geometric { state, start: 0, stiffness: triangles.stiffness.by_row(), reserve };
        parallel::for_chunks(in_plane, &kernel);
        return parallel::for_chunks(geometric, &kernel);
    }
    let majorant = |t: usize| {
        let ElementState { polar, stress } = state[t];
        match (tangent, stiffened.get(t)) {
            (Tangent::Projected, None) => membrane::spin_majorant(stress, polar.stretch, &triangles.stiffness[t], 0.0),
            (Tangent::Projected, Some(CoupledStiffness { law, q16 })) => {
                membrane::spin_majorant(stress, polar.stretch, law, *q16)
            }
            _ => 0.0,
        }
    };
    parallel::for_rows(in_plane, |t, in_plane| *in_plane = majorant(t));
    parallel::for_rows(geometric, |t, geometric| {
        let normal = membrane::second_piola(state[t].stress, state[t].polar.stretch);
        let normal = if tangent == Tangent::Projected { normal.positive_part() } else { normal };
        *geometric = GeometricStiffness { normal, in_plane: majorant(t) };
    });
}

//! Rotation, stretch and stress of every triangle at the current positions.

use crate::components::{FibreLaws, Frames, Planar, PreStretch, SolveResult, fibre_law};
use crate::math::{CoupledStiffness, Faded, FibreLaw, GeometricStiffness, Sym2};
use crate::settings::Tangent;
use crate::storage::{Triangles, Vertices};
use crate::systems::kernels::gather::Stored;
use crate::systems::kernels::membrane;
use crate::systems::kernels::membrane_lanes::{Geometric, States};
use crate::systems::kernels::simd::{self, Kernel};
use crate::systems::{Formula, StepContext, parallel};
use std::sync::atomic::AtomicBool;

/// Fills [`Frames`].
pub fn corotation(world: &mut hecs::World, step: &StepContext) -> usize {
    type Query<'a> = (
        (&'a Vertices, &'a Triangles, &'a mut Frames, &'a SolveResult),
        (Option<&'a Planar>, Option<&'a PreStretch>, FibreLaws<'a>),
    );
    parallel::for_bodies::<Query>(
        world,
        |((_, triangles, _, result), _)| result.rows_to_solve(triangles.len()),
        |((vertices, triangles, frames, result), (planar, pre_stretch, fibres))| {
            let is_planar = planar.is_some();
            let tangent = step.tangent_of(result);
            if step.formula != Formula::Start && tangent == Tangent::Rotated && fibres.is_none() {
                let unstretched = PreStretch::unstretched(pre_stretch);
                return evaluate_rotated(vertices, triangles, frames, is_planar, unstretched, step.reserve());
            }
            let fibres = fibre_law(fibres, pre_stretch);
            evaluate(vertices, triangles, frames, is_planar, pre_stretch, fibres.as_ref());
            // Nothing is solved for at the start of a step of two stages.
            if step.formula != Formula::Start {
                geometric_stiffness(frames, triangles, tangent, step.reserve());
            }
        },
    )
}

/// State and geometric stiffness of the rotated tangent at the vertices' positions, by the linear law: [`evaluate`] and
/// [`geometric_stiffness`] in one pass.
fn evaluate_rotated(
    vertices: &Vertices,
    triangles: &Triangles,
    frames: &mut Frames,
    is_planar: bool,
    unstretched: Sym2,
    reserve: f64,
) {
    frames.resize(triangles.len(), triangles.corners.capacity(), is_planar);
    let states = states_of(vertices, triangles, is_planar, unstretched);
    states_and_stiffness(&states, &mut frames.solid, &mut frames.geometric, reserve);
    states_and_stiffness(&states, &mut frames.flat, &mut frames.in_plane, reserve);
    stiffen(frames, triangles, unstretched, states.has_faded.into_inner(), None);
}

/// The triangles of a body for the kernel of their states.
fn states_of<'a>(vertices: &'a Vertices, triangles: &'a Triangles, is_planar: bool, unstretched: Sym2) -> States<'a> {
    let (unstretched, pre_stretch) = triangles.held(unstretched);
    States {
        corners: &triangles.corners,
        position: &vertices.position,
        rest: &triangles.rest,
        stiffness: triangles.laws(),
        is_planar,
        unstretched,
        pre_stretch,
        has_faded: AtomicBool::new(false),
    }
}

fn states_and_stiffness<S: Stored, G: Send>(states: &States, state: &mut [S], geometric: &mut [G], reserve: f64)
where
    for<'a> Geometric<'a, S>: Kernel<G>,
{
    parallel::for_pairs(state, geometric, |first, state, geometric| {
        simd::run(states, first, state);
        simd::run(&Geometric { state, start: first, stiffness: states.stiffness, reserve }, first, geometric);
    });
}

/// State of every triangle at the vertices' positions, and its stiffness where fibres stiffen.
pub fn evaluate(
    vertices: &Vertices,
    triangles: &Triangles,
    frames: &mut Frames,
    is_planar: bool,
    pre_stretch: Option<&PreStretch>,
    fibres: Option<&FibreLaw>,
) {
    let unstretched = PreStretch::unstretched(pre_stretch);
    frames.resize(triangles.len(), triangles.corners.capacity(), is_planar);
    let states = states_of(vertices, triangles, is_planar, unstretched);
    parallel::for_chunks(&mut frames.solid, &states);
    parallel::for_chunks(&mut frames.flat, &states);
    stiffen(frames, triangles, unstretched, states.has_faded.into_inner(), fibres);
}

/// Fills in the stiffness where it is not that of the material, and adds to the stress the part of fibres beyond the linear
/// law.
fn stiffen(frames: &mut Frames, triangles: &Triangles, unstretched: Sym2, has_faded: bool, fibres: Option<&FibreLaw>) {
    let is_planar = frames.is_planar();
    let Frames { solid, flat, stiffened, .. } = frames;
    stiffened.clear();
    if fibres.is_none() && !has_faded {
        return;
    }
    let material = triangles.laws();
    stiffened.extend((0..triangles.len()).map(|t| CoupledStiffness { law: material[t], q16: 0.0, q26: 0.0 }));
    let answer = |t: usize, stretch: Sym2, stress: &mut Sym2, stiffened: &mut CoupledStiffness| {
        let unstretched = triangles.unstretched(t, unstretched);
        if let Some(faded) = Faded::at(stretch, is_planar) {
            stiffened.law = faded.majorant(&stiffened.law, stretch, unstretched);
        }
        if let Some(fibres) = fibres {
            let linear = (*stress, &stiffened.law);
            (*stress, *stiffened) = fibres.answer(stretch, unstretched, linear, &material[t]);
        }
    };
    if is_planar {
        parallel::for_pairs(stiffened, flat, |first, stiffened, flat| {
            let rows = stiffened.iter_mut().zip(flat).enumerate();
            rows.for_each(|(i, (own, state))| answer(first + i, state.stretch, &mut state.stress, own));
        });
    } else {
        parallel::for_pairs(stiffened, solid, |first, stiffened, solid| {
            let rows = stiffened.iter_mut().zip(solid).enumerate();
            rows.for_each(|(i, (own, state))| answer(first + i, state.polar.stretch, &mut state.stress, own));
        });
    }
}

/// Geometric stiffness of every triangle at its state, as the tangent needs it.
pub fn geometric_stiffness(frames: &mut Frames, triangles: &Triangles, tangent: Tangent, reserve: f64) {
    let Frames { solid, flat, geometric, in_plane, stiffened, .. } = frames;
    if tangent == Tangent::Rotated {
        let stiffness = triangles.laws();
        parallel::for_chunks(in_plane, &Geometric { state: flat, start: 0, stiffness, reserve });
        return parallel::for_chunks(geometric, &Geometric { state: solid, start: 0, stiffness, reserve });
    }
    let majorant = |t: usize, stress, stretch| match (tangent, stiffened.get(t)) {
        (Tangent::Projected | Tangent::Weighted, None) => {
            membrane::spin_majorant(stress, stretch, triangles.law(t), [0.0; 2])
        }
        (Tangent::Projected | Tangent::Weighted, Some(CoupledStiffness { law, q16, q26 })) => {
            membrane::spin_majorant(stress, stretch, law, [*q16, *q26])
        }
        _ => 0.0,
    };
    parallel::for_rows(in_plane, |t, in_plane| *in_plane = majorant(t, flat[t].stress, flat[t].stretch));
    parallel::for_rows(geometric, |t, geometric| {
        let (stress, stretch) = (solid[t].stress, solid[t].polar.stretch);
        let normal = membrane::second_piola(stress, stretch);
        let normal = if tangent == Tangent::Exact { normal } else { normal.positive_part() };
        *geometric = GeometricStiffness { normal, in_plane: majorant(t, stress, stretch) };
    });
}

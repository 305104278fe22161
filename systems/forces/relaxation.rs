//! Viscoelastic tissue: for every span of time an elastic law, and the history that it leaves.
//!
//! With the strains qᵢ of the branches' springs the stress at the end of a span Δt is C:(g_∞·ε + Σ gᵢ·(e^{−xᵢ}·qᵢ + φᵢ·ΔU)), xᵢ = Δt/τᵢ and
//! φᵢ = (1 − e^{−xᵢ})/xᵢ: that of an elastic triangle with the stiffness (g_∞ + Σ gᵢ·φᵢ)·C and another shape free of stress. Forces, tangents,
//! guards and criteria meet that triangle; only when a step stands does the history go on.

use crate::components::{Increment, Planar, PreStretch, Relaxation, SolveResult};
use crate::math::{Decay, FreeShape, Orthotropic, Sym2, tangent};
use crate::storage::room::copy;
use crate::storage::{Relaxing, Triangles, Vertices};
use crate::systems::kernels::membrane;
use crate::systems::kernels::polar::stretches;
use crate::systems::kernels::simd::LANES;
use crate::systems::{StepContext, parallel};
use glam::DVec3;
use hecs::World;

/// Gives relaxing bodies the elastic law of the span that is about to be evaluated, unless they have it.
pub fn relaxation(world: &mut World, step: &StepContext) -> usize {
    type Query<'a> = (
        (&'a mut Triangles, &'a Relaxation, &'a Increment, &'a SolveResult),
        (Option<&'a Planar>, Option<&'a PreStretch>),
    );
    let span = step.relaxed_span();
    let has_law = |triangles: &Triangles| triangles.relaxing.as_ref().is_some_and(|own| own.span == Some(span));
    parallel::for_bodies::<Query>(
        world,
        |((triangles, _, increment, result), _)| {
            let is_due = !increment.start.is_empty() && !has_law(triangles);
            if is_due { result.rows_to_solve(triangles.len()) } else { 0 }
        },
        |((triangles, relaxation, increment, _), (planar, pre_stretch))| {
            let mut relaxing = triangles.relaxing.take().unwrap_or_default();
            relaxing.fit(triangles.len(), relaxation.branches.len());
            let unstretched = PreStretch::unstretched(pre_stretch);
            if relaxing.ended == increment.start {
                relaxing.start.copy_from_slice(&relaxing.end);
            } else {
                stretches_at(&increment.start, triangles, planar.is_some(), &mut relaxing.start);
            }
            relaxing.decays = relaxation.branches.iter().map(|branch| branch.over(span)).collect();
            set_law(&mut relaxing, triangles, unstretched, false);
            let scale = tangent(&relaxing.decays);
            let scaled = |law: &Orthotropic| Orthotropic {
                q11: scale * law.q11,
                q12: scale * law.q12,
                q22: scale * law.q22,
                q66: scale * law.q66,
            };
            relaxing.law = Some(triangles.stiffness.map(scaled));
            relaxing.span = Some(span);
            triangles.relaxing = Some(relaxing);
        },
    )
}

/// Ends a step: where it stands, `is_accepted`, the history of every body that took part goes on; all have their instantaneous law again.
pub fn end(world: &mut World, is_accepted: bool) {
    type Query<'a> = (
        (&'a Vertices, &'a mut Triangles, &'a Relaxation, Option<&'a SolveResult>),
        (Option<&'a Planar>, Option<&'a PreStretch>),
    );
    let is_in_step = |triangles: &Triangles| triangles.relaxing.as_ref().is_some_and(|own| own.law.is_some());
    parallel::for_bodies::<Query>(
        world,
        |((_, triangles, ..), _)| if is_in_step(triangles) { triangles.len() } else { 0 },
        |((vertices, triangles, relaxation, result), (planar, pre_stretch))| {
            let Some(mut relaxing) = triangles.relaxing.take() else { return };
            // A body whose step has failed is put aside without the result.
            if is_accepted && result.is_some() {
                stretches_at(&vertices.position, triangles, planar.is_some(), &mut relaxing.end);
                copy(&mut relaxing.ended, &vertices.position, vertices.position.capacity());
                go_on(&mut relaxing);
            }
            rest(&mut relaxing, triangles, relaxation, PreStretch::unstretched(pre_stretch));
            triangles.relaxing = Some(relaxing);
        },
    );
}

/// Sizes the history to the triangles, and gives them the law of no time.
pub fn rest(relaxing: &mut Relaxing, triangles: &Triangles, relaxation: &Relaxation, unstretched: Sym2) {
    relaxing.fit(triangles.len(), relaxation.branches.len());
    relaxing.decays = relaxation.branches.iter().map(|branch| branch.over(0.0)).collect();
    set_law(relaxing, triangles, unstretched, true);
    (relaxing.law, relaxing.span) = (None, None);
}

/// Energy \[mJ\] that the dashpots take over the present span, with the vertices at these positions at its end.
pub fn dissipated(position: &[DVec3], triangles: &Triangles, is_planar: bool, partials: &mut Vec<f64>) -> f64 {
    let Some(Relaxing { creep, start, decays, law: Some(_), .. }) = triangles.relaxing.as_deref() else { return 0.0 };
    let of_triangle = |t: usize| {
        let rest = &triangles.rest[t];
        let x = triangles.corners[t].map(|v| position[v as usize]);
        let end = membrane::state(x, rest, &triangles.stiffness[t], is_planar, start[t]).polar.stretch;
        let of_branch = |(decay, creep): (&Decay, &Vec<Sym2>)| {
            decay.dissipated(&triangles.stiffness[t], start[t] - Sym2::IDENTITY - creep[t], end - start[t])
        };
        rest.area * triangles.thickness[t] * decays.iter().zip(creep).map(of_branch).sum::<f64>()
    };
    parallel::sum(triangles.len(), partials, of_triangle)
}

/// The shape that is free of stress over the present span. That of no time does not depend on the stretch at its start.
fn set_law(relaxing: &mut Relaxing, triangles: &Triangles, unstretched: Sym2, is_instant: bool) {
    relaxing.unstretched = unstretched;
    let Relaxing { creep, start, held, decays, .. } = relaxing;
    let (shape, pre_stretch) = (FreeShape::of(decays), triangles.pre_stretch.by_row());
    let lasting = Sym2::IDENTITY - unstretched;
    parallel::for_slices(
        held,
        #[inline(always)]
        |first, held| {
            for (i, held) in held.iter_mut().enumerate() {
                *held = (lasting + pre_stretch[first + i]) * shape.lasting;
            }
            if !is_instant {
                for (held, start) in held.iter_mut().zip(&start[first..]) {
                    *held += (Sym2::IDENTITY - *start) * shape.start;
                }
            }
            for (creep, decay) in creep.iter().zip(&*decays) {
                let weight = shape.branch * decay.part * decay.kept;
                for (held, creep) in held.iter_mut().zip(&creep[first..]) {
                    *held = *held - *creep * weight;
                }
            }
        },
    );
}

/// The history at the end of the present span.
fn go_on(relaxing: &mut Relaxing) {
    let Relaxing { creep, start, end, decays, .. } = relaxing;
    for (creep, decay) in creep.iter_mut().zip(decays) {
        let decay = *decay;
        parallel::for_slices(
            creep,
            #[inline(always)]
            |first, creep| {
                for ((creep, start), end) in creep.iter_mut().zip(&start[first..]).zip(&end[first..]) {
                    let before = *start - Sym2::IDENTITY - *creep;
                    *creep = *end - Sym2::IDENTITY - decay.spring(before, *end - *start);
                }
            },
        );
    }
}

/// Stretch of every triangle with the vertices at these positions.
fn stretches_at(position: &[DVec3], triangles: &Triangles, is_planar: bool, out: &mut [Sym2]) {
    parallel::for_slices(
        out,
        #[inline(always)]
        |first, rows| {
            for (group, out) in rows.chunks_mut(LANES).enumerate() {
                let first = first + group * LANES;
                let mut gradients = [(DVec3::X, DVec3::Y); LANES];
                for (f, t) in gradients.iter_mut().zip(first..first + out.len()) {
                    let x = triangles.corners[t].map(|v| position[v as usize]);
                    *f = membrane::gradient(x, &triangles.rest[t]);
                }
                out.iter_mut().zip(stretches(&gradients, is_planar)).for_each(|(out, stretch)| *out = stretch);
            }
        },
    );
}

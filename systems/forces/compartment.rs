//! Pressure of a compartment: a follower load whose pressure follows the volume.
//!
//! The load is (p − p₀)·g with the pressure p₀ outside and the gradient g of the volume V by every vertex: a sixth of the vector product of two edges per
//! triangle and corner, lids over the loops of the boundary included. So its work is that of the content. The pressure is that at the
//! end of the step: it is p(V) where the body is evaluated, and the operator has k·g·gᵀ with k = −dp/dV beside, of rank one. Inflow and leak belong to
//! p(V): the content at the end of the span is C + inflow − span·Q(p). A step that is solved once ends at the linearised pressure.

use crate::components::{
    Compartment, CompartmentState, EnergyAudit, EnergyBalance, Forces, Increment, Outcome, SolveResult, Trial,
    VolumeStiffness,
};
use crate::math::compartment::Outflow;
use crate::storage::{Closure, Topology, Triangles, Vertices};
use crate::systems::{Formula, StepContext, parallel};
use glam::DVec3;
use hecs::World;

type Mesh<'a> = (&'a Vertices, &'a Triangles, &'a Topology);

/// Adds the pressure's forces at the current positions, and keeps the content's stiffness for the operator.
pub fn compartment(world: &mut World, step: &StepContext) -> usize {
    type Query<'a> = (
        (Mesh<'a>, &'a Increment, &'a SolveResult, &'a mut Forces),
        (&'a Compartment, &'a mut CompartmentState, Option<&'a EnergyAudit>),
    );
    parallel::for_bodies::<Query>(
        world,
        |(((_, triangles, _), _, result, _), _)| result.rows_to_solve(triangles.len()),
        |((mesh, increment, result, forces), (compartment, state, audit))| {
            let is_first = result.newton_iterations == 0;
            evaluate(mesh, increment, (compartment, &mut *state), (step, is_first));
            let Some(trial) = &state.work.trial else { return };
            let pressure = trial.filled.pressure - trial.out.outside;
            let gradient = &state.work.stiffness.gradient;
            parallel::for_rows(&mut forces.nodal, |v, f| *f += gradient[v] * pressure);
            if let Some(audit) = audit.filter(|_| step.is_static && is_first) {
                // Loads of an earlier equilibrium are those of the pressure at its end.
                let start = if audit.begins_loaded() { state.pressure - trial.out.outside } else { pressure };
                state.work.start.0 = start;
                state.work.start.1.clone_from(gradient);
            }
        },
    )
}

/// Pressure, its derivatives and the gradient of the volume where the body is.
fn evaluate(
    (vertices, triangles, topology): Mesh<'_>,
    increment: &Increment,
    (compartment, state): (&Compartment, &mut CompartmentState),
    (step, is_first): (&StepContext, bool),
) {
    let CompartmentState { volume: before, content, pressure, opening, rim, answer, work, .. } = state;
    let of_body = |closure: &Closure, position: &[DVec3], partials: &mut Vec<f64>| {
        volume(closure, triangles, position, partials) + compartment.chamber
    };
    if is_first {
        work.closure.find(triangles, topology);
    }
    if is_first && !step.is_resumed {
        *opening = work.closure.opening(rim, &increment.start);
        work.answer.clone_from(answer);
    }
    let span = step.relaxed_span();
    let inflow = if span > 0.0 { compartment.inflow(step.time - span, step.time) } else { 0.0 };
    let outside = compartment.outside.at(step.time);
    let out = Outflow { span, area: compartment.leak * *opening, outside };
    // Edits at unchanged positions take content with them.
    let is_edited = topology.log.now() != work.revision;
    let start = match work.trial {
        Some(trial) if !is_first => trial.start,
        _ if is_edited => *content * (of_body(&work.closure, &increment.start, &mut work.partials) / *before),
        _ => *content,
    };
    let (law, content) = (compartment.content, (start + inflow).max(f64::MIN_POSITIVE));
    let volume = of_body(&work.closure, &vertices.position, &mut work.partials);
    let filled = law.filled(volume, content, &out);
    // Counted from the pressure that is expected here, a small residual has a small right-hand side.
    let expected = match work.trial {
        Some(trial) if !is_first => trial.outcome_of(work.stiffness.swept(&increment.displacement)).pressure,
        _ => *pressure,
    };
    let VolumeStiffness { gradient, stiffness, ahead } = &mut work.stiffness;
    find_gradient(&work.closure, (vertices, triangles, topology), gradient);
    let is_at_start = step.formula == Formula::Start;
    (*stiffness, *ahead) = (if is_at_start { 0.0 } else { filled.stiffness }, filled.pressure - expected);
    let way = work.stiffness.swept(&increment.displacement);
    let trial = Trial { law, out, content, start, inflow, filled, way, outcome: Outcome::default() };
    let outcome = trial.settled(trial.outcome_of(way), volume);
    work.trial = Some(Trial { outcome, ..trial });
}

/// Volume \[mm³\] under the triangles and lids.
fn volume(closure: &Closure, triangles: &Triangles, position: &[DVec3], partials: &mut Vec<f64>) -> f64 {
    let origin = position.first().copied().unwrap_or_default();
    let under = |t: usize| closure.under(t, &triangles.corners, position, origin);
    parallel::sum(triangles.len(), partials, under) + closure.under_lids(position, origin)
}

/// Gradient of the volume by every vertex \[mm²\].
fn find_gradient(closure: &Closure, (vertices, triangles, topology): Mesh<'_>, gradient: &mut Vec<DVec3>) {
    gradient.resize(vertices.len(), DVec3::ZERO);
    let position = &vertices.position;
    parallel::for_rows(gradient, |v, sum| {
        let corners = topology.incident[v].iter().map(|c| *c as usize / 3).filter(|t| closure.has(*t));
        let of_triangle = |t: usize| {
            let [a, b, d] = triangles.corners[t].map(|v| position[v as usize]);
            (b - a).cross(d - a) / 6.0
        };
        *sum = corners.map(of_triangle).sum();
    });
    closure.add_lids(position, gradient);
}

/// Energies of a content over a step, all \[mJ\].
#[derive(Clone, Copy, Debug, Default)]
pub struct ContentTerms {
    /// Work of its pressure on the body.
    of_content: f64,
    /// Energy that the inflow has brought.
    inflow: f64,
    /// Energy that leaks have taken.
    leak: f64,
    /// Change of the stored energy.
    stored: f64,
}

impl ContentTerms {
    /// Energies of a compartment over the step under way, whose vertices are displaced by `u` \[mm\]. By the scheme's pressure in a dynamic step, by the
    /// mean of both ends in a static solve; the energy that is stored is that at the pressure of each end.
    pub fn of(state: Option<&CompartmentState>, u: &[DVec3], step: &StepContext) -> Self {
        let Some(CompartmentState { pressure: last, work, .. }) = state else {
            return Self::default();
        };
        let Some(trial) = &work.trial else { return Self::default() };
        let (way, (Outcome { pressure, content, leaked, .. }, law)) =
            (work.stiffness.swept(u), (trial.outcome, trial.law));
        let [start, end] = [(*last, trial.start), (pressure, content)].map(|(pressure, content)| {
            let volume = law.volume(pressure, content);
            (law.energy(volume, content), law.potential(volume, content))
        });
        let (potential, outside) = (end.1, trial.out.outside);
        let of_content = if step.is_static && step.newton_iterations > 1 {
            let (start, gradient) = &work.start;
            let swept: f64 = gradient.iter().zip(u).map(|(g, u)| g.dot(*u)).sum();
            let of_outside = -0.5 * outside * (swept + way);
            0.5 * (start * swept + (pressure - outside) * way) - of_outside
        } else {
            pressure * way
        };
        let stored = end.0 - start.0;
        Self { of_content, inflow: potential * trial.inflow, leak: potential * leaked, stored }
    }

    /// The balance of a step whose loads count the content among them.
    pub fn told(&self, balance: EnergyBalance) -> EnergyBalance {
        let Self { of_content, inflow, leak, stored } = *self;
        EnergyBalance {
            work_of_loads: balance.work_of_loads - of_content,
            inflow,
            leak,
            content: stored,
            numerical_content: inflow - leak - of_content - stored,
            ..balance
        }
    }
}

/// Finds the content at the end of the step by the displacement that its iterations have reached.
pub fn settle(world: &mut World, _: &StepContext) -> usize {
    type Query<'a> =
        (&'a Vertices, &'a Triangles, &'a Increment, &'a Compartment, &'a mut CompartmentState, &'a SolveResult);
    let mut count = 0;
    for (vertices, triangles, increment, compartment, state, result) in world.query_mut::<Query>() {
        let work = &mut *state.work;
        let Some(trial) = work.trial.as_mut().filter(|_| result.is_in_step) else { continue };
        let of_body = volume(&work.closure, triangles, &vertices.position, &mut work.partials);
        let outcome = trial.outcome_of(work.stiffness.swept(&increment.displacement));
        trial.outcome = trial.settled(outcome, of_body + compartment.chamber);
        count += 1;
    }
    count
}

/// Ends a step: where it stands, `is_accepted`, the content of every body that took part is that at its end.
pub fn end(world: &mut World, is_accepted: bool) {
    type Query<'a> = (Mesh<'a>, &'a Compartment, &'a mut CompartmentState, Option<&'a SolveResult>);
    for ((vertices, triangles, topology), compartment, state, result) in world.query_mut::<Query>() {
        let Some(trial) = state.work.trial.take() else { continue };
        // A body whose step has failed is put aside without the result.
        if !is_accepted || result.is_none() {
            continue;
        }
        let (work, outcome) = (&mut *state.work, trial.outcome);
        work.closure.find(triangles, topology);
        work.revision = topology.log.now();
        let of_body = volume(&work.closure, triangles, &vertices.position, &mut work.partials);
        state.volume = of_body + compartment.chamber;
        // Tears at the end of the step may have cut a piece off, with its content.
        let kept = outcome.content * (state.volume / outcome.volume);
        state.content = kept.max(f64::MIN_POSITIVE);
        state.opening = work.closure.opening(&state.rim, &vertices.position);
        (state.pressure, state.leaked) = (outcome.pressure, state.leaked + outcome.leaked);
        std::mem::swap(&mut state.answer, &mut work.answer);
    }
}

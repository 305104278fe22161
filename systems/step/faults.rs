//! Faults of a body after a solve, and the way back to its last good state.

use super::run::Excluded;
use crate::components::Fault;
use crate::components::{
    EnergyAudit, Forceps, Grips, GuardLedger, Increment, Reactions, Sleeping, SolveResult, SolverScratch, TearDecisions,
};
use crate::event::{GuardCause, GuardPlace};
use crate::storage::{Tips, Vertices};
use crate::systems::{StepContext, contact};
use glam::DVec3;
use hecs::{Entity, World};
use smallvec::SmallVec;

/// Fault of a body after a solve, if it has one.
fn fault(vertices: &Vertices, (result, scratch, ledger): Solve<'_>) -> Option<Fault> {
    if result.linear_residual.is_nan() {
        return Some(Fault::Unsolvable);
    }
    let Vertices { position, velocity, mass, .. } = vertices;
    // Overflowing energies and forces count as not finite.
    let is_finite = scratch.twice_stored.is_finite()
        && result.imbalance.is_finite()
        && position.iter().all(|x| x.is_finite())
        && velocity.iter().zip(mass).map(|(v, m)| m * v.length_squared()).sum::<f64>().is_finite();
    if !is_finite {
        return Some(Fault::NotFinite);
    }
    ledger.creates_energy.then_some(Fault::CreatesEnergy)
}

type Solve<'a> = (&'a SolveResult, &'a SolverScratch, &'a GuardLedger);

/// Query of the components in which faults show.
type FaultQuery<'a> = (&'a Vertices, Solve<'a>, Option<&'a Sleeping>);

/// Fault of a body that is awake; a sleeping body was sound when it fell asleep.
fn fault_of((vertices, solve, sleeping): FaultQuery<'_>) -> Option<Fault> {
    if sleeping.is_some_and(Sleeping::is_asleep) { None } else { fault(vertices, solve) }
}

/// Fault of a body, if it has one.
pub fn fault_in(world: &World, body: Entity) -> Option<Fault> {
    world.query_one::<FaultQuery>(body).get().ok().and_then(fault_of)
}

/// Whether every solve and every state is finite.
pub fn is_finite(world: &mut World) -> bool {
    world
        .query_mut::<FaultQuery>()
        .into_iter()
        .all(|body| !matches!(fault_of(body), Some(Fault::Unsolvable | Fault::NotFinite)))
}

/// Rolls back and excludes the bodies that a solve has left unsound; returns whether any other body is left.
pub(super) fn roll_back_unsound(world: &mut World, failed: &mut Excluded) -> bool {
    let unsound = world.query_mut::<(Entity, FaultQuery)>().into_iter();
    let unsound: SmallVec<[(Entity, Fault); 1]> =
        unsound.filter_map(|(body, judged)| Some((body, fault_of(judged)?))).collect();
    if unsound.is_empty() {
        return true;
    }
    let mut unsound = unsound;
    for group in contact::layers::lists(world) {
        let Some((_, fault)) = unsound.iter().find(|(body, _)| group.contains(body)).copied() else { continue };
        let others = group.into_iter().filter(|body| unsound.iter().all(|(other, _)| other != body));
        let others: SmallVec<[Entity; 4]> = others.collect();
        unsound.extend(others.into_iter().map(|body| (body, fault)));
    }
    for (body, fault) in unsound {
        if let Ok(((vertices, increment, audit), solve, read)) = world.query_one_mut::<Started>(body) {
            let place = refused_at(fault, vertices, increment);
            increment.guard.refuse(place);
            set_back(((vertices, increment, audit), solve, read));
        }
        if let Ok(mut result) = world.remove_one::<SolveResult>(body) {
            result.fault = Some(fault);
            failed.push((body, result));
        }
    }
    world.query_mut::<&SolveResult>().into_iter().next().is_some()
}

/// Cause and place of the fault for which a body's step is undone.
fn refused_at(fault: Fault, vertices: &Vertices, increment: &mut Increment) -> GuardPlace {
    let found = increment.creates_at.take();
    let cause = match fault {
        Fault::CreatesEnergy => return found.unwrap_or(GuardPlace::nowhere(GuardCause::Iterations)),
        Fault::NotFinite => GuardCause::NotFinite,
        Fault::Unsolvable => GuardCause::Unsolvable,
    };
    let Vertices { position, velocity, mass, .. } = vertices;
    let motion = |v: usize| mass[v] * velocity[v].length_squared();
    // A solve without an answer leaves the state that it started from.
    let started = |v: usize| increment.start_velocity.get(v).map_or(0.0, |start| mass[v] * start.length_squared());
    let is_finite = |v: usize| position[v].is_finite() && motion(v).is_finite() && started(v).is_finite();
    let nowhere = GuardPlace::nowhere(cause);
    let Some(v) = (0..vertices.len()).find(|&v| !is_finite(v)) else { return nowhere };
    GuardPlace { vertex: u32::try_from(v).ok(), at: vertices.rest_position[v], ..nowhere }
}

type Started<'a> = (
    (&'a mut Vertices, &'a mut Increment, Option<&'a mut EnergyAudit>),
    (&'a mut SolveResult, &'a mut SolverScratch, &'a mut GuardLedger),
    (Option<&'a mut Reactions>, Option<&'a mut Grips>, Option<(&'a mut Tips, &'a mut TearDecisions)>),
);

/// Resets all bodies to the start of the step, and the obstacles to their places at `time` \[ms\].
pub fn restore(world: &mut World, step: &StepContext, time: f64) {
    world.query_mut::<Started>().into_iter().for_each(set_back);
    contact::move_obstacles(world, &StepContext { time, ..*step });
    report_to_forceps(world);
}

/// Resets a body to its last good state, outputs included.
fn set_back(((vertices, increment, audit), (result, scratch, ledger), read): Started<'_>) {
    if increment.start.len() == vertices.len() {
        vertices.position.copy_from_slice(&increment.start);
        vertices.velocity.copy_from_slice(&increment.start_velocity);
    }
    increment.forget_attempt();
    result.forget_attempt();
    scratch.forget_attempt();
    ledger.forget_attempt();
    scratch.outputs.put_back(read);
    if let Some(audit) = audit {
        audit.undo_step();
    }
}

/// Reports the forces of their jaws to the forceps, where a step was undone.
pub fn report_to_forceps(world: &mut World) {
    let pinches = world.query_mut::<&Grips>().into_iter().flat_map(|grips| &grips.pinches);
    let told = pinches.filter_map(|pinch| Some((pinch.forceps?.entity(), pinch.force, pinch.torque)));
    let told: SmallVec<[(Entity, DVec3, DVec3); 8]> = told.collect();
    for (forceps, force, torque) in told {
        if let Ok(forceps) = world.query_one_mut::<&mut Forceps>(forceps) {
            (forceps.force, forceps.torque) = (force, torque);
        }
    }
}

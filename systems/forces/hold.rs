//! Start of a step or stage: remembers where it began, marks prescribed axes and puts the prescribed motion into the first guess.

use crate::components::{
    Forces, Grips, Guide, HoldGuides, HoldTurns, Holds, Increment, Pinch, Planar, Read, Sleeping, SolverScratch,
    TearDecisions,
};
use crate::storage::Vertices;
use crate::systems::context::SECOND_STAGE;
use crate::systems::{StepContext, parallel};
use glam::DVec3;

/// Sizes the increment to the vertices, saves the start of the step, marks free axes and sets the first guess of the linear
/// solve: the last increment scaled to this step along free axes, the prescribed displacement along the others.
pub fn hold(world: &mut hecs::World, step: &StepContext) -> usize {
    for (scratch, sleeping, read) in world.query_mut::<(&mut SolverScratch, Option<&Sleeping>, Read)>() {
        scratch.readings.keep(read);
        scratch.iterations = 0;
        scratch.is_late = false;
        scratch.newton_iterations = 0;
        scratch.is_converged = sleeping.is_some_and(Sleeping::is_asleep);
        scratch.fell_back = false;
        scratch.line_search = None;
        scratch.is_held_back = false;
        if !step.is_retried {
            scratch.relaxing = scratch.relaxing.saturating_sub(1);
        }
        (scratch.is_counted, scratch.fault, scratch.to_correct) = (false, None, None);
        scratch.account.energy = None;
        scratch.start_left_over = [scratch.left_over, scratch.unseen];
    }
    type Query<'a> = (&'a Vertices, &'a mut Increment, &'a mut SolverScratch, Prescription<'a>, Option<&'a Planar>);
    parallel::for_bodies::<Query>(
        world,
        |(vertices, _, scratch, ..)| scratch.rows_to_solve(vertices.len()),
        |(vertices, increment, scratch, prescription, planar)| {
            let n = vertices.len();
            increment.start.clone_from(&vertices.position);
            increment.start_velocity.clone_from(&vertices.velocity);
            increment.displacement.resize(n, DVec3::ZERO);
            let scale = if step.is_static || increment.dt <= 0.0 { 0.0 } else { step.reach() / increment.dt };
            increment.delta.clear();
            increment.delta.extend(increment.displacement.iter().map(|&u| u * scale));
            increment.displacement.fill(DVec3::ZERO);
            increment.dt = step.dt;

            mark_axes(vertices, increment, scratch, prescription, planar, step.time);
        },
    )
}

/// Keeps the acceleration of every vertex at the start of a step of two stages, by the forces just evaluated there.
pub fn start(world: &mut hecs::World, step: &StepContext) -> usize {
    type Query<'a> =
        (&'a Vertices, &'a Forces, &'a mut Increment, &'a SolverScratch, Option<(&'a Holds, &'a HoldGuides)>);
    parallel::for_bodies::<Query>(
        world,
        |(vertices, _, _, scratch, _)| scratch.rows_to_solve(vertices.len()),
        |(vertices, forces, increment, _, guided)| {
            increment.start_acceleration.resize(vertices.len(), DVec3::ZERO);
            parallel::for_rows(&mut increment.start_acceleration, |v, a| *a = forces.nodal[v] / vertices.mass[v]);
            let Some((holds, guides)) = guided else { return };
            for (place, hold) in holds.groups.iter().enumerate() {
                let Some(Guide::Together { force, curve }) = guides.of(place) else { continue };
                let mass: f64 = hold.members.rows().iter().map(|&row| vertices.mass[row as usize]).sum();
                let held = DVec3::from_array(hold.axes.map(|axis| f64::from(u8::from(axis))));
                let gained = *force * held * (curve.at(step.time) / mass);
                hold.members.rows().iter().for_each(|&row| increment.start_acceleration[row as usize] += gained);
            }
        },
    )
}

/// Begins the second stage where the first has ended: the guess is that the body goes on as it did.
pub fn second_stage(world: &mut hecs::World, step: &StepContext) -> usize {
    for (scratch, sleeping) in world.query_mut::<(&mut SolverScratch, Option<&Sleeping>)>() {
        scratch.newton_iterations = 0;
        scratch.is_converged = sleeping.is_some_and(Sleeping::is_asleep);
    }
    type Query<'a> = (&'a Vertices, &'a mut Increment, &'a mut SolverScratch, Prescription<'a>, Option<&'a Planar>);
    parallel::for_bodies::<Query>(
        world,
        |(vertices, _, scratch, ..)| scratch.rows_to_solve(vertices.len()),
        |(vertices, increment, scratch, prescription, planar)| {
            increment.middle_displacement.clone_from(&increment.displacement);
            increment.middle_velocity.clone_from(&vertices.velocity);
            let Increment { displacement, delta, .. } = &mut *increment;
            parallel::for_rows(delta, |v, delta| *delta = displacement[v] * SECOND_STAGE);
            mark_axes(vertices, increment, scratch, prescription, planar, step.time);
        },
    )
}

/// Takes the step up again on the bodies whose tears have advanced and may advance further: the same step from the same start
/// (the last stage of it where it has two) and with what it has reached so far, on the mesh as it is now. The others are done.
pub fn resume(world: &mut hecs::World, step: &StepContext) -> usize {
    let mut count = 0;
    type Query<'a> = (
        (&'a Vertices, &'a mut Increment, &'a mut SolverScratch),
        (Prescription<'a>, Option<&'a Planar>, Option<&'a TearDecisions>),
    );
    for ((vertices, increment, scratch), (prescription, planar, decisions)) in world.query_mut::<Query>() {
        scratch.is_converged = step.is_done(decisions);
        if scratch.is_converged {
            continue;
        }
        count += 1;
        increment.delta.clear();
        increment.delta.resize(vertices.len(), DVec3::ZERO);
        mark_axes(vertices, increment, scratch, prescription, planar, step.time);
        scratch.newton_iterations = 0;
    }
    count
}

/// What prescribes where vertices are: holds, and jaws that are a constraint.
type Prescription<'a> = ((Option<&'a Holds>, Option<&'a HoldTurns>, Option<&'a HoldGuides>), Option<&'a mut Grips>);

/// Marks the free axes, and puts what is left of the prescribed motion into the first guess.
fn mark_axes(
    vertices: &Vertices,
    increment: &mut Increment,
    scratch: &mut SolverScratch,
    ((holds, turns, guides), grips): Prescription<'_>,
    planar: Option<&Planar>,
    time: f64,
) {
    let free_axes = if planar.is_some() { DVec3::new(1.0, 1.0, 0.0) } else { DVec3::ONE };
    scratch.allowed.clear();
    scratch.free.reset(vertices.len(), vertices.position.capacity(), free_axes);
    if planar.is_some() {
        increment.delta.iter_mut().for_each(|d| d.z = 0.0);
    }
    for (place, hold) in holds.map(|h| h.groups.as_slice()).unwrap_or_default().iter().enumerate() {
        let factor = hold.curve.at(time);
        let turning = turns.and_then(|turns| turns.of(place)).map(|turning| (turning.at(time), turning.pivot));
        let guide = guides.and_then(|guides| guides.of(place));
        if let Some(guide) = guide {
            scratch.allowed.add(hold, guide, planar, time);
        }
        for (&row, &offset) in hold.members.rows().iter().zip(hold.members.values()) {
            let v = row as usize;
            let rest = vertices.rest_position[v];
            let turned = turning.map_or(rest, |(turn, pivot)| turn * (rest - pivot) + pivot);
            let wanted = turned + offset * factor - vertices.position[v];
            let guess = increment.delta[v];
            let (axes, wanted) = match guide {
                None => (hold.axes, wanted),
                Some(Guide::Across(n)) => ([true; 3], guess + *n * n.dot(wanted - guess)),
                Some(Guide::Along(d)) => ([true; 3], wanted + *d * d.dot(guess - wanted)),
                // They come to one displacement from the rest shape below.
                Some(Guide::Together { .. }) => (hold.axes, guess + vertices.position[v] - rest),
            };
            for axis in (0..3).filter(|&axis| axes[axis] && !(planar.is_some() && axis == 2 && guide.is_some())) {
                scratch.free.prescribe(v, axis);
                increment.delta[v][axis] = wanted[axis];
            }
        }
    }
    if !scratch.allowed.is_empty() {
        level(vertices, increment, scratch, (holds, guides));
    }
    for pinch in grips.map(|g| g.pinches.as_mut_slice()).unwrap_or_default() {
        mark_pinched(vertices, increment, scratch, pinch, time);
    }
}

/// Makes the displacements of those that move alike one, and of these again what is left of the step.
fn level(
    vertices: &Vertices,
    increment: &mut Increment,
    scratch: &SolverScratch,
    (holds, guides): (Option<&Holds>, Option<&HoldGuides>),
) {
    scratch.allowed.level(&mut increment.delta);
    let (Some(holds), Some(guides)) = (holds, guides) else { return };
    for (place, hold) in holds.groups.iter().enumerate() {
        let Some(Guide::Together { .. }) = guides.of(place) else { continue };
        for &row in hold.members.rows() {
            let v = row as usize;
            let gone = vertices.position[v] - vertices.rest_position[v];
            let free = scratch.free[v];
            increment.delta[v] -=
                gone * (DVec3::ONE - free) * DVec3::from_array(hold.axes.map(|a| f64::from(u8::from(a))));
        }
    }
}

/// Prescribes what jaws without a stiffness hold, along the axes that nothing else prescribes.
fn mark_pinched(
    vertices: &Vertices,
    increment: &mut Increment,
    scratch: &mut SolverScratch,
    pinch: &mut Pinch,
    time: f64,
) {
    let mut prescribed = std::mem::take(&mut pinch.prescribed);
    prescribed.clear();
    if pinch.is_constraint() {
        for (row, target) in pinch.targets(time) {
            let v = row as usize;
            let axes = scratch.free[v];
            scratch.free.set(v, DVec3::ZERO);
            let wanted = target - vertices.position[v];
            increment.delta[v] = DVec3::select(axes.cmpgt(DVec3::ZERO), wanted, increment.delta[v]);
            prescribed.push(axes);
        }
    }
    pinch.prescribed = prescribed;
}

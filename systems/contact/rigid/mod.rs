//! Rigid obstacles that tissue pushes back.
//!
//! An obstacle with mass moves freely over the step, and tissue in touch makes it deviate. Its six unknowns stand in the solve of the
//! body in touch and are eliminated there, so a light obstacle is as stable as a heavy one: forces that lag by a step are not, once
//! Δt²·K/m > 1. Time integration is that of backward Euler, in a step of two stages in both of them over the time from its start. Of
//! several bodies in touch each moves its share of the mass, and the obstacle goes the mean of their ways (mass splitting, Tonge,
//! Benevolenski and Voroshilov 2012): forces on both sides of it balance over some steps, not within one.
//!
//! Velocity and spin at the end come from the forces that the bodies report, so that the sum of both momenta is kept.

mod approach;
mod couple;

pub(super) use approach::{any_waits, approach};
pub(super) use couple::couple;
pub use couple::follow;

use crate::components::{
    ExternalStiffness, Obstacle, ObstacleMotion, Rigid, RigidState, RigidStep, SolveResult, SolverScratch,
    turned_inertia,
};
use crate::math::elementary;
use crate::systems::StepContext;
use couple::{bodies, rigid_ones, wrench_of};
use glam::{DMat3, DVec3};
use hecs::{Entity, World};
use smallvec::SmallVec;

/// Relative difference of two times that are one.
const SAME_TIME: f64 = 1e-9;

/// A rotation vector as a rotation (Rodrigues 1840).
fn rotation(vector: DVec3) -> DMat3 {
    match vector.try_normalize() {
        Some(axis) => DMat3::from_quat(elementary::rotation(axis, vector.length())),
        None => DMat3::IDENTITY,
    }
}

/// Moves an obstacle by its velocity and spin over a time, from a state.
fn place(obstacle: &mut Obstacle, motion: &mut ObstacleMotion, start: &RigidState, moving: Rigid, time: f64) {
    let turn = rotation(moving.spin * time);
    let way = moving.velocity * time;
    obstacle.shape = start.shape.turned(turn, start.rigid.centre).moved_by(way);
    motion.from = start.shape.clone();
    motion.turn = (turn != DMat3::IDENTITY).then_some(turn);
    let inertia = turned_inertia(start.rigid.inertia, turn);
    motion.rigid = Some(Rigid { centre: start.rigid.centre + way, inertia, ..moving });
}

/// A state after free motion, with the impulse of the step up to it.
fn free(start: &RigidState, time: f64) -> Rigid {
    Rigid { velocity: start.rigid.velocity + start.rigid.acceleration * time, ..start.rigid }
}

/// Begins the motion of rigid obstacles, from where they are.
pub(super) fn begin(world: &mut World, step: &StepContext) -> usize {
    let mut count = 0;
    let begins = step.time - step.stage_dt();
    for (obstacle, motion) in world.query_mut::<(&mut Obstacle, &mut ObstacleMotion)>() {
        let Some(rigid) = motion.rigid.filter(|_| !step.is_static) else { continue };
        count += 1;
        let mut under_way = motion.under_way.take().unwrap_or_else(|| {
            let rigid = Rigid { impulse: DVec3::ZERO, angular_impulse: DVec3::ZERO, ..rigid };
            let first = RigidState { shape: obstacle.shape.clone(), rigid };
            Box::new(RigidStep {
                first_time: begins,
                part: first.clone(),
                first,
                settled: None,
                expected: [DVec3::ZERO; 2],
                deviations: SmallVec::new(),
            })
        });
        if let Some((settled, _)) = &under_way.settled {
            let is_from_start = (begins - under_way.first_time).abs() <= SAME_TIME * step.stage_dt();
            under_way.part = if is_from_start { pushed(&under_way.first, settled) } else { settled.clone() };
        }
        under_way.deviations.clear();
        let Rigid { velocity, spin, .. } = free(&under_way.part, step.stage_dt());
        under_way.expected = [velocity, spin].map(|rate| rate * -step.stage_dt());
        settle_place(obstacle, motion, &under_way, step.stage_dt(), |_| true);
        motion.under_way = Some(under_way);
    }
    count
}

/// The start of a step that others have gone already, with their impulses: bodies that repeat it find the obstacle there.
fn pushed(first: &RigidState, settled: &RigidState) -> RigidState {
    let Rigid { impulse, angular_impulse, .. } = settled.rigid;
    let mut state = first.clone();
    state.rigid.velocity += impulse / state.rigid.mass;
    state.rigid.spin += state.rigid.inertia.to_mat().inverse() * angular_impulse;
    (state.rigid.impulse, state.rigid.angular_impulse) = (impulse, angular_impulse);
    state
}

/// Deviation from free motion by those bodies that count.
fn deviation(under_way: &RigidStep, counts: impl Fn(Entity) -> bool) -> [DVec3; 2] {
    let deviations = under_way.deviations.iter().filter(|(body, _)| counts(*body));
    deviations.fold(under_way.expected, |[way, turn], (_, by)| [way + by[0], turn + by[1]])
}

/// Puts an obstacle where the deviations by some bodies lead.
fn settle_place(
    obstacle: &mut Obstacle,
    motion: &mut ObstacleMotion,
    under_way: &RigidStep,
    time: f64,
    counts: impl Fn(Entity) -> bool,
) {
    let mut moving = free(&under_way.part, time);
    let [way, turn] = deviation(under_way, counts);
    moving.velocity += way / time;
    moving.spin += turn / time;
    place(obstacle, motion, &under_way.part, moving, time);
}

/// Settles velocity and spin at the end of a stage by the forces of the bodies.
pub(super) fn settle(world: &mut World, step: &StepContext) {
    if step.is_static {
        return;
    }
    approach(world, step);
    let rigid = rigid_ones(world);
    let bodies = if rigid.is_empty() { SmallVec::new() } else { bodies(world) };
    let time = step.stage_dt();
    for (at, entity, ..) in rigid {
        {
            // Bodies that have failed since do not count.
            let Ok((obstacle, motion)) = world.query_one_mut::<(&mut Obstacle, &mut ObstacleMotion)>(entity) else {
                continue;
            };
            let Some(under_way) = motion.under_way.take() else { continue };
            settle_place(obstacle, motion, &under_way, time, |body| bodies.contains(&body));
            motion.under_way = Some(under_way);
        }
        let (mut force, mut moment) = (DVec3::ZERO, DVec3::ZERO);
        for &body in &bodies {
            type Query<'a> = (&'a SolveResult, &'a SolverScratch, Option<&'a ExternalStiffness>);
            let Ok((result, scratch, external)) = world.query_one_mut::<Query>(body) else { continue };
            if !(result.is_in_step && scratch.contact.is_known) {
                continue;
            }
            force -=
                scratch.contact.forces.iter().filter(|(other, _)| *other == entity).map(|(_, f)| *f).sum::<DVec3>();
            let coupling = external.and_then(|external| external.coupled.of_obstacle(at));
            moment += coupling.map_or(DVec3::ZERO, |coupling| wrench_of(coupling, &scratch.contact)[1]);
        }
        let Ok((obstacle, motion)) = world.query_one_mut::<(&Obstacle, &mut ObstacleMotion)>(entity) else { continue };
        let (Some(rigid), Some(under_way)) = (&mut motion.rigid, &mut motion.under_way) else { continue };
        let start = &under_way.part.rigid;
        rigid.velocity = start.velocity + (start.acceleration + force / start.mass) * time;
        // Angular momentum is kept where nothing pushes, whatever the axis.
        let angular_momentum = start.inertia * start.spin + moment * time;
        rigid.spin = rigid.inertia.to_mat().inverse() * angular_momentum;
        rigid.impulse = start.impulse + force * time;
        rigid.angular_impulse = start.angular_impulse + moment * time;
        under_way.settled = Some((RigidState { shape: obstacle.shape.clone(), rigid: *rigid }, step.time));
    }
}

/// Ends a step at a time \[ms\]: obstacles that no sound body has gone along with move freely, and one that would leave the range of coordinates stays at its
/// start. Returns the number of those.
pub fn end(world: &mut World, time: f64) -> u32 {
    let mut refused = 0;
    for (obstacle, motion) in world.query_mut::<(&mut Obstacle, &mut ObstacleMotion)>() {
        let Some(under_way) = motion.under_way.take() else { continue };
        let RigidStep { first, first_time, settled, .. } = *under_way;
        let begun = first.clone();
        // Of a step that was given up nothing stays.
        let is_gone = |(_, reached): &(RigidState, f64)| *reached <= time + SAME_TIME * (reached - first_time);
        let (state, reached) = settled.filter(is_gone).unwrap_or((first, first_time));
        let left = time - reached;
        obstacle.shape = state.shape.clone();
        motion.rigid = Some(state.rigid);
        if left > SAME_TIME * (time - first_time) {
            place(obstacle, motion, &state, free(&state, left), left);
        }
        let is_sound = motion.rigid.is_some_and(|rigid| rigid.check("Rigid").is_ok());
        if !(is_sound && obstacle.shape.check("Obstacle").is_ok()) {
            refused += 1;
            obstacle.shape = begun.shape.clone();
            *motion = ObstacleMotion { rigid: Some(begun.rigid), ..ObstacleMotion::at(begun.shape) };
        }
    }
    refused
}

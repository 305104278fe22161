//! Coulomb's friction by return mapping (Laursen, Simo 1993): a spring across the normal, as stiff as the contact, from the place where a
//! vertex sticks. Its force is bounded by μ times the normal force, and a vertex that slips moves the place.
//!
//! A step of one linear solve foresees the slip by the two steps before: of a vertex that will slip the spring is the secant
//! μ·N/|offset foreseen|, which never does work on it. Where the answer is far from the law, a further solve has Newton's tangent: a
//! slipping vertex bears μ·N along its slip, and one whose slip turns round between two solves sticks.

use super::{Obstacles, Travel};
use crate::components::{
    Contact, ContactScratch, ExternalStiffness, FrictionContact, FrictionPoint, Increment, RigidCoupling, SolveResult,
    SolverScratch, Touch,
};
use crate::math::Sym3;
use crate::storage::Vertices;
use crate::systems::context::Formula;
use crate::systems::{StepContext, parallel};
use glam::DVec3;

/// Error of the friction in a solve's answer that asks for a further solve, summed over the vertices, relative to the sum of μ·N.
const TOLERANCE: f64 = 0.02;

/// Part of the normal forces on a rigid obstacle that may pull in a solve's answer: springs of vertices that it has left.
const MOST_PULL: f64 = 0.02;

/// Part of Newton's tangent under an obstacle that tissue moves. With all of it solves diverge where little else holds the
/// obstacle, with none of it they converge slowly (`cargo test --release --test contact box_stays`, `rests_on_a_drum`).
const RIGID_TANGENT: f64 = 0.5;

/// Part of a vector across a normal.
fn across(normal: DVec3, u: DVec3) -> DVec3 {
    u - normal * u.dot(normal)
}

/// Adds the friction of one obstacle to the normal forces of the vertices from place `first` on.
pub(super) fn add(
    scratch: &mut ContactScratch,
    first: usize,
    (travel, coefficient): (&Travel, f64),
    (vertices, increment, result): (&Vertices, &Increment, &SolveResult),
    step: &StepContext,
) {
    let ContactScratch { forces, touched, friction_points: points, friction_points_before: points_before, .. } =
        scratch;
    let Some(&(obstacle, _)) = forces.last() else { return };
    // Newton's method, and the forces at the start of a step of two stages, go by the law where the vertices are.
    let is_linear = step.newton_iterations == 1 && step.formula != Formula::Start;
    let is_again = result.newton_iterations > 0;
    let friction = increment.last.friction.as_deref();
    let begin = points.len();
    let touches = (first as u32..).zip(&touched[first..]).filter(|(_, touch)| touch.force != DVec3::ZERO);
    points.extend(touches.map(|(touch, &Touch { place, row, .. })| FrictionPoint {
        place,
        row,
        touch,
        ..FrictionPoint::default()
    }));
    parallel::for_rows(&mut points[begin..], |_, point| {
        let (touch, v) = (&touched[point.touch as usize], point.row as usize);
        let (start, x) = (increment.start[v], vertices.position[v]);
        let is_lifted = touch.force.dot(touch.normal) < 0.0;
        point.normal = if is_lifted { touch.normal } else { touch.force.normalize() };
        point.stiffness = touch.block.diagonal.element_sum();
        let past = friction.and_then(|friction| friction.at_start(obstacle.into(), point.row));
        let before =
            || points_before.binary_search_by_key(&(point.place, point.row), |point| (point.place, point.row)).ok();
        let before = before().filter(|_| is_again).map(|at| &points_before[at]);
        let carried = |u: DVec3| across(point.normal, travel.turned(u));
        point.start = past.map_or(DVec3::ZERO, |past| carried(past.offset));
        point.offset = point.start + across(point.normal, travel.slip(start, x));
        let guess = if is_linear { increment.delta[v] } else { DVec3::ZERO };
        let is_first = is_linear && !(is_again || step.is_static) && increment.displacement[v] == DVec3::ZERO;
        let foreseen = match past.filter(|_| is_first) {
            // A slip that ends is left to further solves: a spring that is too stiff would draw tissue along with the obstacle.
            Some(&FrictionContact { slip: [last, before], .. }) => {
                let next = last * 2.0 - before;
                let longer = if next.length_squared() > last.length_squared() { next } else { last };
                point.start + carried(longer) * step.stage_dt()
            }
            None => point.start + across(point.normal, travel.slip(start, x + guess)),
        };
        // The depth at the evaluation may be that of a vertex which the solve pushes out: one that was not in touch rubs from the next solve on.
        let known = before.map(|before| before.normal_force).or(past.map(|past| past.normal_force));
        let limit = coefficient
            * match is_linear {
                true => known.unwrap_or(0.0),
                false if is_lifted => 0.0,
                false => touch.force.length(),
            };
        let turns = before.is_some_and(|before| before.slips && before.offset.dot(point.offset) < 0.0);
        point.slips = !(turns && is_linear) && point.stiffness * foreseen.length() > limit;
        point.spring = if point.slips { limit / foreseen.length() } else { point.stiffness };
        let has_newton_tangent = step.is_static || is_linear && !(step.is_correction || step.is_corrector);
        point.is_constant = point.slips && before.is_some() && !turns && has_newton_tangent;
    });
    for point in &points[begin..] {
        let touch = &mut touched[point.touch as usize];
        touch.force -= point.offset * point.spring;
        touch.block += (Sym3::IDENTITY - Sym3::outer(point.normal)) * point.spring;
        if point.is_constant {
            let part = if travel.is_rigid { RIGID_TANGENT } else { 1.0 };
            touch.block += Sym3::outer(point.offset.normalize_or_zero()) * (-part * point.spring);
        }
    }
}

/// A body after a solve.
type Solved<'a> = (
    (&'a Vertices, &'a Increment, &'a mut SolveResult, &'a mut SolverScratch),
    (Option<&'a Contact>, Option<&'a ExternalStiffness>),
);

/// Whether friction is far from its law in the answer, or a rigid obstacle pulls, or `waits` on its way; with the sum of squares of Coulomb's bounds \[N²\].
fn is_far(
    ((vertices, increment, result, scratch), (contact, external)): &Solved<'_>,
    (obstacles, waits): (&Obstacles, bool),
) -> (bool, f64) {
    if !(result.newton_iterations > 0 && result.is_in_step) {
        return (false, 0.0);
    }
    let (mut error, mut limit, mut limit_sq) = (0.0, 0.0, 0.0);
    if let Some(contact) = contact {
        for (point, place) in places(&scratch.contact, (obstacles, contact.friction), (*vertices, *increment)) {
            let force = across(point.normal, scratch.contact.touched[point.touch as usize].force);
            error += (force + place.offset * point.stiffness).length();
            limit += place.limit;
            limit_sq += place.limit * place.limit;
        }
    }
    let is_pulled = |coupling: &RigidCoupling| pull(coupling, &scratch.contact) > MOST_PULL;
    let pulls = contact.is_some() && waits || external.is_some_and(|of| of.coupled.rigid.iter().any(is_pulled));
    (error > TOLERANCE * limit || pulls, limit_sq)
}

/// Marks for another solve the bodies whose friction is far from its law in the answer, and those that a rigid obstacle has drawn along by vertices that it
/// does not touch in the answer, or has left so that it is on its way to them again. Returns their number.
pub fn far_from_law(world: &mut hecs::World, step: &StepContext) -> usize {
    let obstacles = super::obstacles(world);
    if obstacles.is_empty() {
        world.query_mut::<&mut SolveResult>().into_iter().for_each(|result| result.select(false));
        return 0;
    }
    let waits = super::rigid::any_waits(world);
    let mut count = 0;
    for mut solved in world.query_mut::<Solved>() {
        let (is_far, limit_sq) = is_far(&solved, (&obstacles, waits));
        let (_, _, result, scratch) = &mut solved.0;
        let asks = is_far && step.affords(result, 1);
        if asks {
            // Beside the forces that have pushed vertices out friction and weight are nothing.
            scratch.reference_sq = limit_sq;
        }
        result.select(asks);
        count += usize::from(asks);
    }
    count
}

/// Notes the bodies whose friction is still far from its law after the rounds. Returns their number.
pub fn unsettled(world: &mut hecs::World, step: &StepContext) -> usize {
    let obstacles = super::obstacles(world);
    if obstacles.is_empty() || step.is_resumed {
        return 0;
    }
    let waits = super::rigid::any_waits(world);
    let mut count = 0;
    for solved in world.query_mut::<Solved>() {
        let (is_far, _) = is_far(&solved, (&obstacles, waits));
        solved.0.2.is_traction_unsettled |= is_far;
        count += usize::from(is_far);
    }
    count
}

/// Part of the normal forces on a rigid obstacle that pulls.
fn pull(coupling: &RigidCoupling, contact: &ContactScratch) -> f64 {
    let of_obstacle = &contact.touched[coupling.first..][..coupling.rows.len()];
    let forces = of_obstacle.iter().map(|touch| touch.force.dot(touch.normal));
    let [pulling, pushing] =
        forces.fold([0.0, 0.0], |[pull, push], force| [pull - force.min(0.0), push + force.max(0.0)]);
    if pulling > 0.0 { pulling / pushing.max(pulling) } else { 0.0 }
}

/// A vertex in touch at the end of a solve, by the law.
struct Place {
    /// Tangential way from the place where the vertex sticks \[mm\].
    offset: DVec3,
    /// Slip in the step \[mm\].
    slip: DVec3,
    /// Coulomb's bound μ·N \[N\].
    limit: f64,
}

/// Vertices that point in the answer of the last solve: those out of touch there have neither force nor limit.
fn places<'a>(
    scratch: &'a ContactScratch,
    (obstacles, coefficient): (&'a Obstacles, f64),
    (vertices, increment): (&'a Vertices, &'a Increment),
) -> impl Iterator<Item = (&'a FrictionPoint, Place)> {
    scratch.friction_points.iter().filter_map(move |point| {
        let v = point.row as usize;
        let (_, (_, travel)) = obstacles.get(point.place as usize)?;
        let limit = coefficient * scratch.touched[point.touch as usize].force.dot(point.normal).max(0.0);
        let slip = across(point.normal, travel.slip(increment.start[v], vertices.position[v]));
        let offset = point.start + slip;
        let length = offset.length();
        let most = limit / point.stiffness;
        let offset = if length > most { offset * (most / length) } else { offset };
        Some((point, Place { offset, slip, limit }))
    })
}

/// Settles where every vertex sticks at the end of the step.
pub fn settle(world: &mut hecs::World, step: &StepContext) -> usize {
    let obstacles = super::obstacles(world);
    let mut count = 0;
    type Query<'a> = (&'a Vertices, &'a mut Increment, &'a SolveResult, &'a SolverScratch, &'a Contact);
    for (vertices, increment, result, scratch, contact) in world.query_mut::<Query>() {
        let rubs = !scratch.contact.friction_points.is_empty() || increment.last.friction.is_some();
        if !(result.is_in_step && rubs) {
            continue;
        }
        count += 1;
        let mut friction = increment.last.friction.take().unwrap_or_default();
        let mut settled = std::mem::take(&mut friction.end);
        settled.clear();
        let inverse_dt = if step.is_static { 0.0 } else { 1.0 / step.dt };
        for (point, place) in places(&scratch.contact, (&obstacles, contact.friction), (vertices, increment)) {
            if !(place.limit > 0.0) {
                continue;
            }
            let obstacle = obstacles[point.place as usize].0.into();
            let past = friction.at_start(obstacle, point.row);
            let last = place.slip * inverse_dt;
            let slip = [last, past.map_or(last, |past| past.slip[0])];
            let normal_force = place.limit / contact.friction;
            settled.push(FrictionContact { obstacle, row: point.row, offset: place.offset, slip, normal_force });
        }
        friction.end = settled;
        increment.last.friction = Some(friction);
    }
    count
}

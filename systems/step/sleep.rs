//! Sleep: who wakes at the start of a step, and who falls asleep in it.
//!
//! The remaining displacement of a body at x with the velocity v is bounded by (K + M/T²)⁻¹·f(x) and (K + M/T²)⁻¹·M·v/dt, with
//! its tangent K and the forces f at x. The first is the way to its equilibrium, the second the way on which its momentum of a
//! step is used up. In an oscillation one is largest where the other is zero, so both must be small. The mass over T = a
//! thousand steps stands for parts that have no stiffness of their own.

use crate::components::{
    Compartment, Contact, EdgeLoads, EnergyAudit, ExternalStiffness, Forces, Frames, Grips, HoldGuides, HoldTurns,
    Holds, Increment, Obstacle, PointLoads, Pose, Pressure, SleepState, Sleeping, SolveResult, SolverScratch,
    TearDecisions, TearLog, Tearing,
};
use crate::event::{EventKind, WokenBy};
use crate::settings::{LinearParams, Tangent};
use crate::storage::{Tips, Topology, Triangles, Vertices};
use crate::systems::bending::{BendingPasses, DihedralAngles};
use crate::systems::solver::{self, Available, MixedPreconditioner, MixedSolver, Operator, ProductMemory};
use crate::systems::{Formula, StepContext, parallel};
use glam::DVec3;
use smallvec::SmallVec;

/// Steps in which parts without stiffness may still move.
const HORIZON: f64 = 1000.0;

/// Limits of the trial solves before sleep.
const TRIAL: LinearParams = LinearParams::by_residual(1e-3, 1000);

/// Maximum number of quiet steps between two trials.
const LONGEST_WAIT: u32 = 128;

/// Query of the external drives of a body.
type Drive<'a> = (
    (Option<&'a Holds>, Option<&'a HoldTurns>, Option<&'a HoldGuides>, Option<&'a Grips>),
    (Option<&'a Pressure>, Option<&'a PointLoads>, Option<&'a EdgeLoads>),
);

/// Bending.
type Bent<'a> = Option<(&'a DihedralAngles, &'a mut BendingPasses)>;

/// Query of the components that the solves before sleep take.
type Body<'a> = (
    (&'a mut Vertices, &'a Triangles, &'a Topology),
    (&'a Frames, &'a mut Forces, Option<&'a ExternalStiffness>, Bent<'a>),
    (&'a mut Increment, &'a mut MixedSolver, &'a mut SolveResult, &'a mut SolverScratch),
);

type TearState<'a> = Option<(&'a Tearing, &'a Tips, &'a TearDecisions)>;

type Obstacles = SmallVec<[Obstacle; 8]>;

/// Wakes the bodies that sleep although something has changed that acts on them; a static solve wakes all.
pub fn wake(world: &mut hecs::World, step: &StepContext) -> usize {
    let obstacles: Obstacles = world.query_mut::<&Obstacle>().into_iter().cloned().collect();
    let mut count = 0;
    type Query<'a> = (&'a mut Sleeping, &'a mut TearLog, Option<&'a Contact>, Drive<'a>);
    for (sleeping, log, contact, drive) in world.query_mut::<Query>().with::<&SolveResult>() {
        if !sleeping.is_asleep() {
            continue;
        }
        count += 1;
        let by = if step.is_static {
            WokenBy::StaticSolve
        } else if !driven(drive, step.end()).eq(sleeping.state.driven.iter().copied()) {
            WokenBy::Drive
        } else if contact.is_some() && has_moved(&obstacles, &sleeping.state) {
            WokenBy::Obstacle
        } else {
            continue;
        };
        sleeping.wake();
        log.pending.push(EventKind::Woke { by });
    }
    count
}

/// Puts bodies to sleep whose remaining motion is small, before the step is solved. Runs before drag, whose term in the
/// equations looks like a stiffness.
pub fn fall_asleep(world: &mut hecs::World, step: &StepContext) -> usize {
    let is_beginning = matches!(step.formula, Formula::BackwardEuler | Formula::Trapezoidal);
    if step.is_static || step.is_resumed || !is_beginning {
        return 0;
    }
    let obstacles: Obstacles = world.query_mut::<&Obstacle>().into_iter().cloned().collect();
    type Query<'a> = (Body<'a>, (&'a mut Sleeping, &'a mut TearLog), TearState<'a>, Option<&'a Contact>, Drive<'a>);
    parallel::for_bodies::<hecs::Without<Query, hecs::Or<&EnergyAudit, &Compartment>>>(
        world,
        |(((_, triangles, _), _, (_, _, result, _)), ..)| match result.newton_iterations {
            0 => result.rows_to_solve(triangles.len()),
            _ => 0,
        },
        |(mut body, (sleeping, log), tears, contact, drive)| {
            let is_drawn = drive.0.3.is_some_and(|grips| grips.pinches.iter().any(|pinch| pinch.paced().is_some()));
            if !(is_ready(sleeping, &body, step) && will_stay(sleeping, &body, tears)) || is_drawn {
                return;
            }
            let Sleeping { strain, state, .. } = sleeping;
            if !(strain_left(state, &mut body, step) <= *strain) {
                state.quiet_steps = 0;
                state.wait = (2 * state.wait).min(LONGEST_WAIT);
                return;
            }
            state.is_asleep = true;
            state.driven.clear();
            state.driven.extend(driven(drive, step.end()));
            state.obstacles.clear();
            if contact.is_some() {
                state.obstacles.extend_from_slice(&obstacles);
                state.ball = ball(&body.0.0.position);
            }
            lie_down(body);
            log.pending.push(EventKind::FellAsleep);
        },
    )
}

/// The values of everything that moves or loads a body over time.
fn driven<'a>(drive: Drive<'a>, time: f64) -> impl Iterator<Item = f64> + 'a {
    let ((holds, turns, guides, grips), (pressure, point_loads, edge_loads)) = drive;
    let holds = holds.into_iter().flat_map(|holds| &holds.groups).map(|hold| &hold.curve);
    let pressure = pressure.into_iter().map(|pressure| &pressure.curve);
    let point_loads = point_loads.into_iter().flat_map(|loads| &loads.groups).map(|load| &load.curve);
    let edge_loads = edge_loads.into_iter().flat_map(|loads| &loads.groups).map(|load| &load.curve);
    let clamps = guides.into_iter().flat_map(HoldGuides::curves);
    let holds = holds.chain(clamps);
    let curves = holds.chain(pressure).chain(point_loads).chain(edge_loads).map(move |curve| curve.at(time));
    let hands = grips.into_iter().flat_map(|grips| &grips.pinches).filter(|pinch| pinch.forceps.is_some());
    let hands = hands.flat_map(move |pinch| {
        let Pose { position, orientation } = pinch.motion.at(time);
        position.to_array().into_iter().chain(orientation.to_array())
    });
    let grips = grips.into_iter().flat_map(|grips| &grips.list).flat_map(move |grip| {
        let is_closed = (grip.from..grip.until).contains(&time);
        let hand = if is_closed { grip.path.at(time) } else { DVec3::ZERO };
        [f64::from(u8::from(is_closed)), hand.x, hand.y, hand.z]
    });
    let turns = turns.into_iter().flat_map(|turns| &turns.list);
    let turns = turns.flat_map(move |(_, turning)| turning.vectors.at(time).to_array());
    curves.chain(grips).chain(hands).chain(turns)
}

/// Whether an obstacle that has come, gone or moved could touch the body, where it was or where it is.
fn has_moved(obstacles: &[Obstacle], state: &SleepState) -> bool {
    let before = &state.obstacles;
    let (centre, radius) = state.ball;
    (0..obstacles.len().max(before.len())).any(|i| {
        let places = [before.get(i), obstacles.get(i)];
        places[0] != places[1] && places.into_iter().flatten().any(|o| o.shape.reaches(centre, radius))
    })
}

/// Whether the body has been quiet for long enough. One that moves is found out by its first triangles.
fn is_ready(sleeping: &mut Sleeping, body: &Body, step: &StepContext) -> bool {
    let ((vertices, triangles, _), (_, _, external, _), (increment, .., scratch)) = body;
    if triangles.relaxing.as_ref().is_some_and(|relaxing| relaxing.largest_spring() > sleeping.strain) {
        // The stress falls where nothing moves.
        return false;
    }
    if scratch.contact.has_neighbours || external.as_ref().is_some_and(|external| !external.coupled.rigid.is_empty()) {
        // A rigid obstacle, or another body, that lies on a body would fall while that sleeps.
        return false;
    }
    let moved = |v: usize| {
        let prescribed = increment.delta[v] * (DVec3::ONE - scratch.free[v]);
        vertices.velocity[v].length() * step.dt + prescribed.length()
    };
    let is_quiet = (0..triangles.len()).all(|t| strain_of(triangles, t, moved) <= sleeping.strain);
    let state = &mut sleeping.state;
    if !is_quiet {
        (state.quiet_steps, state.wait) = (0, sleeping.steps);
        return false;
    }
    state.quiet_steps += 1;
    state.quiet_steps >= state.wait.max(sleeping.steps)
}

/// Σᵢ |uᵢ|·|∇Nᵢ|: no strain and no rotation of a triangle is larger, and none of its heights times this is less than the
/// displacement of its corners.
fn strain_of(triangles: &Triangles, t: usize, moved: impl Fn(usize) -> f64) -> f64 {
    let gradients = triangles.rest[t].all_gradients();
    (0..3).map(|i| moved(triangles.corners[t][i] as usize) * gradients[i].length()).sum()
}

/// Whether the remaining strain can bring no tip and no nucleation site to its criterion.
fn will_stay(sleeping: &Sleeping, body: &Body, tears: TearState) -> bool {
    let Some((tearing, tips, decisions)) = tears else { return true };
    let ((_, triangles, _), (frames, ..), _) = body;
    let least = tearing.strength_along_fibres.min(tearing.strength_across_fibres) * triangles.least_strength();
    let stiffest = (0..triangles.len())
        .map(|t| frames.stiffness(triangles, t))
        .map(|q| q.q11.max(q.q22) + q.q12.abs() + q.q66)
        .fold(0.0, f64::max);
    let more = stiffest * sleeping.strain;
    let is_sound = || frames.states().all(|state| state.stress.principal_values().0 + more <= least);
    tips.criterion.iter().all(|c| c + more / least <= 1.0)
        && decisions.refused_nucleation.is_none()
        && (!tearing.may_initiate || is_sound())
}

/// The largest strain of the remaining displacement of a body; NaN where a solve gives none.
fn strain_left(state: &mut SleepState, body: &mut Body, step: &StepContext) -> f64 {
    let ((vertices, triangles, topology), (frames, forces, external, bent), (increment, mixed, _, scratch)) = body;
    state.first_guess.clone_from(&increment.delta);
    state.left.clear();
    state.left.resize(vertices.len(), 0.0);
    scratch.residual.resize(vertices.len(), DVec3::ZERO);
    scratch.is_audited = step.asks_for_exact_residual(false);
    let mut spare = BendingPasses::default();
    let (folds, passes) = match bent {
        Some((folds, passes)) => (Some(&**folds), &mut **passes),
        None => (None, &mut spare),
    };
    let inertia = step.inertia() / (HORIZON * HORIZON);
    let operator = Operator {
        external: *external,
        folds,
        inertia,
        ..Operator::membrane((vertices, triangles, topology, frames), Tangent::Rotated)
    };
    // Guided vertices count as held: the forces that move them are in balance, or the body is not at rest.
    let guide_constraints = std::mem::take(&mut scratch.guide_constraints);
    let mut is_converged = true;
    for is_momentum in [false, true] {
        for (v, x) in increment.delta.iter_mut().enumerate() {
            let own = DVec3::ONE - scratch.free[v];
            *x = if is_momentum { DVec3::ZERO } else { state.first_guess[v] * own };
            let momentum = vertices.velocity[v] * (vertices.mass[v] * step.inv_effective_dt());
            scratch.residual[v] = if is_momentum { momentum } else { forces.nodal[v] };
        }
        scratch.reference_sq = 0.0;
        let mut available =
            Available { mixed: Some((mixed, MixedPreconditioner::IncompleteCholesky)), ..Available::default() };
        let mut memory = ProductMemory { corner: &mut forces.corner, passes: &mut *passes };
        let answer = solver::solve(&operator, &TRIAL, &mut available, &mut memory, &mut increment.delta, scratch);
        is_converged &= answer.is_ok_and(|info| info.relative_residual <= TRIAL.tolerance);
        state.left.iter_mut().zip(&increment.delta).for_each(|(left, x)| *left += x.length());
    }
    scratch.guide_constraints = guide_constraints;
    // This operator is no step's.
    mixed.forget_operator();
    increment.delta.copy_from_slice(&state.first_guess);
    let largest = (0..triangles.len()).map(|t| strain_of(triangles, t, |v| state.left[v])).fold(0.0, f64::max);
    if is_converged { largest } else { f64::NAN }
}

/// Brings the body to rest in place, also for the case that the step is undone.
fn lie_down(body: Body) {
    let ((vertices, ..), _, (increment, _, result, _)) = body;
    vertices.velocity.fill(DVec3::ZERO);
    increment.start_velocity.fill(DVec3::ZERO);
    increment.delta.fill(DVec3::ZERO);
    result.take_part(false);
}

/// A ball around points.
fn ball(points: &[DVec3]) -> (DVec3, f64) {
    let corner = |pick: fn(DVec3, DVec3) -> DVec3| points.iter().copied().reduce(pick).unwrap_or_default();
    let (low, high) = (corner(DVec3::min), corner(DVec3::max));
    (low.midpoint(high), 0.5 * low.distance(high))
}

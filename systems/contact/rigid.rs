//! Rigid obstacles that tissue pushes back.
//!
//! An obstacle with mass moves freely over the step, and tissue in touch makes it deviate. Its six unknowns stand in the solve of the
//! body in touch and are eliminated there, so a light obstacle is as stable as a heavy one: forces that lag by a step are not, once
//! Δt²·K/m > 1. Time integration is that of backward Euler, in a step of two stages in both of them over the time from its start. Of
//! several bodies in touch each moves its share of the mass, and the obstacle goes the mean of their ways (mass splitting, Tonge,
//! Benevolenski and Voroshilov 2012): forces on both sides of it balance over some steps, not within one.
//!
//! Velocity and spin at the end come from the forces that the bodies report, so that the sum of both momenta is kept.

use super::{Obstacles, Travel, held, obstacles};
use crate::components::{
    Body, Contact, ContactScratch, ExternalStiffness, Forces, Increment, Obstacle, ObstacleMotion, Rigid,
    RigidCoupling, RigidState, RigidStep, Shape, Six, SolveResult, SolverScratch, cholesky, solve_lower, solve_upper,
    turned_inertia,
};
use crate::math::{Sym3, elementary};
use crate::storage::{Triangles, Vertices};
use crate::systems::StepContext;
use crate::systems::context::Formula;
use glam::{DMat3, DVec3};
use hecs::{Entity, World};
use smallvec::SmallVec;

/// Relative difference of two times that are one.
const SAME_TIME: f64 = 1e-9;

/// Part of its way by which an obstacle may begin beyond the first touch.
const TOUCH: f64 = 1e-3;

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

/// Moves rigid obstacles that touch nothing on their way without tissue, up to where they first touch it: beyond they would meet vertices
/// that they will not touch, and draw them along.
pub(super) fn approach(world: &mut World, step: &StepContext) {
    if step.is_static || step.formula == Formula::Start {
        return;
    }
    let entities: SmallVec<[Entity; 8]> = obstacles(world).iter().map(|(entity, _)| *entity).collect();
    for entity in entities {
        let Ok((obstacle, motion)) = world.query_one_mut::<(&mut Obstacle, &mut ObstacleMotion)>(entity) else {
            continue;
        };
        let Some(mut under_way) = motion.under_way.take_if(|under_way| under_way.waits()) else { continue };
        let obstacle = obstacle.clone();
        let time = step.stage_dt();
        let place_at = |part: f64| {
            let expected = under_way.expected.map(|way| way * (1.0 - part));
            let rest = RigidStep { expected, ..(*under_way).clone() };
            let (mut obstacle, mut motion) = (obstacle.clone(), ObstacleMotion::at(obstacle.shape.clone()));
            settle_place(&mut obstacle, &mut motion, &rest, time, |_| true);
            obstacle.shape
        };
        let way = Way { from: obstacle.shape.clone(), to: place_at(1.0), turn: rotation(-under_way.expected[1]) };
        let mut part = 1.0;
        type Query<'a> = (&'a Vertices, &'a Triangles, &'a Contact, &'a SolveResult);
        let mut query = world.query::<Query>();
        for (vertices, triangles, _, _) in query.iter() {
            part = way.first_touch(&place_at, (vertices, triangles), part);
        }
        drop(query);
        under_way.expected = under_way.expected.map(|way| way * (1.0 - part));
        let Ok((obstacle, motion)) = world.query_one_mut::<(&mut Obstacle, &mut ObstacleMotion)>(entity) else {
            continue;
        };
        settle_place(obstacle, motion, &under_way, time, |_| true);
        motion.under_way = Some(under_way);
    }
}

/// Whether an obstacle waits for tissue that it has left in the last solve.
pub(super) fn any_waits(world: &mut World) -> bool {
    let mut motions = world.query_mut::<&ObstacleMotion>().into_iter().filter_map(|motion| motion.under_way.as_ref());
    motions.any(|under_way| under_way.waits())
}

impl RigidStep {
    /// Whether it touches nothing and has not gone all its way.
    fn waits(&self) -> bool {
        self.deviations.is_empty() && self.expected != [DVec3::ZERO; 2]
    }
}

/// The way of an obstacle that has still to be gone.
struct Way {
    from: Shape,
    to: Shape,
    turn: DMat3,
}

impl Way {
    /// The part of the way at which the obstacle has just touched a body, if that is less than `part`.
    fn first_touch(
        &self,
        place_at: &impl Fn(f64) -> Shape,
        (vertices, triangles): (&Vertices, &Triangles),
        mut part: f64,
    ) -> f64 {
        let Self { from, to, turn } = self;
        let x = &vertices.position;
        let travel =
            Travel { offset: to.anchor() - from.anchor(), turn: Some((*turn, from.anchor())), ..Travel::default() };
        let moved = (Obstacle { shape: to.clone() }, travel);
        let mut look = |is_inside: &dyn Fn(&Shape) -> bool| {
            if !is_inside(&place_at(part)) {
                return;
            }
            let mut low = 0.0;
            if is_inside(from) {
                part = 0.0;
            }
            while part - low > TOUCH {
                let middle = 0.5 * (low + part);
                if is_inside(&place_at(middle)) { part = middle } else { low = middle }
            }
        };
        for &x in x {
            if held(&moved, x, x).is_some() {
                look(&|shape| shape.distance(x).is_some_and(|(distance, _)| distance < 0.0));
            }
        }
        super::faces::for_held(&moved, x, (&x[..], triangles), |t, _| {
            let corners = triangles.corners[t].map(|v| x[v as usize]);
            look(&|shape| {
                let deepest = super::faces::deepest(shape, corners);
                let place = deepest.map(|weights| super::faces::at(corners, weights));
                place.and_then(|x| shape.distance(x)).is_some_and(|(distance, _)| distance < 0.0)
            });
        });
        part
    }
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

/// The bodies in order of spawning.
fn bodies(world: &mut World) -> SmallVec<[Entity; 8]> {
    let found = world.query_mut::<(Entity, &Body)>().with::<&SolveResult>();
    let mut bodies: SmallVec<[(u32, Entity); 8]> =
        found.into_iter().map(|(entity, body)| (body.order, entity)).collect();
    bodies.sort_unstable_by_key(|(order, _)| *order);
    bodies.into_iter().map(|(_, entity)| entity).collect()
}

/// The rigid ones of the obstacles, by their places among all.
fn rigid_ones(world: &World, obstacles: &Obstacles) -> SmallVec<[(u32, Entity, Rigid, Six); 4]> {
    let found = (0..).zip(obstacles).filter_map(|(at, (entity, _))| {
        let motion = world.get::<&ObstacleMotion>(*entity).ok()?;
        let is_sound = |body: Entity| world.satisfies::<&SolveResult>(body);
        let sum = deviation(motion.under_way.as_ref()?, is_sound);
        Some((at, *entity, motion.rigid?, six(sum)))
    });
    found.collect()
}

/// Deviation from free motion by those bodies that count.
fn deviation(under_way: &RigidStep, counts: impl Fn(Entity) -> bool) -> [DVec3; 2] {
    let deviations = under_way.deviations.iter().filter(|(body, _)| counts(*body));
    deviations.fold(under_way.expected, |[way, turn], (_, by)| [way + by[0], turn + by[1]])
}

fn six([a, b]: [DVec3; 2]) -> Six {
    [a.x, a.y, a.z, b.x, b.y, b.z]
}

/// Columns of B·J at a vertex in touch: its spring forces for the six motions of the obstacle, `arm` from whose centre it is.
fn columns(block: Sym3, arm: DVec3) -> [DVec3; 6] {
    let block = block.to_mat();
    let turning = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| block * axis.cross(arm));
    [block.x_axis, block.y_axis, block.z_axis, turning[0], turning[1], turning[2]]
}

/// Force and moment of a force that acts at an arm.
fn wrench(force: DVec3, arm: DVec3) -> Six {
    six([force, arm.cross(force)])
}

/// Force and moment of a body on an obstacle in the answer of its last solve.
fn wrench_of(coupling: &RigidCoupling, contact: &ContactScratch) -> [DVec3; 2] {
    let touches = &contact.touched[coupling.first..][..coupling.rows.len()];
    touches.iter().fold([DVec3::ZERO; 2], |[force, moment], touch| {
        [force - touch.force, moment - (touch.point - coupling.centre).cross(touch.force)]
    })
}

fn add(sum: &mut Six, other: &Six, factor: f64) {
    sum.iter_mut().zip(other).for_each(|(sum, other)| *sum += other * factor);
}

/// Takes the rigid obstacles in touch into the solves of the bodies.
pub(super) fn couple(world: &mut World, step: &StepContext) {
    if step.is_static || step.formula == Formula::Start {
        return;
    }
    let obstacles = obstacles(world);
    let rigid = rigid_ones(world, &obstacles);
    if rigid.is_empty() {
        return;
    }
    let bodies = bodies(world);
    let inertia = 1.0 / (step.stage_dt() * step.stage_dt());
    type Query<'a> = (&'a SolveResult, &'a mut SolverScratch, &'a mut Forces, Option<&'a mut ExternalStiffness>);
    for &(at, _, rigid, deviation) in &rigid {
        // Bodies that are solved share the obstacle; the forces of the others stand.
        let (mut sharing, mut standing) = (0, [0.0; 6]);
        for &body in &bodies {
            let Ok((result, scratch, _, external)) = world.query_one_mut::<Query>(body) else { continue };
            if !result.is_in_step {
                continue;
            }
            if result.is_active() {
                sharing += u32::from(scratch.contact.touched.iter().any(|touch| touch.place == at));
                continue;
            }
            let coupling =
                external.and_then(|external| external.coupled.rigid.iter().find(|coupling| coupling.place == at));
            if let Some(coupling) = coupling {
                add(&mut standing, &six(wrench_of(coupling, &scratch.contact)), 1.0);
            }
        }
        let share = 1.0 / f64::from(sharing.max(1));
        for &body in &bodies {
            let Ok((result, scratch, forces, Some(external))) = world.query_one_mut::<Query>(body) else { continue };
            if result.is_active() {
                let known = (at, rigid, deviation, standing);
                external.coupled.rigid.extend(coupling(known, (share, inertia), &mut scratch.contact, forces));
            }
        }
    }
}

/// Coupling of a body to one obstacle; the forces on the vertices in touch become those with the obstacle where it would rest among them.
fn coupling(
    (at, rigid, deviation, standing): (u32, Rigid, Six, Six),
    (share, inertia): (f64, f64),
    contact: &mut ContactScratch,
    forces: &mut Forces,
) -> Option<RigidCoupling> {
    let first = contact.touched.iter().position(|touch| touch.place == at)?;
    let touches = &mut contact.touched[first..];
    let count = touches.iter().take_while(|touch| touch.place == at).count();
    let touches = &mut touches[..count];
    let mass = share * inertia * rigid.mass;
    let of_turn = (rigid.inertia * (share * inertia)).to_mat();
    let mut matrix: [Six; 6] = std::array::from_fn(|i| {
        std::array::from_fn(|j| match (i, j) {
            (3.., 3..) => of_turn.col(j - 3)[i - 3],
            _ if i == j => mass,
            _ => 0.0,
        })
    });
    // Inertia of the deviation so far.
    let mut load: Six = std::array::from_fn(|i| -(0..6).map(|j| matrix[i][j] * deviation[j]).sum::<f64>());
    add(&mut load, &standing, share);
    let mut rows: Vec<(u32, [DVec3; 6])> = Vec::with_capacity(count);
    for touch in &*touches {
        let arm = touch.point - rigid.centre;
        let columns = columns(touch.block, arm);
        for (j, column) in columns.iter().enumerate() {
            let of_column = wrench(*column, arm);
            matrix.iter_mut().zip(of_column).for_each(|(row, value)| row[j] += value);
        }
        add(&mut load, &wrench(-touch.force, arm), 1.0);
        rows.push((touch.row, columns));
    }
    let lower = cholesky(&matrix)?;
    let base = solve_upper(&lower, solve_lower(&lower, load));
    for (touch, (row, columns)) in touches.iter_mut().zip(&mut rows) {
        let along = RigidCoupling::back(columns, &base);
        touch.force += along;
        forces.nodal[*row as usize] += along;
        // C = B·J·L⁻ᵀ: three systems with L, one for each axis of the vertex.
        let axes: [Six; 3] = [0, 1, 2].map(|axis| solve_lower(&lower, columns.map(|column| column[axis])));
        *columns = std::array::from_fn(|k| DVec3::new(axes[0][k], axes[1][k], axes[2][k]));
    }
    Some(RigidCoupling { place: at, centre: rigid.centre, first, rows, lower, base, share })
}

/// Moves rigid obstacles by the answers of the solves.
pub(super) fn follow(world: &mut World, step: &StepContext) {
    if step.is_static {
        return;
    }
    let obstacles = obstacles(world);
    let rigid = rigid_ones(world, &obstacles);
    if rigid.is_empty() {
        return;
    }
    let bodies = bodies(world);
    for (at, entity, ..) in rigid {
        let mut answers: SmallVec<[(Entity, Option<[DVec3; 2]>); 2]> = SmallVec::new();
        for &body in &bodies {
            type Query<'a> = (&'a SolveResult, &'a Increment, &'a ExternalStiffness);
            let Ok((result, increment, external)) = world.query_one_mut::<Query>(body) else { continue };
            if !result.is_active() {
                continue;
            }
            let coupling = external.coupled.rigid.iter().find(|coupling| coupling.place == at);
            // An answer that is not finite belongs to a step that will be undone.
            let ways = coupling.map(|coupling| coupling.motion(&increment.delta));
            let ways = ways.filter(|ways| ways.iter().all(|way| way.is_finite()));
            answers.push((body, ways));
        }
        let Ok((obstacle, motion)) = world.query_one_mut::<(&mut Obstacle, &mut ObstacleMotion)>(entity) else {
            continue;
        };
        let Some(mut under_way) = motion.under_way.take() else { continue };
        for (body, ways) in answers {
            let known = under_way.deviations.iter().position(|(other, _)| *other == body);
            match (known, ways) {
                (Some(known), Some(ways)) => {
                    under_way.deviations[known].1.iter_mut().zip(ways).for_each(|(sum, way)| *sum += way);
                }
                (None, Some(ways)) => under_way.deviations.push((body, ways)),
                // It does not touch any more, and waits where it is.
                (Some(known), None) => {
                    let (_, ways) = under_way.deviations.remove(known);
                    under_way.expected.iter_mut().zip(ways).for_each(|(sum, way)| *sum += way);
                }
                (None, None) => {}
            }
        }
        settle_place(obstacle, motion, &under_way, step.stage_dt(), |body| bodies.contains(&body));
        motion.under_way = Some(under_way);
    }
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
    let obstacles = obstacles(world);
    let rigid = rigid_ones(world, &obstacles);
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
            let coupling =
                external.and_then(|external| external.coupled.rigid.iter().find(|coupling| coupling.place == at));
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

/// Ends a step at a time \[ms\]: obstacles that no sound body has gone along with move freely.
pub fn end(world: &mut World, time: f64) {
    for (obstacle, motion) in world.query_mut::<(&mut Obstacle, &mut ObstacleMotion)>() {
        let Some(under_way) = motion.under_way.take() else { continue };
        let RigidStep { first, first_time, settled, .. } = *under_way;
        let (state, reached) = settled.unwrap_or((first, first_time));
        let left = time - reached;
        obstacle.shape = state.shape.clone();
        motion.rigid = Some(state.rigid);
        if left > SAME_TIME * (time - first_time) {
            place(obstacle, motion, &state, free(&state, left), left);
        }
    }
}

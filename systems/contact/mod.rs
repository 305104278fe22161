//! Contact with rigid obstacles: a penalty that is implicit in the step, on the side that a vertex came from, and friction.
//!
//! Every vertex is judged in the frame of the obstacle at the end of the step, and a plane holds it. Where it began outside, that
//! is the plane at which its way, the obstacle's motion included, enters. Where it began inside, as at rest it does by a little, it
//! is the plane at the closest point, unless that has changed sides. A vertex that a solve has carried into an obstacle asks
//! for another solve, and one that is still inside then is put back onto its plane. Triangles that are large beside an obstacle
//! are judged in the same way at their deepest point; and none passes through one, whatever comes of that.

mod box_touch;
mod deepest;
mod faces;
pub mod friction;
pub mod layers;
pub mod rigid;
mod side;
mod sweeps;
mod travel;

use crate::components::{
    Contact, ExternalStiffness, Forces, Grips, Increment, Obstacle, ObstacleMotion, ObstaclePath, Planar, Push,
    SolveResult, SolverScratch, Touch,
};
use crate::math::Sym3;
use crate::storage::{Topology, Triangles, Vertices};
use crate::systems::{StepContext, parallel};
use glam::{DMat3, DVec3};
use hecs::{Entity, World};
use travel::{Moved, Obstacles, Travel, obstacles};

/// Default penalty stiffness of a contact, over that of the membrane at the vertex. A vertex at rest is then less than a hundredth
/// of an edge inside at strains of 30 %, and with a curved obstacle long before.
const STIFFNESS: f64 = 30.0;

/// Closest points whose normals differ by more than this cosine lie on different sides.
const SAME_SIDE: f64 = 0.7;

/// A vertex further inside than this part of an edge after a solve asks for another.
const DEEP: f64 = 0.05;

/// Part for a rigid obstacle: in the next step the vertex would be thrown out.
const DEEP_IN_RIGID: f64 = 0.01;

/// See [`bearable`]: of the least half width.
const BEARABLE: f64 = 0.1;

/// Vertices that are judged side by side before those in touch are listed in order: enough for all threads, and little memory.
const WINDOW: usize = 4096;

/// A plane that holds a vertex back.
struct Held {
    /// Depth of the vertex behind the plane \[mm\].
    depth: f64,
    normal: DVec3,
    /// The point of the obstacle at which the plane touches it \[mm\].
    point: DVec3,
}

/// Moves the obstacles that follow a path to where they are at the end of the step, and begins the motion of rigid ones.
pub fn move_obstacles(world: &mut World, step: &StepContext) -> usize {
    let mut count = 0;
    for (obstacle, motion, obstacle_motion) in world.query_mut::<(&mut Obstacle, &ObstaclePath, &mut ObstacleMotion)>()
    {
        count += 1;
        let before = step.time - step.stage_dt();
        let turn = motion.turning.as_ref().map(|turning| turning.at(step.time) * turning.at(before).transpose());
        obstacle_motion.from = motion.at(before);
        obstacle_motion.turn = turn.filter(|turn| *turn != DMat3::IDENTITY);
        obstacle.shape = motion.at(step.time);
    }
    count + rigid::begin(world, step)
}

/// The plane that holds a vertex back that was at `start` and is at `x`.
fn held((obstacle, travel): &Moved, start: DVec3, x: DVec3) -> Option<Held> {
    let shape = &obstacle.shape;
    // Where it would have started with the obstacle where it is at the end.
    let from = travel.carry(start);
    let (distance, normal) = shape.distance(from)?;
    let (point, normal) = if distance >= 0.0 {
        if distance > from.distance(x) {
            return None;
        }
        shape.entry(from, x)?
    } else {
        match shape.distance(x) {
            Some((distance, now)) if now.dot(normal) > SAME_SIDE => (x - now * distance, now),
            _ => (from - normal * distance, normal),
        }
    };
    let depth = (point - x).dot(normal);
    (depth > 0.0).then_some(Held { depth, normal, point })
}

/// The plane of a vertex outside an obstacle that was in touch in the last solve, with a depth below zero.
fn lifted((obstacle, _): &Moved, x: DVec3) -> Option<Held> {
    let (distance, normal) = obstacle.shape.distance(x)?;
    Some(Held { depth: -distance, normal, point: x - normal * distance })
}

/// Penalty stiffness of a vertex \[N/mm\].
fn stiffness(contact: &Contact, triangles: &Triangles, topology: &Topology, v: usize) -> f64 {
    contact.stiffness.map_or_else(
        || {
            let around = &topology.incident[v];
            let of_membrane = |&entry: &u32| {
                let t = entry as usize / 3;
                triangles.stiffness[t].q11.max(triangles.stiffness[t].q22) * triangles.thickness[t]
            };
            STIFFNESS * around.iter().map(of_membrane).sum::<f64>() / around.len().max(1) as f64
        },
        |per_area| per_area * topology.vertex_area(triangles, v as u32),
    )
}

/// Settles the motion of rigid obstacles, and where every vertex sticks, at the end of the step.
pub fn settle(world: &mut World, step: &StepContext) -> usize {
    rigid::settle(world, step);
    friction::settle(world, step)
}

/// Pushes vertices out of obstacles, and brakes them along their surfaces; rigid ones come up to the body, and into its solve.
pub fn contact(world: &mut World, step: &StepContext) -> usize {
    rigid::approach(world, step);
    let count = push(world, step);
    rigid::couple(world, step);
    count
}

fn push(world: &mut World, step: &StepContext) -> usize {
    let obstacles = obstacles(world);
    if obstacles.is_empty() {
        // Touches of obstacles that are gone.
        world.query_mut::<&mut SolverScratch>().with::<&Contact>().into_iter().for_each(|s| s.contact.begin());
        return 0;
    }
    type Query<'a> = (
        (&'a Vertices, &'a Triangles, &'a Topology, &'a Increment, &'a SolveResult, &'a Contact),
        (&'a mut Forces, &'a mut ExternalStiffness, &'a mut SolverScratch),
    );
    parallel::for_bodies::<Query>(
        world,
        |((vertices, _, _, _, result, _), _)| result.rows_to_solve(vertices.len()),
        |((vertices, triangles, topology, increment, result, contact), (forces, external, scratch))| {
            let scratch = &mut *scratch.contact;
            let mut pushed_before: Vec<(u32, u32)> = Vec::new();
            // Rows of a pass before an advance are of another mesh.
            if result.newton_iterations > 0 && !step.is_resumed {
                let is_pushed = |touch: &&Touch| {
                    let is_rigid = obstacles
                        .get(touch.place as usize)
                        .is_some_and(|(_, (_, travel))| travel.is_rigid && !travel.is_shared);
                    is_rigid && touch.is_at_vertex && touch.force.dot(touch.normal) > 0.0
                };
                let pushed = scratch.touched.iter().filter(is_pushed).map(|touch| (touch.place, touch.row));
                pushed_before.extend(pushed);
            }
            scratch.begin();
            let mut is_held = [false; WINDOW];
            for (place, (entity, moved)) in (0..).zip(&obstacles) {
                let touched = &mut scratch.touched;
                let push = |v: usize| {
                    let (start, x) = (increment.start[v], vertices.position[v]);
                    let Held { depth, normal, point } = held(moved, start, x).or_else(|| lifted(moved, x))?;
                    let stiffness = stiffness(contact, triangles, topology, v);
                    let block = Sym3::outer(normal) * stiffness;
                    Some(Push { force: normal * (depth * stiffness), block, point, normal })
                };
                let first_touch = touched.len();
                for first in (0..vertices.len()).step_by(WINDOW) {
                    let found = &mut is_held[..(vertices.len() - first).min(WINDOW)];
                    let is_pushed = |v: usize| held(moved, increment.start[v], vertices.position[v]).is_some();
                    parallel::for_rows(found, |i, found| *found = is_pushed(first + i));
                    let rows = (first as u32..).zip(found).filter(|(_, is_held)| **is_held).map(|(row, _)| row);
                    touched.extend(rows.map(|row| Touch { place, row, is_at_vertex: true, ..Touch::default() }));
                }
                // Vertices that it has pushed stay in the solve until it would draw them: else they would take turns with others.
                let known = touched.len();
                let is_new =
                    |row: u32| touched[first_touch..known].binary_search_by_key(&row, |touch| touch.row).is_err();
                let left = pushed_before.iter().filter(|(other, row)| *other == place && is_new(*row));
                let left: Vec<Touch> = left
                    .map(|(place, row)| Touch { place: *place, row: *row, is_at_vertex: true, ..Touch::default() })
                    .collect();
                if !left.is_empty() {
                    touched.extend(left);
                    touched[first_touch..].sort_unstable_by_key(|touch| touch.row);
                }
                parallel::for_rows(&mut touched[first_touch..], |_, touch| {
                    let Push { force, block, point, normal } = push(touch.row as usize).unwrap_or_default();
                    *touch = Touch { force, block, point, normal, ..*touch };
                });
                scratch.forces.push((*entity, DVec3::ZERO));
                if contact.friction > 0.0 {
                    let of = (&moved.1, contact.friction);
                    friction::add(scratch, first_touch, of, (vertices, increment, result), step);
                }
                let mut sum = DVec3::ZERO;
                for touch in &scratch.touched[first_touch..] {
                    forces.nodal[touch.row as usize] += touch.force;
                    external.block[touch.row as usize] += touch.block;
                    sum += touch.force;
                }
                let add = |v: usize, Push { force, block, point, normal }: Push| {
                    forces.nodal[v] += force;
                    external.block[v] += block;
                    scratch.touched.push(Touch {
                        place,
                        row: v as u32,
                        is_at_vertex: false,
                        force,
                        block,
                        point,
                        normal,
                    });
                    sum += force;
                };
                faces::push(moved, contact, (vertices, triangles, &increment.start[..]), add);
                *scratch.of(*entity) = sum;
            }
        },
    )
}

/// Marks for another solve the bodies of which the last one has carried a vertex deep into an obstacle, or through it, or layers through each other.
/// Returns their number.
pub fn penetrating(world: &mut World, step: &StepContext) -> usize {
    let obstacles = obstacles(world);
    let touches_itself = |contact: &Contact| contact.self_contact.is_some();
    if obstacles.is_empty() && !world.query_mut::<&Contact>().into_iter().any(touches_itself) {
        return 0;
    }
    let mut count = 0;
    type Query<'a> = (
        (&'a Vertices, &'a Triangles, &'a Topology, &'a Increment),
        (&'a mut SolveResult, &'a mut SolverScratch),
        (Option<&'a Contact>, Option<&'a Grips>, Option<&'a Planar>),
    );
    for ((vertices, triangles, topology, increment), (result, scratch), (contact, grips, planar)) in
        world.query_mut::<Query>()
    {
        let is_carried = result.newton_iterations > 0 && result.is_in_step;
        let asks = contact.filter(|_| is_carried).is_some_and(|contact| {
            let looked_at = looked_at(&obstacles, increment, contact);
            let is_deep = |v: usize| {
                let place = |moved: &Moved| held(moved, increment.start[v], vertices.position[v]);
                let limit = |moved: &Moved| {
                    let part = if moved.1.is_rigid { DEEP_IN_RIGID } else { DEEP };
                    part * topology.vertex_area(triangles, v as u32).sqrt()
                };
                let is_deeper = |(moved, held): (&Moved, Held)| held.depth > limit(moved).max(bearable(moved, contact));
                looked_at.iter().any(|(_, moved)| place(moved).is_some_and(|held| is_deeper((moved, held))))
            };
            let is_in_obstacle = !looked_at.is_empty()
                && ((0..vertices.len()).any(is_deep)
                    || has_deep_face(&looked_at, contact, &increment.start, (vertices, triangles)));
            let own = contact.self_contact.filter(|_| !is_in_obstacle && planar.is_none());
            let mesh = (vertices, triangles, topology);
            is_in_obstacle
                || own.is_some_and(|own| layers::asks(mesh, &increment.start, &own, (result, scratch, grips)))
        });
        // A body whose budget allows no other solve is put outside after the last round.
        result.select(asks && step.affords(result, 1));
        count += usize::from(asks);
    }
    count
}

/// Penetration depth \[mm\] that a solve may leave in an obstacle at rest, whatever its edges: vertices inside were pushed
/// there, and are pushed out in the steps that come. But tissue that springs back goes deeper than that in one step, out at the
/// other side. A plane and a mesh have none where the contact is as stiff as it is by default: tissue that lands would leave again by the
/// speed of its way out.
fn bearable((obstacle, travel): &Moved, contact: &Contact) -> f64 {
    let width = obstacle.shape.least_half_width();
    let is_hard = contact.stiffness.is_none() && width.is_infinite();
    if travel.is_none() && !is_hard { BEARABLE * width } else { 0.0 }
}

/// The obstacles in which a body may be deep: those that move, and those into which it has come far enough.
fn looked_at(obstacles: &Obstacles, increment: &Increment, contact: &Contact) -> Obstacles {
    let largest = increment.displacement.iter().map(|u| u.length_squared()).fold(0.0, f64::max).sqrt();
    let is_near = |(_, moved): &&(Entity, Moved)| !moved.1.is_none() || largest > bearable(moved, contact);
    obstacles.iter().filter(is_near).cloned().collect()
}

fn has_deep_face(
    obstacles: &Obstacles,
    contact: &Contact,
    start: &[DVec3],
    (vertices, triangles): (&Vertices, &Triangles),
) -> bool {
    let mut is_any = false;
    for (_, moved) in obstacles {
        let bearable = bearable(moved, contact);
        faces::for_held(moved, start, (&vertices.position[..], triangles), |_, face| {
            is_any |= face.is_deep() && face.held.depth > bearable;
        });
    }
    is_any
}

/// Depenetrates vertices and faces that are still deep in an obstacle, or through it, onto the plane that should have held
/// them. Where a large step stretches a body far, no number of solves is sure to end on the right side. The velocity goes with
/// it.
pub fn depenetrate(world: &mut World, step: &StepContext) -> usize {
    let obstacles = obstacles(world);
    let mut count = 0;
    type Query<'a> = (
        (&'a mut Vertices, &'a mut Increment),
        (&'a Triangles, &'a Topology, &'a mut SolverScratch),
        (&'a SolveResult, &'a Contact),
    );
    for ((vertices, increment), (triangles, topology, scratch), (result, contact)) in world.query_mut::<Query>() {
        if !result.is_in_step {
            continue;
        }
        let obstacles = looked_at(&obstacles, increment, contact);
        for v in 0..vertices.len() {
            for (entity, moved) in &obstacles {
                let Some(held) = held(moved, increment.start[v], vertices.position[v]) else { continue };
                if held.depth > (DEEP * topology.vertex_area(triangles, v as u32).sqrt()).max(bearable(moved, contact))
                {
                    let way = held.normal * held.depth * scratch.free[v];
                    *scratch.contact.of(*entity) += shift(vertices, increment, v, way, step);
                }
            }
        }
        for (entity, moved) in &obstacles {
            let force = faces::depenetrate(moved, (vertices, increment), (triangles, scratch), step);
            *scratch.contact.of(*entity) += force;
        }
        count += 1;
    }
    count
}

/// Prevents tunnelling: holds back triangles that would pass through an obstacle in the step.
pub fn prevent_tunnelling(world: &mut World, step: &StepContext) -> usize {
    let obstacles = obstacles(world);
    if obstacles.is_empty() {
        return 0;
    }
    let mut count = 0;
    type Query<'a> =
        ((&'a mut Vertices, &'a mut Increment), (&'a Triangles, &'a mut SolverScratch), (&'a SolveResult, &'a Contact));
    for ((vertices, increment), (triangles, scratch), (result, contact)) in world.query_mut::<Query>() {
        if !result.is_in_step {
            continue;
        }
        count += 1;
        for (entity, moved) in &looked_at(&obstacles, increment, contact) {
            let force = side::keep(moved, (&mut *vertices, &mut *increment), (triangles, &mut *scratch), step);
            *scratch.contact.of(*entity) += force;
        }
    }
    count
}

/// Shifts a vertex within the step. Returns the force \[N\] that has as much impulse, M·Δv/s.
fn shift(vertices: &mut Vertices, increment: &mut Increment, v: usize, way: DVec3, step: &StepContext) -> DVec3 {
    vertices.position[v] += way;
    increment.displacement[v] += way;
    increment.has_projected_vertices = true;
    increment.any_vertex_projected = true;
    let before = vertices.velocity[v];
    vertices.velocity[v] = step.velocity_displacement(increment, v) * step.inv_effective_dt();
    (vertices.velocity[v] - before) * (vertices.mass[v] * step.inv_effective_dt())
}

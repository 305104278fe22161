//! Rigid obstacles as unknowns of the solves of the bodies in touch.

use super::{deviation, settle_place};
use crate::components::{
    Body, ContactScratch, ExternalStiffness, Forces, Increment, Obstacle, ObstacleMotion, Rigid, RigidCoupling, Six,
    SolveResult, SolverScratch, cholesky, solve_lower, solve_upper,
};
use crate::math::Sym3;
use crate::systems::StepContext;
use crate::systems::context::Formula;
use glam::DVec3;
use hecs::{Entity, World};
use smallvec::SmallVec;

/// The bodies in order of spawning.
pub(super) fn bodies(world: &mut World) -> SmallVec<[Entity; 8]> {
    let found = world.query_mut::<(Entity, &Body)>().with::<&SolveResult>();
    let mut bodies: SmallVec<[(u32, Entity); 8]> =
        found.into_iter().map(|(entity, body)| (body.order, entity)).collect();
    bodies.sort_unstable_by_key(|(order, _)| *order);
    bodies.into_iter().map(|(_, entity)| entity).collect()
}

/// The rigid obstacles of a step that is under way: place among all obstacles, entity, motion, and deviation from free motion.
pub(super) fn rigid_ones(world: &mut World) -> SmallVec<[(u32, Entity, Rigid, Six); 4]> {
    if !world.query_mut::<&ObstacleMotion>().into_iter().any(|motion| motion.under_way.is_some()) {
        return SmallVec::new();
    }
    let found = world.query_mut::<Entity>().with::<&Obstacle>();
    let mut obstacles: SmallVec<[Entity; 8]> = found.into_iter().collect();
    obstacles.sort_unstable();
    let is_sound = |body: Entity| world.satisfies::<&SolveResult>(body);
    let rigid = (0..).zip(obstacles).filter_map(|(at, entity)| {
        let motion = world.get::<&ObstacleMotion>(entity).ok()?;
        Some((at, entity, motion.rigid?, six(deviation(motion.under_way.as_ref()?, is_sound))))
    });
    rigid.collect()
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
pub(super) fn wrench_of(coupling: &RigidCoupling, contact: &ContactScratch) -> [DVec3; 2] {
    let touches = &contact.touched[coupling.first..][..coupling.rows.len()];
    touches.iter().fold([DVec3::ZERO; 2], |[force, moment], touch| {
        [force - touch.force, moment - (touch.point - coupling.centre).cross(touch.force)]
    })
}

fn add(sum: &mut Six, other: &Six, factor: f64) {
    sum.iter_mut().zip(other).for_each(|(sum, other)| *sum += other * factor);
}

/// Takes the rigid obstacles in touch into the solves of the bodies.
pub(in crate::systems::contact) fn couple(world: &mut World, step: &StepContext) {
    if step.is_static || step.formula == Formula::Start {
        return;
    }
    let rigid = rigid_ones(world);
    if rigid.is_empty() {
        return;
    }
    let bodies = bodies(world);
    let inertia = 1.0 / (step.stage_dt() * step.stage_dt());
    type Query<'a> = (&'a mut SolveResult, &'a mut SolverScratch, &'a mut Forces, Option<&'a mut ExternalStiffness>);
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
            if let Some(coupling) = external.and_then(|external| external.coupled.of_obstacle(at)) {
                add(&mut standing, &six(wrench_of(coupling, &scratch.contact)), 1.0);
            }
        }
        let share = 1.0 / f64::from(sharing.max(1));
        for &body in &bodies {
            let Ok((result, scratch, forces, Some(external))) = world.query_one_mut::<Query>(body) else { continue };
            if result.is_active() {
                let known = (at, rigid, deviation, standing);
                let coupled = coupling(known, (share, inertia), &mut scratch.contact, forces);
                // Numbers beyond all measure leave the obstacle free in this solve.
                let is_free = coupled.is_none() && scratch.contact.touched.iter().any(|touch| touch.place == at);
                result.is_traction_unsettled |= is_free;
                external.coupled.rigid.extend(coupled);
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
pub fn follow(world: &mut World, step: &StepContext) -> usize {
    if step.is_static {
        return 0;
    }
    let rigid = rigid_ones(world);
    if rigid.is_empty() {
        return 0;
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
            // An answer that is not finite belongs to a step that will be undone.
            let ways = external.coupled.of_obstacle(at).map(|coupling| coupling.motion(&increment.delta));
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
    bodies.len()
}

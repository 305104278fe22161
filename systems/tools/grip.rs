//! Forceps: take hold, pull, let go. Jaws that draw by springs act here; those that prescribe act where the step marks its axes.

use super::PinchSelection;
use crate::components::{
    ExternalStiffness, Forceps, Forces, Grip, Grips, Increment, Motion, NearTip, Pinch, Pose, Slip, SolveResult,
    TearLog,
};
use crate::event::EventKind;
use crate::math::{Sym3, elementary};
use crate::storage::{Tips, Topology, Triangles, Vertices};
use crate::systems::StepContext;
use glam::{DQuat, DVec3};
use hecs::Entity;
use smallvec::SmallVec;

/// A sum of steps may miss a time by so much of a step.
const TIME_ROUNDING: f64 = 1e-6;

/// Smallest part of its way that a target may go beyond the place of the least pull before tissue slips.
const LEAST_PART: f64 = 1e-3;

/// Closes, moves and opens the jaws of scripts, and opens those of forceps that are no more.
pub fn take(world: &mut hecs::World, step: &StepContext) -> usize {
    let mut count = 0;
    let forceps: SmallVec<[Entity; 8]> =
        world.query_mut::<(Entity, &Forceps)>().into_iter().map(|(forceps, _)| forceps).collect();
    type Query<'a> = ((&'a Vertices, &'a Triangles, &'a Topology, Option<&'a Tips>), (&'a mut Grips, &'a SolveResult));
    let (start, end) = (step.end() - step.dt, step.end());
    for ((vertices, triangles, topology, tips), (grips, result)) in world.query_mut::<Query>() {
        let Grips { list, pinches, grasp_count } = grips;
        pinches.iter_mut().for_each(|pinch| pinch.begin(start, step.is_static));
        if !result.is_active() {
            continue;
        }
        pinches.retain(|pinch| pinch.forceps.is_none_or(|entity| forceps.contains(&entity.entity())));
        for (grip, pinch) in list.iter().zip(pinches.iter_mut()) {
            // Judged where the step begins, which is one time for a step and for the first half in which it is retried.
            let now = if step.is_static { end } else { start + TIME_ROUNDING * step.dt };
            if !(grip.from..grip.until).contains(&now) {
                pinch.release();
                pinch.has_slipped = false;
                continue;
            }
            if !pinch.is_closed() && !pinch.has_slipped {
                let found = grip
                    .near_tip
                    .zip(tips)
                    .and_then(|(near, tips)| beside_tip(&near, vertices, triangles, topology, tips));
                let (place, turn) = found.unwrap_or((grip.material_point, DQuat::IDENTITY));
                close(pinch, grip, turn, (vertices, triangles, topology), place);
                *grasp_count += 1;
            }
            let pose = |time: f64| grip.pose(&pinch.origin, time);
            pinch.motion = Motion { from: pose(start), to: pose(end), start, end };
        }
        count += usize::from(pinches.iter().any(Pinch::is_closed));
    }
    count
}

/// Adds the pull of closed jaws that draw by springs.
pub fn grip(world: &mut hecs::World, step: &StepContext) -> usize {
    let mut count = 0;
    type Query<'a> = (
        (&'a Vertices, &'a Triangles, &'a Topology, &'a SolveResult),
        (&'a Grips, &'a mut Forces, &'a mut ExternalStiffness),
    );
    for ((vertices, triangles, topology, result), (grips, forces, external)) in world.query_mut::<Query>() {
        if !result.is_active() {
            continue;
        }
        for pinch in &grips.pinches {
            let stiffness = shared_stiffness(pinch, triangles, topology);
            for (row, target) in pinch.targets(pinch.aim(step.time)) {
                let (v, stiffness) = (row as usize, stiffness(row));
                forces.nodal[v] += (target - vertices.position[v]) * stiffness;
                external.block[v] += Sym3::isotropic(stiffness);
            }
        }
        count += usize::from(grips.pinches.iter().any(Pinch::is_closed));
    }
    count
}

/// Moves the jaws' targets to where the step has ended, records the spring forces there, lets tissue slip that is pulled too hard, and
/// reports the forces to the forceps.
pub fn feel(world: &mut hecs::World, step: &StepContext) -> usize {
    let mut count = 0;
    let mut told: SmallVec<[(Entity, DVec3, DVec3, bool); 8]> = SmallVec::new();
    type Query<'a> = (
        (&'a Vertices, &'a Triangles, &'a Topology),
        (&'a Increment, &'a SolveResult),
        (&'a mut Grips, &'a mut TearLog),
    );
    for ((vertices, triangles, topology), (increment, result), (grips, log)) in world.query_mut::<Query>() {
        if !result.is_in_step {
            continue;
        }
        count += usize::from(grips.pinches.iter().any(Pinch::is_closed));
        let scripts = grips.list.len();
        for (k, pinch) in grips.pinches.iter_mut().enumerate().filter(|(_, pinch)| pinch.is_closed()) {
            let stiffness = shared_stiffness(pinch, triangles, topology);
            let pose = pinch.follow(step.time, part_of_way(pinch, vertices, &stiffness, (increment, result), step));
            if !pinch.is_constraint() {
                pinch.record(pose, |_, row, target| {
                    let point = vertices.position[row as usize];
                    (point, (target - point) * stiffness(row))
                });
            }
            let is_open = slip(pinch, vertices, &pose, log);
            if let Some(forceps) = pinch.forceps {
                told.push((forceps.entity(), pinch.force, pinch.torque, is_open));
            }
            if is_open {
                pinch.release();
                pinch.has_slipped = k < scripts;
            }
        }
        let mut k = 0;
        grips.pinches.retain(|pinch| {
            k += 1;
            k <= scripts || pinch.is_closed()
        });
    }
    for (entity, force, torque, is_open) in told {
        if let Ok(forceps) = world.query_one_mut::<&mut Forceps>(entity) {
            (forceps.force, forceps.torque) = (force, torque);
            forceps.body = forceps.body.filter(|_| !is_open);
        }
    }
    count
}

/// Part of the way of a step that the target of jaws goes: the fraction of the increment that the body has applied. Where the budget has cut
/// short the solve of a jump, its residual stretches the springs: there, and in limited steps, the way beyond the place where they pull least is
/// halved until the jaws can hold.
fn part_of_way(
    pinch: &Pinch,
    vertices: &Vertices,
    stiffness: impl Fn(u32) -> f64,
    (increment, result): (&Increment, &SolveResult),
    step: &StepContext,
) -> f64 {
    let part = 1.0 - increment.unapplied;
    let (Some(start), Some(limit), Some(whole)) = (pinch.start, pinch.jaws.force_limit, pinch.jaws.stiffness) else {
        return part;
    };
    let aim = pinch.aim(step.time);
    let is_jump = || pinch.is_paced() || whole * pinch.way(&start.pose, &aim) > limit;
    if !(part < 1.0 || result.is_cut_short && is_jump()) {
        return part;
    }
    let pull = |(row, target): (u32, DVec3)| (target - vertices.position[row as usize]) * stiffness(row);
    let force = |part: f64| pinch.targets(start.pose.towards(&aim, part)).map(pull).sum::<DVec3>();
    // Springs are linear, and so are the targets of jaws that do not turn.
    let first = force(0.0);
    let growth = force(part) - first;
    let growth_sq = growth.length_squared();
    let least = if growth_sq > 0.0 { part * (-first.dot(growth) / growth_sq).clamp(0.0, 1.0) } else { 0.0 };
    let mut beyond = part - least;
    while beyond > LEAST_PART && force(least + beyond).length() > limit {
        beyond *= 0.5;
    }
    least + beyond
}

/// Judges the force by its limit: whether the jaws let go. Tissue that slides comes to rest in the jaws where its springs pull with
/// the limit.
fn slip(pinch: &mut Pinch, vertices: &Vertices, pose: &Pose, log: &mut TearLog) -> bool {
    let force = pinch.force.length();
    let Some(limit) = pinch.jaws.force_limit.filter(|&limit| force > limit) else {
        pinch.has_slipped = false;
        return false;
    };
    let is_open = pinch.jaws.slip == Slip::LetGo;
    if !std::mem::replace(&mut pinch.has_slipped, true) {
        log.pending.push(EventKind::Slipped { jaws: pinch.name.clone(), force, is_open });
    }
    if !is_open {
        let part = limit / force;
        for (row, place) in pinch.held.entries_mut() {
            let point = vertices.position[row as usize];
            *place = pose.place(point.lerp(pose.carry(*place), part));
        }
    }
    is_open
}

/// The stiffness of a pinch \[N/mm\] at each vertex that it holds, by rest area; zero of one that prescribes.
fn shared_stiffness<'a>(
    pinch: &Pinch,
    triangles: &'a Triangles,
    topology: &'a Topology,
) -> impl Fn(u32) -> f64 + use<'a> {
    let area = |row: u32| topology.vertex_area(triangles, row);
    let total: f64 = pinch.held.rows().iter().map(|&row| area(row)).sum();
    let stiffness = pinch.jaws.stiffness.unwrap_or(0.0);
    move |row| stiffness * (area(row) / total)
}

/// Closes the jaws of a script about a place in the rest shape.
fn close(pinch: &mut Pinch, grip: &Grip, turn: DQuat, body: (&Vertices, &Triangles, &Topology), place: DVec3) {
    let Some(selection) = PinchSelection::about(body, (place, None), grip.jaws.radius) else { return };
    let position = body.0.position[selection.nearest as usize];
    pinch.origin = Pose { position, orientation: turn };
    pinch.close(body.0, selection.rows, &Pose::at(position));
}

/// The place \[mm, rest shape\] beside the tip with the largest criterion, and the turn of the path that goes with it.
fn beside_tip(
    near: &NearTip,
    vertices: &Vertices,
    triangles: &Triangles,
    topology: &Topology,
    tips: &Tips,
) -> Option<(DVec3, DQuat)> {
    let tip = (0..tips.len()).max_by(|&a, &b| tips.criterion[a].total_cmp(&tips.criterion[b]))?;
    let (vertex, ahead) = (tips.vertex[tip], tips.previous[tip]);
    let at = |v: u32| vertices.rest_position[v as usize];
    let crosses = topology.incident[vertex as usize].iter().map(|&entry| {
        let [a, b, c] = triangles.corners[entry as usize / 3].map(at);
        (b - a).cross(c - a)
    });
    let left = crosses.sum::<DVec3>().cross(ahead).normalize_or_zero();
    let place = at(vertex) - ahead * near.behind + left * near.left;
    let axis = near.axis.normalize_or(DVec3::Z);
    let (from, to) = (near.heading.reject_from_normalized(axis), ahead.reject_from_normalized(axis));
    let angle = elementary::atan2(from.cross(to).dot(axis), from.dot(to));
    Some((place, elementary::rotation(axis, angle)))
}

//! Forceps: takes hold, pulls by springs, lets go.

use super::StepContext;
use crate::components::{ExternalStiffness, Forces, Grip, Grips, NearTip, SolverScratch};
use crate::storage::{Attached, Tips, Topology, Triangles, Vertices};
use glam::{DMat3, DQuat, DVec3};

/// Adds the pull of every grasp that is closed at the end of the step.
pub fn grip(world: &mut hecs::World, step: &StepContext) -> usize {
    let mut count = 0;
    type Query<'a> = (
        (&'a Vertices, &'a Triangles, &'a Topology, Option<&'a Tips>, &'a SolverScratch),
        (&'a mut Grips, &'a mut Forces, &'a mut ExternalStiffness),
    );
    for ((vertices, triangles, topology, tips, scratch), (grips, forces, external)) in world.query_mut::<Query>() {
        if scratch.is_converged {
            continue;
        }
        let mut is_any_closed = false;
        for (k, grip) in grips.list.iter().enumerate() {
            grips.force[k] = DVec3::ZERO;
            if !(grip.from..grip.until).contains(&step.time) {
                grips.held[k] = Attached::default();
                continue;
            }
            is_any_closed = true;
            if grips.held[k].rows().is_empty() {
                let found = grip
                    .near_tip
                    .zip(tips)
                    .and_then(|(near, tips)| beside_tip(&near, vertices, triangles, topology, tips));
                let (place, turn) = found.unwrap_or((grip.material_point, DQuat::IDENTITY));
                grips.held[k] = take(grip, vertices, place);
                grips.turn[k] = turn;
            }
            let area = |row: u32| topology.vertex_area(triangles, row);
            let total: f64 = grips.held[k].rows().iter().map(|&row| area(row)).sum();
            let carried = grips.turn[k] * (grip.path.at(step.time) - grip.path.at(grip.from));
            for (&row, &taken_at) in grips.held[k].rows().iter().zip(grips.held[k].values()) {
                let v = row as usize;
                let stiffness = grip.stiffness * (area(row) / total);
                let pull = (taken_at + carried - vertices.position[v]) * stiffness;
                forces.nodal[v] += pull;
                grips.force[k] += pull;
                external.block[v] += DMat3::from_diagonal(DVec3::splat(stiffness));
            }
        }
        count += usize::from(is_any_closed);
    }
    count
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
    let angle = from.cross(to).dot(axis).atan2(from.dot(to));
    Some((place, DQuat::from_axis_angle(axis, angle)))
}

/// The vertices within the pinch radius of a place in the rest shape, and the nearest one in any case.
fn take(grip: &Grip, vertices: &Vertices, place: DVec3) -> Attached<DVec3> {
    let distance = |v: usize| vertices.rest_position[v].distance_squared(place);
    let nearest = (0..vertices.len()).min_by(|&a, &b| distance(a).total_cmp(&distance(b)));
    let within = (0..vertices.len()).filter(|&v| Some(v) == nearest || distance(v) <= grip.radius * grip.radius);
    Attached::new(within.map(|v| (v as u32, vertices.position[v])))
}

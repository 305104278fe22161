//! Forceps: takes hold, pulls by springs, lets go.

use super::StepContext;
use crate::components::{ExternalStiffness, Forces, Grip, Grips, SolverScratch};
use crate::storage::{Attached, Vertices};
use glam::{DMat3, DVec3};

/// Adds the pull of every grasp that is closed at the end of the step.
pub fn grip(world: &mut hecs::World, step: &StepContext) -> usize {
    let mut count = 0;
    type Query<'a> = (&'a Vertices, &'a SolverScratch, &'a mut Grips, &'a mut Forces, &'a mut ExternalStiffness);
    for (vertices, scratch, grips, forces, external) in world.query_mut::<Query>() {
        if scratch.is_converged {
            continue;
        }
        let Grips { list, held, force } = grips;
        let mut is_any_closed = false;
        for ((grip, held), total) in list.iter().zip(held).zip(force) {
            *total = DVec3::ZERO;
            if !(grip.from..grip.until).contains(&step.time) {
                *held = Attached::default();
                continue;
            }
            is_any_closed = true;
            let hand = grip.path.at(step.time);
            if held.rows().is_empty() {
                *held = take(grip, vertices, grip.path.at(grip.from));
            }
            for (&row, &offset) in held.rows().iter().zip(held.values()) {
                let v = row as usize;
                let pull = (hand + offset - vertices.position[v]) * grip.stiffness;
                forces.nodal[v] += pull;
                *total += pull;
                external.block[v] += DMat3::from_diagonal(DVec3::splat(grip.stiffness));
            }
        }
        count += usize::from(is_any_closed);
    }
    count
}

/// The vertices within the pinch radius of the material point in the rest shape, and the nearest one in any case.
fn take(grip: &Grip, vertices: &Vertices, hand: DVec3) -> Attached<DVec3> {
    let distance = |v: usize| vertices.rest_position[v].distance_squared(grip.material_point);
    let nearest = (0..vertices.len()).min_by(|&a, &b| distance(a).total_cmp(&distance(b)));
    let within = (0..vertices.len()).filter(|&v| Some(v) == nearest || distance(v) <= grip.radius * grip.radius);
    Attached::new(within.map(|v| (v as u32, vertices.position[v] - hand)))
}

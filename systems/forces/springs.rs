//! Springs to ground, and bonds to a bed.
//!
//! In a step a bond is a linear spring: its secant at the opening that its velocity leads to. The damage that the step has done is settled at its end.

use crate::components::{ExternalStiffness, Forces, Increment, SolveResult, Springs};
use crate::math::Sym3;
use crate::storage::{Topology, Triangles, Vertices};
use crate::systems::kernels::separation::Separation;
use crate::systems::{StepContext, parallel};
use glam::DVec3;

/// Error of the tractions of bonds in a solve's answer that asks for a further solve, over the strength of those that are coming off.
const TOLERANCE: f64 = 0.05;

/// Adds the springs' forces and stiffness.
pub fn springs(world: &mut hecs::World, step: &StepContext) -> usize {
    type Query<'a> = (
        (&'a Vertices, &'a Triangles, &'a Topology, &'a Increment, &'a SolveResult),
        &'a mut Springs,
        &'a mut Forces,
        &'a mut ExternalStiffness,
    );
    parallel::for_bodies::<Query>(
        world,
        |((.., result), springs, ..)| result.rows_to_solve(springs.anchors.rows().len()),
        |((vertices, triangles, topology, increment, _), springs, forces, external)| {
            for (row, anchor) in springs.anchors.entries_mut() {
                let (v, (area, triangle)) = (row as usize, topology.areas_at(triangles, row));
                let opening = vertices.position[v] - anchor.point;
                if let Some(bond) = anchor.bond {
                    let has_moved = step.is_static || increment.displacement[v] != DVec3::ZERO;
                    let ahead = if has_moved { DVec3::ZERO } else { vertices.velocity[v] * step.dt };
                    let law = Separation::new(anchor.stiffness, bond.strength, bond.energy, triangle);
                    let solved = law.damage((opening + ahead).length()).max(bond.damage);
                    anchor.bond.iter_mut().for_each(|bond| bond.solved = solved);
                }
                let stiffness = anchor.solved_stiffness() * area;
                forces.nodal[v] -= opening * stiffness;
                external.block[v] += Sym3::isotropic(stiffness);
            }
        },
    )
}

/// Whether bonds are far from their law in the answer.
fn is_far((vertices, triangles, topology): (&Vertices, &Triangles, &Topology), springs: &Springs) -> bool {
    let (mut error, mut limit) = (0.0, 0.0);
    for (&row, anchor) in springs.anchors.rows().iter().zip(springs.anchors.values()) {
        let Some(bond) = anchor.bond.filter(|bond| bond.damage < 1.0) else { continue };
        let (v, (area, triangle)) = (row as usize, topology.areas_at(triangles, row));
        let opening = vertices.position[v].distance(anchor.point);
        let law = Separation::new(anchor.stiffness, bond.strength, bond.energy, triangle);
        let damage = law.damage(opening).max(bond.damage);
        if damage > 0.0 || bond.solved > 0.0 {
            error += area * anchor.stiffness * opening * (damage - bond.solved).abs();
            limit += area * law.strength();
        }
    }
    error > TOLERANCE * limit
}

/// Marks for another solve the bodies whose bonds are far from their law in the answer: tissue that snaps off would be drawn back by springs as stiff as
/// before. Returns their number.
pub fn far_from_law(world: &mut hecs::World, step: &StepContext) -> usize {
    let mut count = 0;
    type Query<'a> = (&'a Vertices, &'a Triangles, &'a Topology, &'a mut SolveResult, &'a Springs);
    for (vertices, triangles, topology, result, springs) in world.query_mut::<Query>() {
        if !(result.is_in_step && result.newton_iterations > 0 && step.affords(result, 1)) {
            continue;
        }
        let asks = is_far((vertices, triangles, topology), springs);
        result.select(asks || result.is_active());
        count += usize::from(asks);
    }
    count
}

/// Notes the bodies whose bonds are still far from their law after the rounds. Returns their number.
pub fn unsettled(world: &mut hecs::World, step: &StepContext) -> usize {
    let mut count = 0;
    type Query<'a> = (&'a Vertices, &'a Triangles, &'a Topology, &'a mut SolveResult, &'a Springs);
    for (vertices, triangles, topology, result, springs) in world.query_mut::<Query>() {
        let is_solved = result.is_in_step && result.newton_iterations > 0 && !step.is_resumed;
        let is_far = is_solved && is_far((vertices, triangles, topology), springs);
        result.is_traction_unsettled |= is_far;
        count += usize::from(is_far);
    }
    count
}

/// Settles the damage of bonds at the end of the step.
pub fn come_off(world: &mut hecs::World, _: &StepContext) -> usize {
    let mut count = 0;
    type Query<'a> = (&'a Vertices, &'a Triangles, &'a Topology, &'a SolveResult, &'a mut Springs);
    for (vertices, triangles, topology, result, springs) in world.query_mut::<Query>() {
        let has_bonds = springs.anchors.values().iter().any(|anchor| anchor.bond.is_some());
        if !(result.is_in_step && has_bonds) {
            continue;
        }
        count += 1;
        for (row, anchor) in springs.anchors.entries_mut() {
            let Some(bond) = anchor.bond else { continue };
            let (v, (_, triangle)) = (row as usize, topology.areas_at(triangles, row));
            let law = Separation::new(anchor.stiffness, bond.strength, bond.energy, triangle);
            let damage = law.damage(vertices.position[v].distance(anchor.point)).max(bond.damage);
            anchor.bond.iter_mut().for_each(|bond| bond.damage = damage);
        }
    }
    count
}

//! Reaction forces of a solve: of position constraints, which are holds and jaws, and of obstacles.

use super::Operator;
use crate::components::{
    CompartmentState, Contact, ContactScratch, Damping, ExternalStiffness, Forces, Frames, Grips, Holds, Increment,
    Reactions, RigidCoupling, SolveResult, SolverScratch,
};
use crate::math::Sym3;
use crate::storage::{Topology, Triangles, Vertices};
use crate::systems::bending::DihedralAngles;
use crate::systems::{StepContext, parallel};
use glam::{DMat3, DVec3};

/// Components that prescribe positions of vertices: holds, with their reactions, and grips.
pub type Prescribers<'a> = (Option<&'a Holds>, Option<&'a mut Reactions>, Option<&'a mut Grips>);

/// Takes down the reactions where `force` \[N\] keeps a vertex on its way.
pub fn record((holds, reactions, grips): Prescribers<'_>, time: f64, force: impl Fn(usize) -> DVec3) {
    if let Some(grips) = grips {
        grips.record_constraints(time, &force);
    }
    let (Some(holds), Some(reactions)) = (holds, reactions) else { return };
    reactions.groups.resize_with(holds.groups.len(), Vec::new);
    for (hold, group) in holds.groups.iter().zip(&mut reactions.groups) {
        let held = DVec3::from_array(hold.axes.map(|a| f64::from(u8::from(a))));
        group.clear();
        group.extend(hold.members.rows().iter().map(|&row| force(row as usize) * held));
    }
}

/// Constraint forces of a linearly implicit step: A·δ − b on the prescribed axes.
pub fn of_linear_step(
    operator: &Operator,
    forces: &Forces,
    increment: &Increment,
    step: &StepContext,
    prescribers: Prescribers<'_>,
) {
    let vertices = operator.vertices;
    let pressure = operator.volume_pressure(&increment.delta);
    record(prescribers, step.time, |v| {
        operator.apply_at(v, &increment.delta) + operator.volume_force(v, pressure)
            - forces.nodal[v]
            - step.momentum(increment, v) * vertices.mass[v]
    });
}

/// Takes the reactions down anew of bodies that go only a part of the answer: those of all of it belong to no state.
pub fn of_part(world: &mut hecs::World, step: &StepContext) {
    type Query<'a> = (
        (&'a Vertices, &'a Triangles, &'a Topology, &'a Frames),
        (&'a Forces, &'a Increment, &'a SolveResult),
        (Option<&'a ExternalStiffness>, Option<&'a DihedralAngles>, Option<&'a Damping>, Option<&'a CompartmentState>),
        Prescribers<'a>,
    );
    for ((vertices, triangles, topology, frames), (forces, increment, result), about, prescribers) in
        world.query_mut::<Query>()
    {
        if !result.is_active() || !increment.is_fraction {
            continue;
        }
        let (external, folds, damping, compartment) = about;
        let viscosity = damping.map_or(0.0, |d| d.time) * step.inv_effective_dt();
        let (inertia, tangent) = (step.inertia(), result.tangent);
        let operator = Operator {
            external,
            volume: compartment.map(CompartmentState::stiffness),
            folds,
            inertia,
            viscosity,
            ..Operator::membrane((vertices, triangles, topology, frames), tangent)
        };
        of_linear_step(&operator, forces, increment, step, prescribers);
    }
}

/// Forces of obstacles at the answer of a linearly implicit solve: f − K·δ, and the part of the vertex' residual A·δ − b that their stiffness
/// has in the vertex block. Contacts are so stiff that a small residual is a large force. A shortened or corrected answer has another residual
/// than the solve's, formed vertex by vertex.
pub fn of_contacts(world: &mut hecs::World, step: &StepContext) -> usize {
    if step.newton_iterations > 1 {
        return 0;
    }
    type Query<'a> = (
        (&'a Vertices, &'a Triangles, &'a Topology, &'a Frames),
        (&'a Forces, &'a Increment, &'a SolveResult, &'a mut SolverScratch),
        (&'a ExternalStiffness, Option<&'a DihedralAngles>, Option<&'a Damping>, Option<&'a CompartmentState>),
    );
    parallel::for_bodies::<hecs::With<Query, &Contact>>(
        world,
        |(_, (_, _, result, scratch), _)| result.rows_to_solve(scratch.contact.touched.len()),
        |(
            (vertices, triangles, topology, frames),
            (forces, increment, result, scratch),
            (external, folds, damping, compartment),
        )| {
            let operator = Operator {
                external: Some(external),
                volume: compartment.map(CompartmentState::stiffness),
                folds,
                inertia: step.inertia(),
                viscosity: damping.map_or(0.0, |d| d.time) * step.inv_effective_dt(),
                ..Operator::membrane((vertices, triangles, topology, frames), result.tangent)
            };
            let is_whole = scratch.has_whole_answer(increment);
            let pressure = operator.volume_pressure(&increment.delta);
            let SolverScratch { contact, free, residual, .. } = scratch;
            let ContactScratch { forces: sums, touched, .. } = &mut **contact;
            for coupling in &external.coupled.rigid {
                // The obstacle gives way.
                let seen = coupling.seen(&increment.delta);
                for (touch, (_, columns)) in touched[coupling.first..].iter_mut().zip(&coupling.rows) {
                    touch.force += RigidCoupling::back(columns, &seen);
                }
            }
            parallel::for_rows(touched, |_, touch| {
                let v = touch.row as usize;
                touch.force -= touch.block * increment.delta[v];
                if !step.is_static {
                    let missed = if is_whole {
                        -residual[v]
                    } else {
                        let known = forces.nodal[v] + step.momentum(increment, v) * vertices.mass[v];
                        operator.apply_at(v, &increment.delta) + operator.volume_force(v, pressure) - known
                    };
                    touch.force += share(&touch.block, operator.vertex_block(v), missed * free[v]);
                }
            });
            sums.iter_mut().for_each(|(_, force)| *force = DVec3::ZERO);
            touched.iter().for_each(|touch| sums[touch.place as usize].1 += touch.force);
        },
    )
}

/// Part of a vertex' residual \[N\] that belongs to one of the stiffnesses in its block; by traces where the block is singular to rounding.
fn share(stiffness: &Sym3, block: DMat3, residual: DVec3) -> DVec3 {
    let share = *stiffness * (block.inverse() * residual);
    if share.is_finite() {
        return share;
    }
    residual * (stiffness.diagonal.element_sum() / (block.x_axis.x + block.y_axis.y + block.z_axis.z))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A contact so stiff that the inertia beside it is lost to rounding (`rhexis stress --seed 10002 --case 344`) takes the residual whole.
    #[test]
    fn a_singular_block_shares_its_residual_by_traces() {
        let stiffness = Sym3 {
            diagonal: DVec3::new(7.30469066002578e23, 8.967850298572853e24, 1.8352920224252852e26),
            beside: DVec3::new(4.056922985622844e25, -1.1578532072171241e25, -2.559440804482388e24),
        };
        let residual = DVec3::new(5.7e46, -2.0e47, -9.1e47);
        let share = share(&stiffness, stiffness.to_mat() + DMat3::from_diagonal(DVec3::splat(1e-4)), residual);
        // The inertia's share is 1e-28 of the whole; the sums of three numbers round by 1e-16.
        assert!((share - residual).length() < 1e-15 * residual.length(), "{share}");
    }
}

//! Reaction forces of a solve: of position constraints, which are holds and jaws, and of obstacles.

use super::{Operator, ProductMemory};
use crate::components::{
    Contact, ContactScratch, Damping, ExternalStiffness, Forces, Frames, Grips, Holds, Increment, Reactions,
    SolveResult, SolverScratch,
};
use crate::storage::{Topology, Triangles, Vertices};
use crate::systems::bending::{BendingPasses, DihedralAngles};
use crate::systems::{StepContext, parallel};
use glam::DVec3;

/// Vertices per touched one up to which one product of the whole body is cheaper than products vertex by vertex: 1.0 s instead of 5.0 in 300
/// steps of `capsulorhexis` (`rhexis run capsulorhexis --steps 300 --threads 1 --timings`).
const TOUCHED: usize = 8;

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
    record(prescribers, step.time, |v| {
        operator.apply_at(v, &increment.delta) - forces.nodal[v] - step.momentum(increment, v) * vertices.mass[v]
    });
}

/// Takes the reactions down anew of bodies that go only a part of the answer: those of all of it belong to no state.
pub fn of_part(world: &mut hecs::World, step: &StepContext) {
    type Query<'a> = (
        (&'a Vertices, &'a Triangles, &'a Topology, &'a Frames),
        (&'a Forces, &'a Increment, &'a SolveResult),
        (Option<&'a ExternalStiffness>, Option<&'a DihedralAngles>, Option<&'a Damping>),
        Prescribers<'a>,
    );
    for ((vertices, triangles, topology, frames), (forces, increment, result), about, prescribers) in
        world.query_mut::<Query>()
    {
        if !result.is_active() || !increment.is_fraction {
            continue;
        }
        let (external, folds, damping) = about;
        let viscosity = damping.map_or(0.0, |d| d.time) * step.inv_effective_dt();
        let (inertia, tangent) = (step.inertia(), result.tangent);
        let operator = Operator {
            external,
            folds,
            inertia,
            viscosity,
            ..Operator::membrane((vertices, triangles, topology, frames), tangent)
        };
        of_linear_step(&operator, forces, increment, step, prescribers);
    }
}

/// Forces of obstacles at the answer of a linearly implicit solve: f − K·δ, and the part of the vertex' residual A·δ − b that their stiffness
/// has in the vertex block. Contacts are so stiff that a small residual is a large force.
pub fn of_contacts(world: &mut hecs::World, step: &StepContext) -> usize {
    if step.newton_iterations > 1 {
        return 0;
    }
    type Query<'a> = (
        (&'a Vertices, &'a Triangles, &'a Topology, &'a Frames),
        (&'a mut Forces, &'a Increment, &'a SolveResult, &'a mut SolverScratch),
        (&'a ExternalStiffness, Option<&'a DihedralAngles>, Option<&'a mut BendingPasses>, Option<&'a Damping>),
    );
    parallel::for_bodies::<hecs::With<Query, &Contact>>(
        world,
        |(_, (_, _, result, scratch), _)| result.rows_to_solve(scratch.contact.touched.len()),
        |(
            (vertices, triangles, topology, frames),
            (Forces { nodal, corner, .. }, increment, result, scratch),
            (external, folds, passes, damping),
        )| {
            let operator = Operator {
                external: Some(external),
                folds,
                inertia: step.inertia(),
                viscosity: damping.map_or(0.0, |d| d.time) * step.inv_effective_dt(),
                ..Operator::membrane((vertices, triangles, topology, frames), result.tangent)
            };
            let SolverScratch { contact, free, product, partials, .. } = scratch;
            let ContactScratch { forces, touched, .. } = &mut **contact;
            let is_whole = !step.is_static && TOUCHED * touched.len() >= vertices.len();
            if is_whole {
                let mut spare = BendingPasses::default();
                let mut memory = ProductMemory { corner, passes: passes.unwrap_or(&mut spare) };
                product.resize(vertices.len(), DVec3::ZERO);
                operator.apply(&increment.delta, free, &mut memory, product, partials);
            }
            parallel::for_rows(touched, |_, touch| {
                let v = touch.row as usize;
                touch.force -= touch.block * increment.delta[v];
                if !step.is_static {
                    let known = nodal[v] + step.momentum(increment, v) * vertices.mass[v];
                    let taken = if is_whole { product[v] } else { operator.apply_at(v, &increment.delta) };
                    let missed = (taken - known) * free[v];
                    touch.force += touch.block * (operator.vertex_block(v).inverse() * missed);
                }
            });
            forces.iter_mut().for_each(|(_, force)| *force = DVec3::ZERO);
            touched.iter().for_each(|touch| forces[touch.place as usize].1 += touch.force);
        },
    )
}

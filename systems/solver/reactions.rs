//! Reaction forces of position constraints: holds, and jaws that are a constraint.

use super::Operator;
use crate::components::{Damping, ExternalStiffness, Forces, Frames, Grips, Holds, Increment, Reactions, SolveResult};
use crate::storage::{Topology, Triangles, Vertices};
use crate::systems::StepContext;
use crate::systems::bending::DihedralAngles;
use glam::DVec3;

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

//! Balance of momentum: loads and reported forces, of holds, jaws and obstacles, against the rate of momentum.
//!
//! Internal forces cancel in the sum over all vertices. So the sum of the nodal forces before jaws and obstacles push is that of
//! gravity, pressure, loads and springs. Drag is added here, and both are linearised to the solve's answer. The rate of momentum follows
//! the formula of time integration; in backward Euler it is M·(v₁ − v₀)/Δt. The difference is the residual of the solve at vertices
//! out of touch, unless the energy guard shortens the increment: no reported force does that. Bodies with [`Contact`] have it.

use crate::components::{
    Contact, Drag, Forces, Increment, MomentumBalance, Planar, SolveResult, SolverScratch, Springs,
};
use crate::storage::{Topology, Triangles, Vertices};
use crate::systems::StepContext;
use glam::DVec3;

/// Mesh of a body, with the loads that have a stiffness.
type Loaded<'a> = (&'a Triangles, &'a Topology, Option<&'a Springs>, Option<&'a Drag>);

/// Coefficient of drag over the step's span \[N/mm per mm²\].
fn drag_factor(drag: Option<&Drag>, step: &StepContext) -> f64 {
    drag.map_or(0.0, |drag| drag.coefficient * step.inv_effective_dt())
}

/// Drag force \[N\] by the displacement of each vertex in the effective step.
fn drag_along((triangles, topology): (&Triangles, &Topology), factor: f64, way: impl Fn(usize) -> DVec3) -> DVec3 {
    if factor == 0.0 {
        return DVec3::ZERO;
    }
    let rows = 0..topology.incident.len();
    rows.map(|v| way(v) * (-factor * topology.vertex_area(triangles, v as u32))).sum()
}

/// Sum of the loads at the evaluation, before jaws and obstacles push.
pub fn loads(world: &mut hecs::World, step: &StepContext) -> usize {
    let mut count = 0;
    type Query<'a> = (Loaded<'a>, &'a Forces, &'a Increment, &'a SolveResult, &'a mut SolverScratch);
    for ((triangles, topology, _, drag), forces, increment, result, scratch) in
        world.query_mut::<Query>().with::<&Contact>()
    {
        if !result.is_active() {
            continue;
        }
        count += 1;
        let way = |v: usize| step.velocity_displacement(increment, v);
        let drag = drag_along((triangles, topology), drag_factor(drag, step), way);
        scratch.momentum.balance.get_or_insert_default().loads = forces.nodal.iter().sum::<DVec3>() + drag;
    }
    count
}

/// Linearises the loads to the answer of a linearly implicit solve.
pub fn answer(world: &mut hecs::World, step: &StepContext) -> usize {
    if step.newton_iterations > 1 {
        return 0;
    }
    let mut count = 0;
    type Query<'a> = (Loaded<'a>, &'a Increment, &'a SolveResult, &'a mut SolverScratch);
    for ((triangles, topology, springs, drag), increment, result, scratch) in
        world.query_mut::<Query>().with::<&Contact>()
    {
        let Some(MomentumBalance { loads, .. }) = &mut scratch.momentum.balance else { continue };
        if !result.is_active() || springs.is_none() && drag.is_none() {
            continue;
        }
        count += 1;
        for (&row, anchor) in springs.into_iter().flat_map(|s| s.anchors.rows().iter().zip(s.anchors.values())) {
            *loads -=
                increment.delta[row as usize] * (anchor.solved_stiffness() * topology.vertex_area(triangles, row));
        }
        *loads += drag_along((triangles, topology), drag_factor(drag, step), |v| increment.delta[v]);
    }
    count
}

/// Rate of momentum of the step when its iterations have ended.
pub fn account(world: &mut hecs::World, step: &StepContext) -> usize {
    let mut count = 0;
    type Query<'a> = (&'a Vertices, &'a Increment, &'a SolveResult, &'a mut SolverScratch, Option<&'a Planar>);
    for (vertices, increment, result, scratch, planar) in world.query_mut::<Query>().with::<&Contact>() {
        let Some(balance) = scratch.momentum.balance.as_mut().filter(|_| result.is_in_step) else { continue };
        count += 1;
        let inertia = |v: usize| step.momentum(increment, v) * -vertices.mass[v];
        balance.rate = (0..vertices.len()).map(inertia).sum();
        if planar.is_some() {
            // Nothing moves out of the plane, whatever pushes.
            (balance.rate.z, balance.loads.z) = (0.0, 0.0);
        }
    }
    count
}

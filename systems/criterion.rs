//! The tear criterion at every tip and, where a body may tear by itself, at its triangles.

use super::StepContext;
use super::kernels::failure;
use super::tearing::{Surface, TipMemory, decision, disc_average, strength, tip_decision};
use crate::components::{Planar, PreStretch, TearDecision, TearDecisions, Tearing};
use crate::storage::{Tips, Topology, Triangles, Vertices};
use glam::DVec3;

/// A tear starts at least so many averaging radii from every tip. Nearer, a disc ahead of the tip shares its stress
/// concentration, and can even exceed the tip's own average by a fifth (K field: 1.2 against 1.02 K/√(2πR) at a distance
/// R, 0.75 at 2R): there the tip decides, or each tear would raise a swarm of others.
const FROM_TIPS: f64 = 2.0;

/// Evaluates the criterion at the current positions and leaves the decisions in [`TearDecisions`]. Does not run on a body that
/// has no tip and may not start a tear.
pub fn criterion(world: &mut hecs::World, step: &StepContext) -> usize {
    let mut count = 0;
    type Query<'a> = (
        (&'a Vertices, &'a Triangles, &'a Topology, &'a Tearing),
        (&'a mut Tips, &'a mut TearDecisions, &'a mut TipMemory),
        (Option<&'a Planar>, Option<&'a PreStretch>),
    );
    for ((vertices, triangles, topology, tearing), (tips, decisions, memory), (planar, pre_stretch)) in
        world.query_mut::<Query>()
    {
        decisions.tips.clear();
        decisions.start = None;
        let is_done = step.is_resumed && !decisions.may_advance_further;
        if is_done || (tips.is_empty() && !tearing.may_initiate) {
            continue;
        }
        count += 1;
        let unstretched = PreStretch::unstretched(pre_stretch);
        let surface = Surface { vertices, triangles, topology, is_planar: planar.is_some(), unstretched };
        for tip in 0..tips.len() {
            let place = (tips.vertex[tip], tips.previous[tip]);
            let decision = tip_decision(&surface, tearing, tip, place, memory);
            tips.criterion[tip] = decision.map_or(0.0, |d| d.value);
            decisions.tips.push(decision);
        }
        if tearing.may_initiate {
            decisions.start = strongest_triangle(&surface, tearing, tips, memory);
        }
    }
    count
}

/// The triangle whose disc average exceeds the criterion most. The cheap bound comes first: a triangle whose own largest
/// principal stress is under every threshold cannot be the centre of a start.
fn strongest_triangle(
    surface: &Surface,
    tearing: &Tearing,
    tips: &Tips,
    memory: &mut TipMemory,
) -> Option<TearDecision> {
    let strength = strength(tearing);
    let tip_at = |&vertex: &u32| surface.vertices.rest_position[vertex as usize];
    let is_near_tip = |p: DVec3| tips.vertex.iter().any(|v| tip_at(v).distance(p) < FROM_TIPS * tearing.radius);
    let mut best: Option<TearDecision> = None;
    for t in 0..surface.triangles.len() {
        if failure::cannot_tear(surface.stress(t), &strength) {
            continue;
        }
        let x = surface.triangles.corners[t].map(|v| surface.vertices.rest_position[v as usize]);
        let centre = (x[0] + x[1] + x[2]) / 3.0;
        if is_near_tip(centre) {
            continue;
        }
        let fibre = surface.triangles.fibre[t];
        let axes = [fibre, (x[1] - x[0]).cross(x[2] - x[0]).normalize().cross(fibre)];
        let buffers = (&mut memory.passing, &mut memory.walk);
        let average = disc_average(surface, centre, axes, tearing.radius, [t as u32], buffers);
        let found = average.and_then(|average| {
            let answer = memory.search(strength).evaluate(average.stress, average.fibre, None, None)?;
            let d = answer.best.direction;
            answer.tears().then(|| decision(t as u32, &answer, &average, axes, axes[0] * d.x + axes[1] * d.y))
        });
        if let Some(found) = found
            && best.is_none_or(|b| found.value > b.value)
        {
            best = Some(found);
        }
    }
    best
}

//! The tear criterion at every tip and, where a body may tear by itself, at its triangles.

use super::StepContext;
use super::kernels::failure;
use super::tearing::{Surface, decision, disc_average, strength, tip_decision};
use crate::components::{Planar, PreStretch, TearDecision, TearDecisions, Tearing};
use crate::storage::{Tips, Topology, Triangles, Vertices};

/// Evaluates the criterion at the current positions and leaves the decisions in [`TearDecisions`]. Does not run on a body that
/// has no tip and may not start a tear.
pub fn criterion(world: &mut hecs::World, _: &StepContext) -> usize {
    let mut count = 0;
    type Query<'a> = (
        (&'a Vertices, &'a Triangles, &'a Topology, &'a Tearing),
        (&'a mut Tips, &'a mut TearDecisions),
        (Option<&'a Planar>, Option<&'a PreStretch>),
    );
    for ((vertices, triangles, topology, tearing), (tips, scratch), (planar, pre_stretch)) in world.query_mut::<Query>()
    {
        scratch.tips.clear();
        scratch.start = None;
        if tips.is_empty() && !tearing.may_initiate {
            continue;
        }
        count += 1;
        let unstretched = PreStretch::unstretched(pre_stretch);
        let surface = Surface { vertices, triangles, topology, is_planar: planar.is_some(), unstretched };
        for tip in 0..tips.len() {
            let decision = tip_decision(&surface, tearing, tips.vertex[tip], tips.previous[tip], scratch);
            tips.criterion[tip] = decision.map_or(0.0, |d| d.value);
            scratch.tips.push(decision);
        }
        if tearing.may_initiate {
            scratch.start = strongest_triangle(&surface, tearing, scratch);
        }
    }
    count
}

/// The triangle whose disc average exceeds the criterion most. The cheap bound comes first: a triangle whose own largest
/// principal stress is under every threshold cannot be the centre of a start.
fn strongest_triangle(surface: &Surface, tearing: &Tearing, scratch: &mut TearDecisions) -> Option<TearDecision> {
    let strength = strength(tearing);
    let mut best: Option<TearDecision> = None;
    for t in 0..surface.triangles.len() {
        if failure::cannot_tear(surface.stress(t), &strength) {
            continue;
        }
        let x = surface.triangles.corners[t].map(|v| surface.vertices.rest_position[v as usize]);
        let fibre = surface.triangles.fibre[t];
        let axes = [fibre, (x[1] - x[0]).cross(x[2] - x[0]).normalize().cross(fibre)];
        let centre = (x[0] + x[1] + x[2]) / 3.0;
        let average = disc_average(surface, centre, axes, tearing.radius, [t as u32], scratch);
        let found = average.and_then(|average| {
            let answer = failure::evaluate(average.stress, average.fibre, &strength, None, None)?;
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

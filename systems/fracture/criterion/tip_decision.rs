//! The criterion at a tip, from the mean stress around it.

use crate::components::{DecidedBy, TearDecision, Tearing};
use crate::math::elementary;
use crate::systems::fracture::criterion::by_triangle::in_runs;
use crate::systems::fracture::criterion::held_shut::lay_at_tip;
use crate::systems::fracture::{DiscAverage, Surface, TipMemory};
use crate::systems::kernels::failure::{Cone, Decision, Origin, Search, Sector, Strength};
use crate::systems::kernels::fan::FanChart;
use glam::{DVec2, DVec3};

/// The strengths of a body.
pub fn strength(tearing: &Tearing) -> Strength {
    Strength {
        fibre: tearing.strength_across_fibres,
        transverse: tearing.strength_along_fibres,
        exponent: tearing.exponent,
    }
}

/// The criterion at the `tip`th tip of a body, with the last direction `previous` (zero for none), within its fan and cone.
/// `None` where no direction is admissible.
pub fn tip_decision(
    surface: &Surface,
    tearing: &Tearing,
    tip: usize,
    (vertex, previous): (u32, DVec3),
    memory: &mut TipMemory,
) -> Option<TearDecision> {
    let (chart, search, average) = memory.at_tip(surface, (tip, vertex), strength(tearing), tearing.radius)?;
    in_fan(surface, tearing, (vertex, previous), chart, search, &average)
}

/// The criterion at a vertex of the boundary without a tip, within its fan. `None` where no direction is admissible.
pub fn vertex_decision(
    surface: &Surface,
    tearing: &Tearing,
    vertex: u32,
    memory: &mut TipMemory,
) -> Option<TearDecision> {
    let chart = surface.chart(vertex)?;
    lay_at_tip(&mut memory.passing, surface, (vertex, tearing.radius), &chart, &mut memory.walk);
    let average = DiscAverage::over(&memory.passing, tearing.radius, surface)?;
    in_fan(surface, tearing, (vertex, DVec3::ZERO), &chart, memory.search(strength(tearing)), &average)
}

pub(in crate::systems::fracture) fn in_fan(
    surface: &Surface,
    tearing: &Tearing,
    (vertex, previous): (u32, DVec3),
    chart: &FanChart,
    search: &Search,
    average: &DiscAverage,
) -> Option<TearDecision> {
    let (cone, sector) = admissible(tearing, previous, chart);
    let (answer, _) = in_runs(&surface.triangles.strength, (surface, vertex, chart), sector, |sector, factor| {
        let answer = search.evaluate(average.stress, average.fibre, cone, sector)?;
        Some(answer.over(factor))
    })?;
    Some(decision_in_fan(vertex, &answer, chart, average))
}

/// The directions that a tip may take: within its cone and its fan.
pub(in crate::systems::fracture) fn admissible(
    tearing: &Tearing,
    previous: DVec3,
    chart: &FanChart,
) -> (Option<Cone>, Option<Sector>) {
    let cone = (previous != DVec3::ZERO).then(|| Cone { previous: chart.to_chart(previous), half_angle: tearing.cone });
    let (from, to) = chart.range();
    (cone, (!chart.is_closed()).then_some(Sector { from, to }))
}

/// The answer of a criterion in the chart of a vertex.
pub(in crate::systems::fracture) fn decision_in_fan(
    vertex: u32,
    answer: &Decision,
    chart: &FanChart,
    average: &DiscAverage,
) -> TearDecision {
    let turned = along_curved_fibre(answer, average);
    let direction = if chart.sector(turned).is_some() { turned } else { answer.best.direction };
    let other = answer.runner_up.map(|other| chart.to_surface(other.direction));
    TearDecision { other, ..decision(vertex, answer, average, chart.axes(), chart.to_surface(direction)) }
}

/// The answer of the criterion with the data that it was found from.
pub fn decision(
    row: u32,
    answer: &Decision,
    average: &DiscAverage,
    axes: [DVec3; 2],
    direction: DVec3,
) -> TearDecision {
    TearDecision {
        row,
        direction,
        value: answer.best.value,
        other: None,
        margin: answer.margin(),
        is_ambiguous: answer.is_ambiguous(),
        by: DecidedBy::Stress,
        release: None,
        stress: average.stress,
        fibre: axes[0] * average.fibre.x + axes[1] * average.fibre.y,
        axes,
        edges_per_radius: average.edges_per_radius,
    }
}

/// The chosen direction, turned where it follows a curved fibre by half of the fibre's turn over the edge to come: the
/// midpoint rule. Straight steps along the tangent would leave a circle of radius r by L²/2r each.
fn along_curved_fibre(answer: &Decision, average: &DiscAverage) -> DVec2 {
    let d = answer.best.direction;
    // A kink of the threshold is met exactly, so the direction is the fibre's to rounding or not at all.
    if answer.origin != Origin::Kink || d.perp_dot(average.fibre).abs() > 1e-9 {
        return d;
    }
    let edge = average.radius / average.edges_per_radius;
    elementary::unit_at(0.5 * edge * average.fibre_turn.dot(d)).rotate(d)
}

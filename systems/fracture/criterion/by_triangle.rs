//! Strengths and toughnesses that differ from triangle to triangle: a direction meets those of the triangle which it leads into.

use crate::storage::{Fan, Uniform};
use crate::systems::fracture::Surface;
use crate::systems::kernels::failure::{Candidate, Decision, Sector};
use crate::systems::kernels::fan::FanChart;

/// cos 2°: nearer than that to the best direction there is no other.
const COS_APART: f64 = 0.999_390_827_019_095_8;

/// The largest criterion at a vertex whose triangles have these `factors` of the body's strength or toughness, with the factor
/// where it is. `evaluate` answers for directions in a sector all of which have one. `None` where no direction is admissible.
pub(in crate::systems::fracture) fn in_runs(
    factors: &Uniform<f64>,
    (surface, vertex, chart): (&Surface, u32, &FanChart),
    sector: Option<Sector>,
    mut evaluate: impl FnMut(Option<Sector>, f64) -> Option<Decision>,
) -> Option<(Decision, f64)> {
    if factors.is_uniform() {
        let factor = *factors.get(0)?;
        return Some((evaluate(sector, factor)?, factor));
    }
    let fan = surface.topology.fan(vertex);
    let of = |sector: usize| fan.sectors.get(sector).map(|&(t, _)| factors[t as usize]);
    let mut answers: Vec<(Decision, f64)> = Vec::new();
    let mut from = 0;
    while let Some(factor) = of(from) {
        let to = (from..fan.sectors.len()).find(|&next| of(next) != Some(factor)).unwrap_or(fan.sectors.len());
        let run = Sector { from: chart.angle(from), to: chart.angle(to) };
        let sector = if to - from == fan.sectors.len() { sector } else { Some(run) };
        answers.extend(evaluate(sector, factor).map(|answer| (answer, factor)));
        from = to;
    }
    // The first of equal ones.
    let (mut best, factor) =
        answers.iter().copied().reduce(|a, b| if b.0.best.value > a.0.best.value { b } else { a })?;
    let direction = best.best.direction;
    let others = answers.iter().flat_map(|(answer, _)| [Some(answer.best), answer.runner_up]).flatten();
    let apart = others.filter(|other| other.direction.dot(direction) < COS_APART);
    best.runner_up = apart.reduce(|a: Candidate, b| if b.value > a.value { b } else { a });
    Some((best, factor))
}

/// The factor of the triangle of a fan into which a sector of its chart leads.
pub fn factor_of(factors: &Uniform<f64>, fan: &Fan, sector: usize) -> f64 {
    fan.sectors.get(sector).map_or(1.0, |&(t, _)| factors[t as usize])
}

/// The mean factor of the triangles around a vertex.
pub fn mean_around(factors: &Uniform<f64>, incident: &[u32]) -> f64 {
    if factors.is_uniform() {
        return factors.get(0).copied().unwrap_or(1.0);
    }
    incident.iter().map(|entry| factors[(entry / 3) as usize]).sum::<f64>() / incident.len().max(1) as f64
}

//! The advance budget of a tip in a step, and whether it suffices for the tip's next triangle.

use crate::components::{RefusedSite, SolveResult, TearDecision, TearDecisions, TearMode, Tearing};
use crate::storage::{TipKey, Tips, Topology, Triangles, Vertices};
use crate::systems::fracture::cut::tip::fan_chart;
use crate::systems::fracture::split::NEARLY;
use crate::systems::{StepContext, work};
use hecs::World;
use smallvec::SmallVec;

/// Rounding allowance of a sum of equal budgets against the length of a triangle.
const ROUNDED: f64 = 1.0 - 1e-9;

/// A criterion above this would exceed 1 after a correction of the step as well. A tip that waits saves up only the advance
/// that it may make by a corrected criterion, or by one so clear.
const CLEAR_CRITERION: f64 = 1.05;

/// A criterion from which a corrector solve is due: the first solve of a step shows two thirds of a change of the energy release, and a tip
/// just below 1 may be above it. With 1 the lead scene's tip advances 8 % above its toughness in the median, with 0.97 2.6 %.
const DUE: f64 = 0.97;

/// Change of G/G_c of a tip by a corrector solve up to which it is at rest.
const AT_REST: f64 = 0.003;

/// Speed of Rayleigh waves over that of shear waves, at least: that of a Poisson's ratio of zero (Rayleigh 1885).
const RAYLEIGH: f64 = 0.874;

/// Speed \[mm/ms\] that no tear of a body exceeds: that of Rayleigh waves where they are slowest (Freund 1990, section 4.2).
pub fn fastest(triangles: &Triangles) -> f64 {
    let Triangles { stiffness, density, .. } = triangles;
    let speed_sq = |row: usize| stiffness[row].q66 / density[row];
    let different = if stiffness.is_uniform() && density.is_uniform() { 1 } else { triangles.len() };
    RAYLEIGH * (0..triangles.len().min(different)).map(speed_sq).fold(f64::INFINITY, f64::min).sqrt()
}

/// Advance budget of tips.
#[derive(Clone, Copy, Debug)]
pub enum AdvanceBudget {
    /// No limit: tips advance until they come to rest.
    Unlimited,
    /// Advance \[mm\] that a new step adds.
    New(f64),
    /// Advance left over in a resumed step.
    Left,
}

impl AdvanceBudget {
    /// The advance budget of a step.
    pub fn new(step: &StepContext, triangles: &Triangles) -> Self {
        match *step {
            StepContext { is_static: true, .. } => Self::Unlimited,
            StepContext { is_resumed: true, .. } => Self::Left,
            _ => Self::New(fastest(triangles) * step.dt),
        }
    }

    /// Advance \[mm\] allowed to a tip with the budget `saved`, where its triangle ends after `way` \[mm\]. At most that length is carried over
    /// from earlier steps.
    pub fn of_tip(self, saved: f64, way: f64) -> f64 {
        if let Self::New(more) = self { saved.min(way) + more } else { saved }
    }

    /// Whether an advance budget \[mm\] covers the length `way` \[mm\].
    pub fn suffices(self, advance_budget: f64, way: f64) -> bool {
        matches!(self, Self::Unlimited) || advance_budget >= way * ROUNDED
    }
}

/// Whether a corrector solve is due: a tear nucleates, a ligament parts, or a tip is about to advance and has the budget for it or is at most
/// 5 % above. Tips and nucleation sites that the mesh has refused ask for none: they would in every step.
fn will_tear(
    tables: (&Vertices, &Triangles, &Topology),
    (tearing, tips, decisions): (&Tearing, &Tips, &TearDecisions),
    step: &StepContext,
) -> bool {
    let (vertices, triangles, _) = tables;
    let budget = AdvanceBudget::new(step, triangles);
    let is_acted_on = |tip: usize, decision: &TearDecision| {
        let way = fan_chart(tables, tips.vertex[tip])
            .and_then(|(_, chart)| chart.exit(chart.to_chart(decision.direction)))
            .map_or(0.0, |exit| exit.distance);
        let is_clear = decision.value > CLEAR_CRITERION;
        let is_due = decision.value > due(tearing) || is_expected(tips, decisions, tip);
        let may_advance = is_due && !tips.is_refused[tip];
        let is_clear = is_clear && tearing.mode != TearMode::Glide;
        may_advance && (!is_clear || budget.suffices(budget.of_tip(tips.advance_budget[tip], way), way))
    };
    let mut asking = decisions.tips.iter().enumerate().filter_map(|(tip, decision)| Some((tip, decision.as_ref()?)));
    let is_refused = |site| {
        decisions.refused_nucleation.is_some()
            && decisions.refused_nucleation == RefusedSite::of(site, vertices, triangles)
    };
    decisions.nucleation.is_some_and(|(site, _)| !is_refused(site))
        || decisions.ligament_failure.is_some()
        || asking.any(|(tip, decision)| is_acted_on(tip, decision))
}

/// Whether a gliding tip runs and is expected at its toughness: after edits of the mesh around it the first solve may show much less.
fn is_expected(tips: &Tips, decisions: &TearDecisions, tip: usize) -> bool {
    let mut glides = decisions.glides.iter().filter(|glide| glide.is_running && glide.expected > NEARLY * NEARLY);
    glides.any(|glide| tips.key(tip as u32) == Some(glide.tip))
}

/// Criterion above which a corrector solve is due.
fn due(tearing: &Tearing) -> f64 {
    if tearing.mode == TearMode::Glide { NEARLY } else { DUE }
}

/// Whether the last corrector solve has changed the energy release at a tip that is about to advance.
fn is_unsettled(tearing: &Tearing, decisions: &TearDecisions) -> bool {
    let mut tips = decisions.tips.iter().zip(&decisions.before_corrector);
    tips.any(|(decision, before)| {
        let value = decision.map_or(0.0, |decision| decision.value);
        value > due(tearing) && (value * value - before * before).abs() > AT_REST
    })
}

/// Judged tips in the order of their rows. With a work budget the tip with the most advance saved up comes first; of gliding tips that with the
/// largest criterion.
pub fn in_turn<'a>(
    (tips, tearing): (&Tips, &Tearing),
    decisions: &'a [Option<TearDecision>],
    step: &StepContext,
) -> SmallVec<[(TipKey, &'a TearDecision); 8]> {
    let judged = tips.keys().iter().zip(decisions).zip(&tips.advance_budget);
    let judged = judged.filter_map(|((key, decision), saved)| {
        let decision = decision.as_ref()?;
        Some((*key, decision, if tearing.mode == TearMode::Glide { decision.value } else { *saved }))
    });
    let mut judged: SmallVec<[(TipKey, &TearDecision, f64); 8]> = judged.collect();
    if step.budget.is_some() {
        // Stable: equal ones stay in the order of their rows.
        judged.sort_by(|a, b| b.2.total_cmp(&a.2));
    }
    judged.into_iter().map(|(key, decision, _)| (key, decision)).collect()
}

/// Marks for another solve the bodies whose tips will advance in this step and whose budget allows one. Returns their number.
pub fn advancing(world: &mut World, step: &StepContext) -> usize {
    type Query<'a> = (
        &'a mut SolveResult,
        Option<((&'a Vertices, &'a Triangles, &'a Topology), (&'a Tearing, &'a Tips, &'a mut TearDecisions))>,
    );
    let mut count = 0;
    for (result, tearing) in world.query_mut::<Query>() {
        result.select(false);
        let Some((tables, (tearing, tips, decisions))) = tearing else { continue };
        let is_first = decisions.correctors == 0;
        let tears = if is_first {
            will_tear(tables, (tearing, tips, decisions), step)
        } else {
            is_unsettled(tearing, decisions)
        };
        let is_solved = tears && step.affords(result, 1);
        result.is_tear_undecided |= tears && is_first && !is_solved;
        if is_solved {
            decisions.note_corrector();
            result.select(true);
            count += 1;
        }
    }
    count
}

/// Counts the bodies whose tips may advance further in the step; none where the budget of one of them does not allow it.
pub fn unfinished(world: &mut World, step: &StepContext) -> usize {
    // The step is redone by a solve and by that which decides on its tears.
    if !work::all_afford(world, step, 2) {
        return 0;
    }
    let bodies = world.query_mut::<(&TearDecisions, &SolveResult)>().into_iter();
    bodies.filter(|(decisions, _)| decisions.may_advance_further).count()
}

/// Whether a tip that has just advanced may go far enough for the nearest edge that its next advance could lead to.
pub fn may_go_on(tables: (&Vertices, &Triangles, &Topology), tearing: &Tearing, tips: &Tips, tip: usize) -> bool {
    let left = tips.advance_budget[tip];
    left > 0.0
        && fan_chart(tables, tips.vertex[tip]).is_some_and(|(_, chart)| {
            AdvanceBudget::Left.suffices(left, chart.least_way(chart.to_chart(tips.previous[tip]), tearing.cone))
        })
}

//! The corrector: which bodies are solved again in a step, because their tears will advance or have.

use crate::components::{RefusedSite, SolveResult, TearDecision, TearDecisions, TearMode, Tearing};
use crate::storage::{Tips, Triangles, Vertices};
use crate::systems::fracture::split::NEARLY;
use crate::systems::{StepContext, work};
use hecs::World;

/// A criterion from which a corrector solve is due: the first solve of a step shows two thirds of a change of the energy release, and a tip
/// just below 1 may be above it. With 1 the lead scene's tip advances 8 % above its toughness in the median, with 0.97 2.6 %.
const DUE: f64 = 0.97;

/// Maximum corrector solves of a pass.
pub const CORRECTORS: u32 = 5;

/// Change of G/G_c of a tip by a corrector solve up to which it is at rest.
const AT_REST: f64 = 0.003;

/// Whether a corrector solve is due: a tear nucleates, a ligament parts, or a tip is about to advance. Tips and nucleation sites that the mesh
/// has refused ask for none: they would in every step.
fn will_tear(
    (vertices, triangles): (&Vertices, &Triangles),
    (tearing, tips, decisions): (&Tearing, &Tips, &TearDecisions),
) -> bool {
    let is_acted_on = |tip: usize, decision: &TearDecision| {
        is_near(decision.value, (tearing, tips, decisions), tip) && !tips.is_refused[tip]
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

/// Whether a tip with this criterion is near its toughness, or expected there.
fn is_near(value: f64, (tearing, tips, decisions): (&Tearing, &Tips, &TearDecisions), tip: usize) -> bool {
    value > due(tearing) || is_expected(tips, decisions, tip)
}

/// Whether the last corrector solve has changed the energy release at a tip near its toughness.
fn is_unsettled(tearing: &Tearing, tips: &Tips, decisions: &TearDecisions) -> bool {
    let mut judged = decisions.tips.iter().zip(&decisions.before_corrector).enumerate();
    judged.any(|(tip, (decision, before))| {
        let value = decision.map_or(0.0, |decision| decision.value);
        (value * value - before * before).abs() > AT_REST && is_near(value, (tearing, tips, decisions), tip)
    })
}

/// Whether the corrector solves of a pass have left the energy release at a tip unsettled: the last one allowed still changes it, or the last
/// one has `applied` only a fraction of its answer, which a small change does not show.
pub(super) fn leaves_unsettled(tearing: &Tearing, tips: &Tips, decisions: &TearDecisions, applied: f64) -> bool {
    let mut judged = decisions.tips.iter().enumerate().filter_map(|(tip, decision)| Some((tip, decision.as_ref()?)));
    decisions.correctors >= CORRECTORS && is_unsettled(tearing, tips, decisions)
        || decisions.correctors > 0
            && applied < 1.0
            && judged.any(|(tip, decision)| is_near(decision.value, (tearing, tips, decisions), tip))
}

/// Marks for another solve the bodies whose tips will advance in this step and whose budget allows one. Returns their number.
pub fn advancing(world: &mut World, step: &StepContext) -> usize {
    type Query<'a> =
        (&'a mut SolveResult, Option<((&'a Vertices, &'a Triangles), (&'a Tearing, &'a Tips, &'a mut TearDecisions))>);
    let mut count = 0;
    for (result, tearing) in world.query_mut::<Query>() {
        result.select(false);
        let Some((tables, (tearing, tips, decisions))) = tearing else { continue };
        let is_first = decisions.correctors == 0;
        let tears = if is_first {
            will_tear(tables, (tearing, tips, decisions))
        } else {
            is_unsettled(tearing, tips, decisions)
        };
        let is_solved = tears && step.affords(result, 1);
        result.is_tear_undecided |= tears && is_first && !is_solved;
        result.is_release_unsettled |= tears && !is_first && !is_solved;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::event::DecidedBy;
    use crate::math::Sym2;
    use glam::DVec3;

    fn decided(value: f64) -> TearDecision {
        TearDecision {
            row: 0,
            direction: DVec3::X,
            value,
            other: None,
            margin: 1.0,
            is_ambiguous: false,
            by: DecidedBy::Stress,
            release: None,
            stress: Sym2::ZERO,
            fibre: DVec3::X,
            axes: [DVec3::X, DVec3::Y],
            edges_per_radius: 4.0,
        }
    }

    /// Correctors leave a tip near its toughness unsettled where the last one still moves it, by more than the 0.3 % that counts as rest, or was
    /// shortened.
    #[test]
    fn correctors_leave_a_tip_unsettled_that_the_last_still_moves_or_was_shortened_at() {
        let tearing = Tearing { mode: TearMode::Glide, ..Tearing::default() };
        let is_left_by = |applied: f64, correctors: u32, [before, value]: [f64; 2]| {
            let mut decisions = TearDecisions { tips: vec![Some(decided(before))], ..TearDecisions::default() };
            (0..correctors).for_each(|_| decisions.note_corrector());
            decisions.tips = vec![Some(decided(value))];
            leaves_unsettled(&tearing, &Tips::default(), &decisions, applied)
        };
        assert!(is_left_by(1.0, CORRECTORS, [1.0, 1.002]));
        assert!(!is_left_by(1.0, CORRECTORS, [1.0, 1.001]), "0.2 % of the toughness");
        assert!(!is_left_by(1.0, CORRECTORS, [0.5, 0.9]), "no tip is about to advance");
        assert!(!is_left_by(1.0, CORRECTORS - 1, [1.0, 1.1]), "another corrector is left");
        assert!(is_left_by(0.5, 1, [1.0, 1.001]), "the rest of its answer is not in it");
        assert!(!is_left_by(0.5, 1, [0.5, 0.9]), "no tip is about to advance");
        assert!(!is_left_by(0.5, 0, [1.0, 1.0]), "no corrector");
    }
}

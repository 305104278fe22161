//! What adds up over a run: effort, shortfalls, events, forces at the forceps.

use super::guard::GuardTally;
use super::series::Observation;
use glam::DVec3;
use rhexis::event::{Course, EventKind, Verdict};
use rhexis::report::{BodyReport, Report};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Ambiguous decisions that are listed; beyond, they are only counted.
const MOST_LISTED: usize = 1000;

/// A start or an advance whose runner-up was within 5 %.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(super) struct AmbiguousDecision {
    pub step: u64,
    pub body: String,
    /// Where it was taken, in the rest shape.
    pub at_mm: [f64; 3],
    pub criterion: f64,
    pub margin: f64,
}

/// Sums and extremes over the steps done.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub(super) struct Tally {
    /// Steps.
    pub steps: u64,
    /// Linear iterations of all steps.
    pub iterations: u64,
    /// Most linear iterations of a step.
    pub most_iterations: u32,
    /// Largest relative residual left by a step's last linear solve.
    pub largest_residual: f64,
    /// Steps of a single linear solve that stopped above the tolerance.
    pub unsolved: Count,
    /// Steps whose Newton iteration stopped short of its tolerance.
    pub unconverged: Count,
    /// Steps in which the exact tangent was indefinite and the rotated one took its place.
    pub fell_back: Count,
    /// Steps in which a Cholesky factor was made on the spot after a linear solve failed without one.
    pub fallback_factors: Count,
    /// Steps in which a linear solve stopped because its time was up.
    pub late: Count,
    /// Steps in which a body took only a fraction of its increment, lest it create energy.
    pub step_limited: Count,
    /// Vertices that were relaxed locally, and the most at once.
    pub relaxed: Count,
    pub most_relaxed: usize,
    /// Steps at whose end vertices were put back outside an obstacle.
    pub vertices_projected: Count,
    /// Steps at whose end vertices were held back, lest layers of a body pass through each other; the most at once.
    #[serde(default)]
    pub layers_held_back: Count,
    #[serde(default)]
    pub most_held_back: u32,
    /// Steps in which a body moved as one, since keeping its layers apart had reached its limit.
    #[serde(default)]
    pub layers_moved_as_one: Count,
    /// Steps at whose start layers of a body overlapped; the most pairs of triangles at once.
    #[serde(default)]
    pub layers_overlapping: Count,
    #[serde(default)]
    pub most_overlapping: u32,
    /// Steps that were given up.
    pub failed: Count,
    /// Sub-steps undone and retried.
    pub rolled_back: u64,
    /// Largest criterion value seen at a tip.
    pub largest_criterion: f64,
    /// Events by kind.
    pub events: EventCounts,
    /// The ambiguous decisions, in order; the first [`MOST_LISTED`] of them.
    pub ambiguous: Vec<AmbiguousDecision>,
    /// Steps in which a tear could have gone on when the step's resumes, or rounds, were used up.
    pub cut_short: Count,
    /// Steps in which the budget had no room for the second solve of a tear.
    #[serde(default)]
    pub tear_undecided: Count,
    /// Steps at whose end holds or jaws were behind their hands.
    #[serde(default)]
    pub hands_ahead: Count,
    /// Largest distance between them \[mm\].
    #[serde(default)]
    pub most_hand_ahead: f64,
    /// Steps in which corrector solves ran out before the energy release at a tip came to rest.
    #[serde(default)]
    pub release_unsettled: Count,
    /// Steps in which friction, rigid obstacles or bonds did not meet their laws.
    pub traction_unsettled: Count,
    /// Steps that left refinement to the next one, the budget being used up.
    #[serde(default)]
    pub refinement_put_off: Count,
    grips: BTreeMap<String, GripTally>,
    /// What the energy guard did, by place of the body in the scene.
    guard: BTreeMap<usize, GuardTally>,
}

/// How often, and when first.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize)]
pub(super) struct Count {
    /// Number of steps.
    pub steps: u64,
    /// The first of them.
    pub first: Option<u64>,
}

impl Count {
    pub(crate) fn note(&mut self, is_so: bool, step: u64) {
        if is_so {
            self.steps += 1;
            self.first.get_or_insert(step);
        }
    }
}

/// Events by kind.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize)]
pub(super) struct EventCounts {
    pub started: u64,
    pub advanced: u64,
    /// Advances that were not exact.
    pub detoured: u64,
    pub ambiguous: u64,
    pub ended: u64,
    pub fragment_freed: u64,
    /// Cuts by tools.
    #[serde(default)]
    pub cut: u64,
    pub held_shut: u64,
    pub renewed: u64,
    pub parted: u64,
    pub under_resolved: u64,
    pub held_back: u64,
    #[serde(default)]
    pub nucleation_blocked: u64,
    pub refused: u64,
    pub slipped: u64,
    pub fell_asleep: u64,
    pub woke: u64,
    pub step_failed: u64,
    pub step_guarded: u64,
}

#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize)]
struct GripTally {
    squares: f64,
    steps: u64,
    peak: f64,
}

impl Tally {
    /// Adds a step whose solves may stop at a relative residual and at a position error.
    pub(crate) fn add(&mut self, report: &Report, o: &Observation, [residual, position_error]: [f64; 2]) {
        self.steps += 1;
        self.iterations += u64::from(o.iterations);
        self.most_iterations = self.most_iterations.max(o.iterations);
        self.largest_residual = self.largest_residual.max(o.residual);
        self.largest_criterion = self.largest_criterion.max(o.criterion);
        // The solver tests the residual it updates, which rounding parts from the one it reports.
        // A step of several Newton iterations chooses the tolerance of each and is judged by its convergence.
        let is_one_solve = report.bodies.iter().all(|body| body.newton_iterations <= 1);
        let is_placed = |body: &BodyReport| position_error.is_finite() && body.position_error <= position_error;
        let is_open = o.residual > 1.01 * residual && !report.bodies.iter().all(is_placed);
        self.unsolved.note(is_one_solve && is_open, o.step);
        self.unconverged.note(report.bodies.iter().any(|body| !body.is_converged), o.step);
        self.fell_back.note(report.bodies.iter().any(|body| body.fell_back), o.step);
        self.fallback_factors.note(report.bodies.iter().any(|body| body.fallback_factors > 0), o.step);
        self.late.note(report.bodies.iter().any(|body| body.is_late), o.step);
        self.step_limited.note(report.bodies.iter().any(|body| body.any_substep_limited), o.step);
        let relaxed = report.bodies.iter().map(|body| body.relaxed_vertices).max().unwrap_or(0);
        self.relaxed.note(relaxed > 0, o.step);
        self.most_relaxed = self.most_relaxed.max(relaxed);
        self.vertices_projected.note(report.bodies.iter().any(|body| body.any_vertex_projected), o.step);
        let [held_back, overlapping] =
            [|body: &BodyReport| body.layers_held_back, |body: &BodyReport| body.layers_overlapping]
                .map(|count| report.bodies.iter().map(count).max().unwrap_or(0));
        self.layers_held_back.note(held_back > 0, o.step);
        self.most_held_back = self.most_held_back.max(held_back);
        self.layers_moved_as_one.note(report.bodies.iter().any(|body| body.layers_moved_as_one), o.step);
        self.layers_overlapping.note(overlapping > 0, o.step);
        self.most_overlapping = self.most_overlapping.max(overlapping);
        self.failed.note(report.has_failed, o.step);
        self.cut_short.note(report.bodies.iter().any(|body| body.is_tear_cut_short), o.step);
        self.tear_undecided.note(report.bodies.iter().any(|body| body.is_tear_undecided), o.step);
        let ahead = report.bodies.iter().map(|body| body.hand_ahead).fold(0.0, f64::max);
        self.hands_ahead.note(ahead > 0.0, o.step);
        self.most_hand_ahead = self.most_hand_ahead.max(ahead);
        self.release_unsettled.note(report.bodies.iter().any(|body| body.is_release_unsettled), o.step);
        self.traction_unsettled.note(report.bodies.iter().any(|body| body.is_traction_unsettled), o.step);
        self.refinement_put_off.note(report.bodies.iter().any(|body| body.is_refinement_put_off), o.step);
        self.rolled_back += u64::from(report.rolled_back);
        for (index, body) in
            report.bodies.iter().enumerate().filter(|(_, body)| body.guard.has_acted() || body.guard.corrections() > 0)
        {
            self.guard.entry(index).or_default().add(o.step, body);
        }
        for (name, force) in o.grips.iter().filter(|(_, force)| *force != DVec3::ZERO) {
            let grip = self.grips.entry(name.clone()).or_default();
            grip.squares += force.length_squared();
            grip.steps += 1;
            grip.peak = grip.peak.max(force.length());
        }
    }

    /// Adds an event of a body.
    pub(crate) fn add_event(&mut self, step: u64, body: &str, kind: &EventKind) {
        let counts = &mut self.events;
        match kind {
            EventKind::Started { at, verdict, .. } => {
                counts.started += 1;
                self.note_ambiguous(step, body, *at, *verdict);
            }
            EventKind::Advanced { from, criterion, margin, is_ambiguous, course, .. } => {
                counts.advanced += 1;
                counts.detoured += u64::from(*course != Course::Exact);
                let (criterion, margin, is_ambiguous) = (*criterion, *margin, *is_ambiguous);
                self.note_ambiguous(step, body, *from, Some(Verdict { criterion, margin, is_ambiguous }));
            }
            // A consequence of advances, which are counted.
            EventKind::Released { .. } => {}
            EventKind::Cut { .. } => counts.cut += 1,
            EventKind::Slipped { .. } => counts.slipped += 1,
            EventKind::FellAsleep => counts.fell_asleep += 1,
            EventKind::Woke { .. } => counts.woke += 1,
            EventKind::Ended { .. } => counts.ended += 1,
            EventKind::FragmentFreed { .. } => counts.fragment_freed += 1,
            EventKind::HeldShut { .. } => counts.held_shut += 1,
            EventKind::Renewed { .. } => counts.renewed += 1,
            EventKind::Parted { .. } => counts.parted += 1,
            EventKind::UnderResolved { .. } => counts.under_resolved += 1,
            EventKind::HeldBack { .. } => counts.held_back += 1,
            EventKind::NucleationBlocked(_) => counts.nucleation_blocked += 1,
            EventKind::Refused { .. } => counts.refused += 1,
            EventKind::StepFailed { .. } => counts.step_failed += 1,
            EventKind::StepGuarded { .. } => counts.step_guarded += 1,
            // Of a newer engine: it stands in events.jsonl.
            _ => {}
        }
    }

    fn note_ambiguous(&mut self, step: u64, body: &str, at: DVec3, verdict: Option<Verdict>) {
        let Some(Verdict { criterion, margin, is_ambiguous: true }) = verdict else { return };
        self.events.ambiguous += 1;
        if self.ambiguous.len() < MOST_LISTED {
            let (body, at_mm) = (body.to_owned(), at.to_array());
            self.ambiguous.push(AmbiguousDecision { step, body, at_mm, criterion, margin });
        }
    }

    /// What the guard did to the scene's body of this index.
    pub(crate) fn guard(&self, index: usize) -> GuardTally {
        self.guard.get(&index).cloned().unwrap_or_default()
    }

    /// Root mean square over the steps in which the grip was closed, and peak, of the force at a grip \[N\].
    pub(crate) fn grip(&self, name: &str) -> (f64, f64) {
        let grip = self.grips.get(name).copied().unwrap_or_default();
        ((grip.squares / grip.steps.max(1) as f64).sqrt(), grip.peak)
    }
}

//! Report of a step: results and cost.

pub use crate::components::{Fault, GuardFigures};
#[doc(hidden)]
pub use crate::event::{GuardCause, GuardPlace};

use crate::storage::BodyId;
use std::time::Duration;

/// Run of one system of the step.
///
/// ```
/// # let (mut simulation, body) = rhexis::internal::example()?;
/// use rhexis::report::SystemReport;
/// let report = simulation.step(5.0)?;
/// let slowest: Option<&SystemReport> = report.systems.iter().max_by_key(|system| system.time);
/// assert!(slowest.is_some_and(|system| system.bodies == 1));
/// # Ok::<(), rhexis::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SystemReport {
    /// The system's name.
    pub name: &'static str,
    /// Bodies it ran on, added over Newton iterations; zero means skipped: no body carries the components it needs.
    pub bodies: usize,
    /// Time spent; exactly zero where it ran on no body.
    pub time: Duration,
}

/// One body's solve.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct BodyReport {
    /// The body.
    pub body: BodyId,
    /// Number of the body's vertices now.
    pub vertex_count: usize,
    /// Number of the body's triangles now.
    pub triangle_count: usize,
    /// Number of the body's tear tips now.
    pub tip_count: usize,
    /// Linear iterations, added over Newton iterations.
    pub iterations: u32,
    /// Work of the step, retries and resumes included, in iterations of linear solves, as [counted](crate::settings::Settings::budget): the quantity that a [budget](crate::settings::Settings::budget) limits.
    pub work: u32,
    /// Estimated error of positions after the last solve, over the mean edge; zero unless
    /// [asked for](crate::settings::Settings::position_tolerance).
    pub position_error: f64,
    /// Newton iterations.
    pub newton_iterations: u32,
    /// Relative residual of the last linear solve.
    pub residual: f64,
    /// Estimated error of the stress after it, relative to the stress in the body as a whole; zero where the settings do not ask.
    pub stress_error: f64,
    /// Whether a linear solve stopped because its time was up: the step would not be the same on every run.
    pub is_late: bool,
    /// Largest free nodal imbalance at the last evaluation \[N\]; only where Newton iterates.
    pub imbalance: f64,
    /// Whether Newton's iteration reached its tolerance; true for a linearly implicit step.
    pub is_converged: bool,
    /// Whether the exact tangent was indefinite and the rotated one took its place.
    pub fell_back: bool,
    /// Cholesky factors made on the spot after a linear solve failed without one, retries included.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub fallback_factors: u32,
    /// Whether a tip could have advanced further, but the step had been redone as often as the settings allow or had used up its budget, or a
    /// quasi-static tear had had all its rounds.
    pub is_tear_cut_short: bool,
    /// Whether a tear was due and the step's [budget](crate::settings::Settings::budget) had no room for the second solve that decides on it:
    /// the first one alone did.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub is_tear_undecided: bool,
    /// Whether corrector solves ran out before the energy release at a tip near its toughness came to rest: the fifth, or the last that the step's
    /// [budget](crate::settings::Settings::budget) allowed, still changed it by more than 0.3 % of the toughness, or the line search took only a fraction of the last one's answer.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub is_release_unsettled: bool,
    /// Whether further solves ran out, four rounds or the step's [budget](crate::settings::Settings::budget), before friction, rigid obstacles or the bonds of
    /// a bed met their laws in any part of the step: their forces belong to slightly different places.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub is_traction_unsettled: bool,
    /// Whether the step's [budget](crate::settings::Settings::budget) has left refinement around the tips to the next step.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub is_refinement_put_off: bool,
    /// Whether the last sub-step was limited to a fraction of its increment, lest it create energy; with a budget also where it failed.
    pub is_step_limited: bool,
    /// Whether the body took only a fraction of its increment in any sub-step.
    pub any_substep_limited: bool,
    /// Whether vertices were put back outside an obstacle in any part of the step: no solve had left them there.
    pub any_vertex_projected: bool,
    /// The most vertices in any part of the step that were relaxed locally: the linear solution would have gained energy.
    pub relaxed_vertices: usize,
    /// Largest distance \[mm\] of a hand from where its jaws draw the tissue to, or of a hold from its vertices; above zero after steps that were
    /// limited.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub hand_ahead: f64,
    /// Pairs of parts that repelled each other in the last solve, by the body's [contact with itself](crate::components::SelfContact) and with others.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub self_contacts: u32,
    /// Largest number of vertices held back in one pass of the step, undone attempts included, lest layers of the body pass through each other: no
    /// solve had kept them apart.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub layers_held_back: u32,
    /// Whether the body moved as one in a pass of the step, undone attempts included: keeping its layers apart had taken all that the
    /// [budget](crate::settings::Settings::budget) left, or too many of them were near.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub layers_moved_as_one: bool,
    /// Pairs of triangles that had passed through each other at the start of the step: they are left alone until they are apart.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub layers_overlapping: u32,
    /// Steps since the body was spawned in which a tear that was to advance waited, no faster than Rayleigh waves.
    pub tear_held_back: u32,
    /// Largest criterion at a tip that waited so; zero before the first.
    pub held_back_criterion: f64,
    /// Why the body's step was given up, where it was: its last good state stands, at this time or before.
    pub fault: Option<Fault>,
    /// Energy guard's actions on the body in this step.
    pub guard: GuardFigures,
    /// Whether the body sleeps: no system ran on it, and the other figures are those of the last step that did.
    pub is_asleep: bool,
}

/// One step, or one static solve.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Report {
    /// Steps done so far.
    pub step: u64,
    /// Time reached \[ms\].
    pub time: f64,
    /// The systems in their order.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub systems: Vec<SystemReport>,
    /// The bodies in order of spawning.
    pub bodies: Vec<BodyReport>,
    /// Steps of bodies, or parts of them, that were undone because they left a state that is not finite, or would have created energy.
    pub rolled_back: u32,
    /// Whether a body's step was given up and its last good state stands. Others have done theirs; where there are
    /// none, time has stopped there.
    pub has_failed: bool,
}

impl Report {
    /// Work of all bodies per millisecond of the step: times a frame's milliseconds, the value of
    /// [`Settings::budget`](crate::settings::Settings::budget) for that frame time on this machine. `None` where no time was measured or no work was done.
    pub fn work_per_millisecond(&self) -> Option<f64> {
        let work: f64 = self.bodies.iter().map(|body| f64::from(body.work)).sum();
        let time: Duration = self.systems.iter().map(|system| system.time).sum();
        let milliseconds = time.as_secs_f64() * 1e3;
        (work > 0.0 && milliseconds > 0.0).then(|| work / milliseconds)
    }
}

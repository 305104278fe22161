//! Report of a step's solves for a body.

use crate::components::Fault;
use crate::settings::Tangent;

/// Result of the last solve of a body, and the work of its step. *State.* A body without one is left out of a step.
#[derive(Clone, Debug, Default)]
pub struct SolveResult {
    /// Linear iterations in this step.
    pub iterations: u32,
    /// Newton iterations in this step, or in its last stage.
    pub newton_iterations: u32,
    /// Relative residual of the last linear solve.
    pub linear_residual: f64,
    /// Estimated relative stress error after the last linear solve; zero without a stress tolerance.
    pub stress_error: f64,
    /// Estimated error of positions after the last linear solve, over the mean edge; zero where it was not asked for.
    pub position_error: f64,
    /// Whether a linear solve of this step stopped because time was up.
    pub is_late: bool,
    /// Largest free nodal imbalance at the last evaluation \[N\].
    pub imbalance: f64,
    /// Whether the body takes part in the step: awake, and not done with one that is resumed for others. Its increment then belongs to this
    /// step and to the mesh as it is.
    pub(crate) is_in_step: bool,
    /// Whether the body takes part in the phase at hand.
    pub(crate) is_active: bool,
    /// Whether Newton's iteration has reached its tolerance; of a linearly implicit step, whether the solve has an answer.
    pub(crate) has_converged: bool,
    /// Whether an indefinite tangent, exact or in a static solve projected, gave way to the rotated one.
    pub fell_back: bool,
    /// Cholesky factors made on the spot in this step after a linear solve failed without one, retries included.
    pub fallback_factors: u32,
    /// The tangent that the last linear solve used.
    pub tangent: Tangent,
    /// Work that this step has taken, retries and resumes included, in iterations of linear solves.
    pub work: u32,
    /// Work of one tear advance, in iterations; zero for a body that cannot tear.
    pub(crate) work_of_advance: u32,
    /// Whether a tear was decided without a corrector solve, for lack of budget.
    pub is_tear_undecided: bool,
    /// Whether corrector solves of this step ended before the energy release at a tip near its toughness came to rest.
    pub is_release_unsettled: bool,
    /// Whether rounds or budget of this step ran out before friction, rigid obstacles or bonds met their laws.
    pub is_traction_unsettled: bool,
    /// Whether the budget has ended the last linear solve before its tolerances were reached.
    pub(crate) is_cut_short: bool,
    /// Whether tips of the body glide in this step.
    pub(crate) has_gliding_tips: bool,
    /// Whether a tip has glided since the last solve.
    pub(crate) follows_glide: bool,
    /// Why the last step of the body was given up.
    pub fault: Option<Fault>,
}

impl SolveResult {
    /// Whether systems work on the body in this phase of the step: it is awake and not converged, and the loop at hand selects it.
    pub fn is_active(&self) -> bool {
        self.is_active
    }

    /// Number of a body's rows to work on in this phase: all of them, or none.
    pub(crate) fn rows_to_solve(&self, rows: usize) -> usize {
        if self.is_active { rows } else { 0 }
    }

    /// Selects the body for the phase that begins; one that is not in the step stays out.
    pub(crate) fn select(&mut self, is_asked: bool) {
        self.is_active = self.is_in_step && is_asked;
    }

    /// Begins a step, in which a sleeping body takes no part.
    pub(crate) fn begin(&mut self, is_asleep: bool) {
        (self.iterations, self.newton_iterations, self.is_late) = (0, 0, false);
        (self.fell_back, self.fault, self.follows_glide) = (false, None, false);
        self.take_part(!is_asleep);
    }

    /// Takes the body into the step and its next phase, or leaves it out.
    pub(crate) fn take_part(&mut self, is_in_step: bool) {
        (self.is_in_step, self.is_active, self.has_converged) = (is_in_step, is_in_step, !is_in_step);
    }

    /// Forgets the results of an undone attempt.
    pub(crate) fn forget_attempt(&mut self) {
        (self.linear_residual, self.stress_error, self.imbalance) = (0.0, 0.0, 0.0);
    }
}

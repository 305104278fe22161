//! The account of the energy guard.

/// Energy \[mJ\] that steps of a body have created, and how the guard holds it back. Carried from step to step.
#[derive(Clone, Debug, Default)]
pub struct GuardLedger {
    /// Spurious energy \[mJ\]: created by steps along the tangent and not taken away again; never negative.
    pub spurious_energy: f64,
    /// Upper bound \[mJ\] of the spurious energy since the last full sum.
    pub unchecked_bound: f64,
    /// `spurious_energy` and `unchecked_bound` at the start of the step.
    pub start_spurious_energy: [f64; 2],
    /// Whether the spurious energy of the last solve exceeds the limit.
    pub creates_energy: bool,
    /// Whether this step is limited to a fraction of its increment, lest that happen; with a budget also whether it failed. The next one
    /// leaves work for a fallback sub-step.
    pub is_step_limited: bool,
    /// Number of times the next fallback sub-step is shortened: once more each time that the body is step-limited again.
    pub fallback_shortenings: u32,
    /// Whole steps in which vertices may still [be relaxed locally](crate::report::GuardFigures::relaxed) at once, after one in which some had to.
    pub relaxing: u32,
}

impl GuardLedger {
    /// Begins a step, or a part of one that is retried.
    pub(crate) fn begin(&mut self, is_retried: bool) {
        self.is_step_limited = false;
        if !is_retried {
            self.relaxing = self.relaxing.saturating_sub(1);
        }
        self.start_spurious_energy = [self.spurious_energy, self.unchecked_bound];
    }

    /// Forgets the results of an undone attempt.
    pub(crate) fn forget_attempt(&mut self) {
        self.creates_energy = false;
        [self.spurious_energy, self.unchecked_bound] = self.start_spurious_energy;
    }
}

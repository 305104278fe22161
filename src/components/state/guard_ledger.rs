//! The account of the energy guard.

/// Energy \[mJ\] that steps of a body have created, and how the guard holds it back. *State.*
#[derive(Clone, Debug, Default)]
pub struct GuardLedger {
    /// Spurious energy \[mJ\]: created by steps along the tangent and not taken away again; never negative.
    pub spurious_energy: f64,
    /// `spurious_energy` at the start of the step.
    pub start_spurious_energy: f64,
    /// Whether the spurious energy of the last solve exceeds the limit.
    pub creates_energy: bool,
    /// Whether this step took only a fraction of its increment or, with a budget, failed; the next one reserves a fallback sub-step.
    pub is_step_limited: bool,
    /// Steps left in which local relaxation may start from any number of triangles, counted down from the last step that needed one.
    pub relaxing: u32,
}

impl GuardLedger {
    /// Begins a step, or a part of one that is retried.
    pub(crate) fn begin(&mut self, is_retried: bool) {
        self.is_step_limited = false;
        if !is_retried {
            self.relaxing = self.relaxing.saturating_sub(1);
        }
        self.start_spurious_energy = self.spurious_energy;
    }

    /// Forgets the results of an undone attempt.
    pub(crate) fn forget_attempt(&mut self) {
        self.creates_energy = false;
        self.spurious_energy = self.start_spurious_energy;
    }
}

//! The account of the energy guard.

use super::forceps::{LEAST_PACE, PACE_GROWTH};

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
    /// Longest way \[mm\] of holds in the next step, after one that was limited; zero for no limit.
    pub hold_pace: f64,
    /// `hold_pace` at the start of the step.
    pub start_hold_pace: f64,
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
        self.start_hold_pace = self.hold_pace;
    }

    /// Part of their way \[mm\] that holds go in this step. A pace doubles until it spans the way.
    pub(crate) fn part_of_holds(&mut self, way: impl FnOnce() -> f64) -> f64 {
        if self.hold_pace == 0.0 {
            return 1.0;
        }
        let way = way();
        let most = self.hold_pace.max(LEAST_PACE * way);
        if way <= most {
            self.hold_pace = 0.0;
            return 1.0;
        }
        self.hold_pace = PACE_GROWTH * most;
        most / way
    }

    /// Part of their remaining way that holds go in a later solve of the step: none at a pace.
    pub(crate) fn rest_of_holds(&self) -> f64 {
        if self.hold_pace > 0.0 { 0.0 } else { 1.0 }
    }

    /// Forgets the results of an undone attempt.
    pub(crate) fn forget_attempt(&mut self) {
        self.creates_energy = false;
        self.spurious_energy = self.start_spurious_energy;
        self.hold_pace = self.start_hold_pace;
    }
}

//! The progress bar on standard error.

use super::say::complain;
use super::series::Observation;
use indicatif::{ProgressBar, ProgressStyle};
use std::time::Duration;

/// Shows step, simulated time, real-time factor and tears; nothing if standard error is no terminal.
pub(super) struct Progress {
    bar: ProgressBar,
}

impl Progress {
    pub(crate) fn new(steps: u64, is_quiet: bool) -> Self {
        let bar = if is_quiet { ProgressBar::hidden() } else { ProgressBar::new(steps) };
        if let Ok(style) = ProgressStyle::with_template("{bar:30} step {pos}/{len}  {msg}") {
            bar.set_style(style);
        }
        Self { bar }
    }

    /// The state after a step and the time that all steps took.
    pub(crate) fn show(&self, o: &Observation, stepping: Duration) {
        let Observation { step, time, torn, tips, .. } = *o;
        let factor = real_time_factor(time, stepping);
        let tears = if torn > 0.0 { format!("  torn {torn:.2} mm, {tips} tip(s)") } else { String::new() };
        self.bar.set_position(step);
        self.bar.set_message(format!("t = {time:.0} ms  {factor:.3} × real time{tears}"));
    }

    /// Says on standard error what has gone wrong meanwhile.
    pub(crate) fn complain(&self, what: &str) {
        self.bar.suspend(|| complain(&format!("warning: {what}")));
    }

    pub(crate) fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

/// Simulated time \[ms\] over the time that the steps took: above 1 the scene runs faster than life.
pub(super) fn real_time_factor(time: f64, stepping: Duration) -> f64 {
    if stepping.is_zero() { 0.0 } else { 1e-3 * time / stepping.as_secs_f64() }
}

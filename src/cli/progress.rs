//! The progress bar on standard error.

use indicatif::{ProgressBar, ProgressStyle};
use std::time::Instant;

/// Shows step, simulated time, real-time factor and tears; nothing if standard error is no terminal.
pub(super) struct Progress {
    bar: ProgressBar,
    start: Instant,
}

impl Progress {
    pub fn new(steps: u64, is_quiet: bool) -> Self {
        let bar = if is_quiet { ProgressBar::hidden() } else { ProgressBar::new(steps) };
        if let Ok(style) = ProgressStyle::with_template("{bar:30} step {pos}/{len}  {msg}") {
            bar.set_style(style);
        }
        Self { bar, start: Instant::now() }
    }

    /// After a step: simulated time \[ms\], length torn \[mm\] and tips alive.
    pub fn show(&self, step: u64, time: f64, torn: f64, tips: usize) {
        let factor = real_time_factor(time, self.start.elapsed().as_secs_f64());
        let tears = if torn > 0.0 { format!("  torn {torn:.2} mm, {tips} tip(s)") } else { String::new() };
        self.bar.set_position(step);
        self.bar.set_message(format!("t = {:.0} ms  {factor:.3} × real time{tears}", time));
    }

    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

/// Simulated time \[ms\] over elapsed time \[s\]: above 1 the scene runs faster than life.
pub(super) fn real_time_factor(time: f64, elapsed: f64) -> f64 {
    if elapsed > 0.0 { 1e-3 * time / elapsed } else { 0.0 }
}

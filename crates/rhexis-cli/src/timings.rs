//! What the systems of the step cost, added up over a run.

use rhexis::report::Report;
use rhexis::schedule::STEP;
use serde::Serialize;
use std::fmt::Write;
use std::time::Duration;

/// One system over the whole run.
#[derive(Clone, Debug, Serialize)]
pub(super) struct SystemTime {
    /// Its name.
    pub name: &'static str,
    /// Whether it never had work: no body carries what it needs.
    pub is_skipped: bool,
    /// Bodies it ran on, added over steps and Newton iterations.
    pub runs: u64,
    /// Time over the whole run \[s\].
    pub seconds: f64,
    /// Mean per step \[ms\].
    pub mean_ms: f64,
    /// Part of the time of all systems, 0 to 1.
    pub share: f64,
}

/// Sums over the steps done.
pub(super) struct Timings {
    steps: u32,
    runs: Vec<u64>,
    times: Vec<Duration>,
}

impl Timings {
    pub(crate) fn new() -> Self {
        Self { steps: 0, runs: vec![0; STEP.len()], times: vec![Duration::ZERO; STEP.len()] }
    }

    pub(crate) fn add(&mut self, report: &Report) {
        self.steps = self.steps.saturating_add(1);
        for (i, system) in report.systems.iter().enumerate().take(STEP.len()) {
            self.runs[i] += system.bodies as u64;
            self.times[i] += system.time;
        }
    }

    /// The systems in the order of the step.
    pub(crate) fn systems(&self) -> Vec<SystemTime> {
        let total: f64 = self.times.iter().map(Duration::as_secs_f64).sum();
        let row = |(i, system): (usize, &rhexis::schedule::System)| {
            let (runs, seconds) = (self.runs[i], self.times[i].as_secs_f64());
            let share = if total > 0.0 { seconds / total } else { 0.0 };
            let mean_ms = 1e3 * seconds / f64::from(self.steps.max(1));
            SystemTime { name: system.name, is_skipped: runs == 0, runs, seconds, mean_ms, share }
        };
        STEP.iter().enumerate().map(row).collect()
    }

    /// The table that `--timings` prints.
    pub(crate) fn table(&self) -> String {
        let systems = self.systems();
        let mut text = String::from("system          mean per step   share");
        for s in &systems {
            // Writing to a String cannot fail.
            let _ = match s.is_skipped {
                true => write!(text, "\n{:14}       skipped", s.name),
                false => write!(text, "\n{:14} {:11.4} ms  {:5.1} %", s.name, s.mean_ms, 100.0 * s.share),
            };
        }
        let mean: f64 = systems.iter().map(|s| s.mean_ms).sum();
        let _ = write!(text, "\n{:14} {mean:11.4} ms", "step");
        text
    }
}

//! Times of steps: processor time of the stepping thread, or time on the wall where several threads step.

use cpu_time::{ProcessTime, ThreadTime};
use std::time::{Duration, Instant};

/// A running measurement.
pub(crate) struct Stopwatch {
    wall: Instant,
    thread: Option<ThreadTime>,
    process: Option<ProcessTime>,
}

/// What a measurement came to \[ms\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Elapsed {
    /// On the wall.
    pub wall: f64,
    /// Processor time of the measuring thread; on the wall where the system counts none.
    pub thread: f64,
    /// Processor time of all threads of the program; on the wall where the system counts none.
    pub process: f64,
}

impl Stopwatch {
    pub(crate) fn start() -> Self {
        Self { wall: Instant::now(), thread: ThreadTime::try_now().ok(), process: ProcessTime::try_now().ok() }
    }

    pub(crate) fn elapsed(&self) -> Elapsed {
        let wall = ms(self.wall.elapsed());
        let thread = self.thread.and_then(|start| start.try_elapsed().ok()).map_or(wall, ms);
        let process = self.process.and_then(|start| start.try_elapsed().ok()).map_or(wall, ms);
        Elapsed { wall, thread, process }
    }
}

fn ms(time: Duration) -> f64 {
    1e3 * time.as_secs_f64()
}

/// The value below which `part` of the values lie; NaN without values.
pub(crate) fn quantile(values: &[f64], part: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let place = (part * sorted.len() as f64).ceil() as usize;
    sorted.get(place.clamp(1, sorted.len().max(1)) - 1).copied().unwrap_or(f64::NAN)
}

/// The middle value; NaN without values.
pub(crate) fn median(values: &[f64]) -> f64 {
    quantile(values, 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_values_of_the_list() {
        let values: Vec<f64> = (1..=1000).rev().map(f64::from).collect();
        assert_eq!([0.0, 0.5, 0.999, 1.0].map(|part| quantile(&values, part)), [1.0, 500.0, 999.0, 1000.0]);
        assert!(median(&[]).is_nan());
    }
}

//! The moments to draw: of a run's directory, or of a scene that is run for it.

use super::{Moment, frames, together};
use crate::progress::Progress;
use crate::series::observe;
use crate::{SceneArgs, Stop, document};
use std::path::Path;
use std::time::Instant;

/// Steps in a row that may fail.
const MOST_FAILURES: u32 = 10;

/// Which moments.
pub(super) enum Wanted {
    /// So many, evenly from the first to the last; of one the last.
    Spread(usize),
    /// Those nearest to these times \[ms\].
    At(Vec<f64>),
}

impl Wanted {
    /// Places in a list of times in their order.
    fn places(&self, times: &[f64]) -> Vec<usize> {
        let nearest = |time: f64| {
            let distance = |&at: &usize| (times[at] - time).abs();
            (0..times.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0)
        };
        let (first, last) = (times.first().copied().unwrap_or(0.0), times.last().copied().unwrap_or(0.0));
        match self {
            Self::At(asked) => asked.iter().map(|&time| nearest(time)).collect(),
            Self::Spread(1) => vec![times.len().saturating_sub(1)],
            Self::Spread(count) => {
                let part = |i: usize| i as f64 / (*count - 1).max(1) as f64;
                let mut places: Vec<usize> = (0..*count).map(|i| nearest(first + part(i) * (last - first))).collect();
                // Fewer moments than were asked for: each once.
                places.dedup();
                places
            }
        }
    }
}

/// The moments of a run's directory.
///
/// # Errors
/// Where it has no frames, or one cannot be read.
pub(super) fn of_run(run: &Path, wanted: &Wanted) -> Result<Vec<Moment>, Stop> {
    let entries = frames::entries(run)?;
    let times: Vec<f64> = entries.iter().map(|entry| entry.time).collect();
    wanted.places(&times).into_iter().map(|place| frames::read(&entries[place])).collect()
}

/// Runs a scene and keeps the moments.
///
/// # Errors
/// Where the scene is refused or cannot go on.
pub(super) fn of_scene(args: &super::RenderArgs, wanted: &Wanted) -> Result<(String, Vec<Moment>), Stop> {
    let scene = document(&SceneArgs { scene: args.source.clone(), set: args.set.clone() })?.scene()?;
    let mut instance = scene.instantiate()?;
    if let Some(steps) = args.steps {
        instance.run.steps = steps;
    }
    let progress = Progress::new(instance.run.steps, args.quiet);
    let mut kept = Kept::new(wanted);
    let begin = Instant::now();
    let mut failures = 0;
    loop {
        let step = instance.step();
        let is_last = instance.is_finished();
        if is_last || kept.wants(step, instance.simulation.time()) {
            let frame = instance.simulation.frame();
            kept.add(
                step,
                Moment { time: instance.simulation.time(), body: together(frame.bodies), solids: frame.solids },
            );
        }
        if is_last {
            break;
        }
        instance.advance().map_err(|error| Stop::Failed(error.to_string()))?;
        let has_failed = instance.simulation.report().has_failed;
        failures = if has_failed { failures + 1 } else { 0 };
        if failures == MOST_FAILURES {
            return Err(Stop::Failed(format!(
                "the last {failures} steps left no usable state; `rhexis run {}` says more",
                args.source
            )));
        }
        progress.show(&observe(&mut instance), begin.elapsed());
    }
    progress.finish();
    let times: Vec<f64> = kept.moments.iter().map(|(_, moment)| moment.time).collect();
    let places = wanted.places(&times);
    let moments = places.into_iter().map(|place| kept.moments[place].1.clone()).collect();
    Ok((scene.name().to_owned(), moments))
}

/// Moments of a run whose end is not known before: every so-many-th step, ever fewer as they become too many.
struct Kept<'a> {
    wanted: &'a Wanted,
    every: u64,
    moments: Vec<(u64, Moment)>,
}

impl<'a> Kept<'a> {
    fn new(wanted: &'a Wanted) -> Self {
        Self { wanted, every: 1, moments: Vec::new() }
    }

    fn wants(&self, step: u64, time: f64) -> bool {
        match self.wanted {
            Wanted::Spread(count) => *count > 1 && step.is_multiple_of(self.every),
            Wanted::At(times) => {
                let before = self.moments.last().map_or(f64::NEG_INFINITY, |(_, moment)| moment.time);
                times.iter().any(|&asked| before < asked && asked <= time)
            }
        }
    }

    fn add(&mut self, step: u64, moment: Moment) {
        if self.moments.last().is_none_or(|(last, _)| *last != step) {
            self.moments.push((step, moment));
        }
        if let Wanted::Spread(count) = self.wanted
            && self.moments.len() > 4 * *count
        {
            self.every *= 2;
            let every = self.every;
            self.moments.retain(|(step, _)| step.is_multiple_of(every));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_spread_over_a_run_of_any_length() {
        for steps in [0_u64, 1, 5, 17, 400] {
            let wanted = Wanted::Spread(6);
            let mut kept = Kept::new(&wanted);
            for step in 0..=steps {
                let time = 10.0 * step as f64;
                if step == steps || kept.wants(step, time) {
                    kept.add(step, Moment { time, ..Moment::default() });
                }
            }
            let times: Vec<f64> = kept.moments.iter().map(|(_, moment)| moment.time).collect();
            let chosen: Vec<f64> = wanted.places(&times).iter().map(|&place| times[place]).collect();
            assert_eq!((chosen[0], *chosen.last().unwrap()), (0.0, 10.0 * steps as f64));
            assert_eq!(chosen.len(), (steps as usize + 1).min(6), "{steps}: {chosen:?}");
            // Kept are at least twice as many as are wanted, so that each is at most a quarter of a gap away from its place.
            let gap = 10.0 * steps as f64 / 5.0;
            assert!(chosen.windows(2).all(|w| steps < 24 || (w[1] - w[0] - gap).abs() <= 0.5 * gap), "{chosen:?}");
        }
        assert_eq!(Wanted::At(vec![12.0, 95.0]).places(&[0.0, 10.0, 20.0, 100.0]), [1, 3]);
        assert_eq!(Wanted::Spread(1).places(&[0.0, 10.0]), [1]);
    }
}

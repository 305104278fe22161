//! What the minutes were like.

use rhexis::event::GuardCause;
use rhexis::report::GuardFigures;
use std::collections::BTreeMap;
use std::fmt;
use std::time::Duration;

#[derive(Default)]
pub struct Summary {
    /// Processor time of the steps of every frame \[ms\].
    times: Vec<f64>,
    /// Their work, in iterations of linear solves.
    works: Vec<f64>,
    /// Frames with a step solved further, with one undone, and with a body that went only a part of its way.
    guarded: [usize; 3],
    /// Attempts solved further and attempts undone, by cause.
    attempts: [[u32; GuardCause::COUNT]; 2],
    /// Frames without an event, a change of the mesh or a step undone; those of them that allocated nothing.
    quiet: usize,
    without_allocation: usize,
    counts: BTreeMap<&'static str, u32>,
    /// How far the hand was ahead of its jaws in every frame in which they hold \[mm\].
    ahead: Vec<f64>,
}

impl Summary {
    pub fn count(&mut self, what: &'static str) {
        *self.counts.entry(what).or_default() += 1;
    }

    /// How often something was counted.
    pub fn counted(&self, what: &str) -> u32 {
        self.counts.get(what).copied().unwrap_or(0)
    }

    /// Frames in which the jaws hold tissue.
    pub fn held(&self) -> usize {
        self.ahead.len()
    }

    /// A frame in which the jaws hold tissue and the hand is so far ahead of them \[mm\].
    pub fn add_held(&mut self, ahead: f64) {
        self.ahead.push(ahead);
    }

    /// What the energy guard did to a body in a step.
    pub fn add_guard(&mut self, figures: &GuardFigures) {
        for (sums, counts) in self.attempts.iter_mut().zip([figures.corrected, figures.refused]) {
            sums.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
        }
    }

    /// A frame whose steps took this time and work, and whether one was solved further, undone or gone in part; with the number of their
    /// allocations if nothing happened in it.
    pub fn add_frame(
        &mut self,
        (time, work): (Duration, u32),
        is_guarded: [bool; 3],
        quiet_allocations: Option<usize>,
    ) {
        self.times.push(time.as_secs_f64() * 1e3);
        self.works.push(f64::from(work));
        self.guarded.iter_mut().zip(is_guarded).for_each(|(count, is_one)| *count += usize::from(is_one));
        self.quiet += usize::from(quiet_allocations.is_some());
        self.without_allocation += usize::from(quiet_allocations == Some(0));
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "steps of a frame [ms of processor time]: {}", Spread(&self.times))?;
        writeln!(f, "work of a frame [iterations]: {}", Spread(&self.works))?;
        let count = self.times.len();
        let [further, undone, in_part] = self.guarded;
        writeln!(
            f,
            "frames: {count}, {further} with steps solved further, {undone} with steps undone and tried again, {in_part} with a body that went \
             a part of its way"
        )?;
        for (what, counts) in ["solved further", "undone"].into_iter().zip(&self.attempts) {
            let by_cause = GuardCause::ALL.iter().zip(counts).filter(|(_, count)| **count > 0);
            let by_cause: Vec<String> = by_cause.map(|(cause, count)| format!("{cause} {count}")).collect();
            writeln!(
                f,
                "attempts {what}, by cause: {}",
                if by_cause.is_empty() { "none".into() } else { by_cause.join(", ") }
            )?;
        }
        let [grasps, slips, advances] = ["grasped", "slipped", "tears advanced"].map(|what| self.counted(what));
        writeln!(f, "grasps: {grasps}, {slips} of them slipped, {} frames held, {advances} advances", self.held())?;
        writeln!(f, "the hand ahead of its jaws in frames held [mm]: {}", Spread(&self.ahead))?;
        writeln!(f, "quiet frames: {}, {} of them without an allocation", self.quiet, self.without_allocation)?;
        let counts: Vec<String> = self.counts.iter().map(|(what, count)| format!("{what} {count}")).collect();
        write!(f, "{}", counts.join(", "))
    }
}

/// Mean and percentiles of some figures.
struct Spread<'a>(&'a [f64]);

impl fmt::Display for Spread<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut sorted = self.0.to_vec();
        sorted.sort_unstable_by(f64::total_cmp);
        let count = sorted.len();
        let at = |part: f64| sorted.get((count.saturating_sub(1) as f64 * part) as usize).copied().unwrap_or(0.0);
        let mean = sorted.iter().sum::<f64>() / count.max(1) as f64;
        let (median, most, worst) = (at(0.5), at(0.99), at(1.0));
        write!(f, "mean {mean:.2}, median {median:.2}, 99th percentile {most:.2}, worst {worst:.2}")
    }
}

//! Figures of the steady part of a tear.

use super::super::Rows;
use glam::DVec3;
use rhexis_scene::measures::{HandForce, HandForceFigures};

/// Parts of the torn length that are left out: the sheet is drawn taut in the first, and the rim is near in the last.
const SKIPPED: [f64; 2] = [0.25, 0.1];
/// Tolerance of the 10 and 90 % quantiles of the pull; that of the mean is 3 to 5 %.
const RANGE: f64 = 0.08;

/// A step of a tear.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    /// Length torn at its end \[mm\].
    pub torn: f64,
    /// Whether a tip advanced in it.
    pub has_advanced: bool,
    /// Pull at its end over that of theory.
    pub pull: f64,
}

/// Places of the steps in the steady part of the torn length.
pub(super) fn steady_steps(steps: &[Step]) -> std::ops::Range<usize> {
    let [from, to] = [steps.first(), steps.last()].map(|step| step.map_or(0.0, |step| step.torn));
    let [begin, end] = [SKIPPED[0], 1.0 - SKIPPED[1]].map(|part| from + part * (to - from));
    steps.partition_point(|step| step.torn <= begin)..steps.partition_point(|step| step.torn <= end)
}

/// Pull over the steps of the steady part, over that of theory; `None` for a sheet that does not tear.
pub(super) fn pull(steps: &[Step]) -> Option<HandForceFigures> {
    let mut hand = HandForce::default();
    steps[steady_steps(steps)].iter().for_each(|step| hand.note(Some(DVec3::X * step.pull), step.has_advanced));
    hand.figures()
}

/// Judges the pull over the steps of the steady part: its mean by a tolerance, and the range that most steps are in.
pub(super) fn judge_pull(rows: &mut Rows, what: &str, steps: &[Step], tolerance: f64) {
    let Some(HandForceFigures { mean, range: [low, high], .. }) = pull(steps) else {
        rows.ratio(format!("{what}: does not tear"), f64::NAN, 0.0);
        return;
    };
    rows.ratio(format!("{what}: mean pull over that of theory, {mean:.3}, off 1"), (mean - 1.0).abs(), tolerance);
    let off = (1.0 - low).max(high - 1.0);
    rows.ratio(format!("{what}: pull of 10 to 90 % of the steps, {low:.3} to {high:.3}, off 1"), off, RANGE);
}

/// The middle one of some values; no number where there are none.
pub(super) fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Without the first fifth, in which a sheet is drawn taut, and the last, which the rim is near.
pub(super) fn steady<T>(all: &[T]) -> &[T] {
    let part = all.len() / 5;
    &all[part..all.len() - part]
}

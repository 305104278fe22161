//! Which colour a stress has, and round numbers for ticks.

use super::Rgba;
use colorgrad::{BasisGradient, Gradient};
use rhexis::frame::BodyFrame;

/// Share of the triangles below the upper end of an automatic scale: a few singular corners would otherwise leave the
/// rest of the body in one colour.
const PERCENTILE: f64 = 0.98;

/// A triangle whose stress is not a number.
pub(super) const UNKNOWN: Rgba = [150, 150, 150, 255];

/// Colours of a range of values \[MPa\].
pub(super) struct Scale {
    pub low: f64,
    pub high: f64,
    /// What the reader must know about the ends of the range.
    pub notes: Vec<String>,
    gradient: BasisGradient,
}

impl Scale {
    /// The given range, or 0 to the 98th percentile of the largest principal stress of all the bodies.
    pub(super) fn new(range: Option<[f64; 2]>, bodies: &[&BodyFrame]) -> Self {
        let all = || bodies.iter().flat_map(|body| &body.principal_stress);
        let mut values: Vec<f64> = all().map(|p| p.x).filter(|v| v.is_finite()).collect();
        values.sort_by(f64::total_cmp);
        let smallest = values.first().copied().unwrap_or(0.0);
        let largest = values.last().copied().unwrap_or(0.0);
        let given = range.filter(|[low, high]| low.is_finite() && high.is_finite() && low < high);
        let automatic = given.is_none();
        let [low, high] = given.unwrap_or_else(|| {
            let last = values.len().saturating_sub(1);
            let percentile = values.get((PERCENTILE * last as f64).round() as usize).copied().unwrap_or(0.0);
            // Rounding residues of an unloaded body are not stresses.
            [0.0, [percentile, largest].into_iter().find(|&v| v > 1e-12).unwrap_or(1.0)]
        });
        let mut notes = Vec::new();
        if largest > high {
            notes.push(if automatic { "top: 98th percentile".to_owned() } else { "top: as set".to_owned() });
            notes.push(format!("largest value: {}", short(largest)));
        }
        if smallest < low - 1e-3 * (high - low) {
            notes.push(format!("smallest value: {}", short(smallest)));
        }
        if values.len() < all().count() {
            notes.push("grey: not a number".to_owned());
        }
        Self { low, high, notes, gradient: colorgrad::preset::viridis() }
    }

    pub(super) fn color(&self, value: f64) -> Rgba {
        if !value.is_finite() {
            return UNKNOWN;
        }
        let t = (value - self.low) / (self.high - self.low);
        self.gradient.at(t.clamp(0.0, 1.0) as f32).to_rgba8()
    }
}

/// The largest of 1, 2, 5 × 10ⁿ that is not above `limit` (positive, finite).
pub(super) fn round_down(limit: f64) -> f64 {
    let power = 10_f64.powf(limit.log10().floor());
    [5.0, 2.0, 1.0].into_iter().map(|m| m * power).find(|&v| v <= limit * (1.0 + 1e-9)).unwrap_or(power)
}

/// Round values from `low` to `high`, about `count` of them, with the text of each.
pub(super) fn ticks(low: f64, high: f64, count: f64) -> Vec<(f64, String)> {
    let step = round_down(2.0 * (high - low) / count);
    let (first, last) = ((low / step - 1e-9).ceil(), (high / step + 1e-9).floor());
    if !(step.is_finite() && step > 0.0 && last - first < 100.0) {
        return vec![(low, short(low)), (high, short(high))];
    }
    let decimals = (-step.log10().floor()).max(0.0);
    let plain = decimals <= 4.0 && high.abs().max(low.abs()) < 1e5;
    (0..=(last - first).max(0.0) as u32)
        .map(|k| {
            let value = (first + f64::from(k)) * step;
            (value, if plain { format!("{value:.*}", decimals as usize) } else { format!("{value:.1e}") })
        })
        .collect()
}

/// Three significant digits.
pub(super) fn short(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 {
        "0".to_owned()
    } else if (1e-3..1e5).contains(&size) {
        let decimals = (2.0 - size.log10().floor()).max(0.0);
        format!("{value:.*}", decimals as usize)
    } else {
        format!("{value:.2e}")
    }
}

//! Whether a soak has left anything behind: its first rounds after the warm-up against its last.

use super::{Round, STEADY};
use crate::bench::{median, quantile};
use serde::Serialize;

/// Growth of memory that passes.
pub const MOST_GROWTH: f64 = 0.01;

/// Growth of the time of a step that passes.
pub const MOST_SLOWDOWN: f64 = 0.05;

/// The part of the rounds that warms up: lists come to the length they need.
const WARM_UP: f64 = 0.2;

/// Rounds that make a verdict: three of the first against three of the last.
const LEAST_ROUNDS: usize = 12;

/// The first third of the rounds after the warm-up against the last.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// Growth of what is on the heap, as a part of it.
    pub heap_growth: f64,
    /// Growth of what is resident.
    pub resident_growth: f64,
    /// Growth of the processor time of steady steps: of every step the time that a tenth of the rounds stay under, added up. The work is
    /// the same in every round; what most of them take longer is other programs.
    pub slowdown: f64,
    /// Whether all rounds ended in the same state.
    pub is_same: bool,
}

impl Verdict {
    /// Judges the rounds; `None` where there are too few.
    pub fn of(rounds: &[Round]) -> Option<Self> {
        if rounds.len() < LEAST_ROUNDS {
            return None;
        }
        let warm = &rounds[(WARM_UP * rounds.len() as f64) as usize..];
        let third = warm.len() / 3;
        let (first, last) = (&warm[..third], &warm[warm.len() - third..]);
        let growth = |of: fn(&Round) -> u64| {
            let middle = |rounds: &[Round]| median(&rounds.iter().map(|round| of(round) as f64).collect::<Vec<_>>());
            if middle(first) > 0.0 { middle(last) / middle(first) - 1.0 } else { 0.0 }
        };
        let time = |rounds: &[Round]| {
            let times = |i: usize| rounds.iter().map(|round| f64::from(round.step_ms[i])).collect::<Vec<_>>();
            (0..STEADY).map(|i| quantile(&times(i), 0.1)).sum::<f64>()
        };
        Some(Self {
            heap_growth: growth(|round| round.heap),
            resident_growth: growth(|round| round.resident),
            slowdown: time(last) / time(first) - 1.0,
            is_same: rounds.iter().all(|round| round.hash == rounds[0].hash),
        })
    }

    /// Whether nothing was left behind. Less memory or time is no fault.
    pub fn passes(&self) -> bool {
        let Self { heap_growth, resident_growth, slowdown, is_same } = *self;
        is_same && heap_growth <= MOST_GROWTH && resident_growth <= MOST_GROWTH && slowdown <= MOST_SLOWDOWN
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::snapshot::StateHash;

    fn round(heap: u64, ms: f32) -> Round {
        let (steps, tears, resets, is_restart, hash) = (1, 0, 2, false, StateHash(7));
        Round { steps, tears, resets, is_restart, hash, step_ms: [ms; STEADY], heap, resident: 2 * heap }
    }

    #[test]
    fn what_grows_fails_and_what_warms_up_passes() {
        let rounds =
            |heap: fn(u64) -> u64, ms: fn(u64) -> f32| (0..100).map(|i| round(heap(i), ms(i))).collect::<Vec<_>>();
        assert_eq!(Verdict::of(&rounds(|_| 1000, |_| 1.0)[..11]), None);
        let warms_up = Verdict::of(&rounds(|i| 1000 + i.min(15) * 50, |_| 1.0)).unwrap();
        assert!(warms_up.passes() && warms_up.heap_growth == 0.0, "{warms_up:?}");
        // A bookmark of 1 byte per round and thousand: 5 % over the rounds between the thirds.
        assert!(!Verdict::of(&rounds(|i| 1000 + i, |_| 1.0)).unwrap().passes());
        assert!(!Verdict::of(&rounds(|_| 1000, |i| 1.0 + 2e-3 * i as f32)).unwrap().passes());
        // One slow round is another program.
        assert!(Verdict::of(&rounds(|_| 1000, |i| if i == 90 { 50.0 } else { 1.0 })).unwrap().passes());
        let mut parted = rounds(|_| 1000, |_| 1.0);
        parted[3].hash = StateHash(8);
        assert!(!Verdict::of(&parted).unwrap().passes());
    }
}

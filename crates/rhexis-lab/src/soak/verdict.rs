//! Whether a soak has left anything behind: its first rounds after the warm-up against its last.

use super::{Round, STEADY};
use crate::bench::{median, quantile};
use serde::Serialize;

/// Growth of the live bytes on the heap that passes: a list may come to be longer once more.
pub const MOST_GROWTH: f64 = 0.01;

/// Growth of the time of a step that passes.
pub const MOST_SLOWDOWN: f64 = 0.05;

/// The part of the rounds that warms up: lists come to the length they need.
const WARM_UP: f64 = 0.2;

/// Rounds that make a verdict: two to a block after the warm-up.
const LEAST_ROUNDS: usize = 15;

/// Blocks of rounds by whose medians a steady leak is seen. Six rise by chance in one case of 720.
const BLOCKS: usize = 6;

/// A leak's rise from the first block to the last, over the usual change from one round to the next: noise that happens to rise
/// stays below.
const LEAST_RISE: f64 = 3.0;

/// The first third of the rounds after the warm-up against the last.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// Growth of the live bytes on the heap, as a part of them.
    pub heap_growth: f64,
    /// Whether the live bytes rise from every sixth of the rounds to the next, by however little, and by more than they change from
    /// round to round.
    pub is_leaking: bool,
    /// Growth of what is resident, for information: pages that the allocator keeps say nothing of what the program holds.
    pub resident_growth: f64,
    /// Growth of the processor time of steady steps: of every step the time that a tenth of the rounds stay under, added up. The work is
    /// the same in every round; what most of them take longer is other programs.
    pub slowdown: f64,
    /// Whether all rounds ended in the same state.
    pub is_same: bool,
}

impl Verdict {
    /// Judges the rounds; `None` where there are too few, and in a program whose allocator does not count.
    pub fn of(rounds: &[Round]) -> Option<Self> {
        if rounds.len() < LEAST_ROUNDS || rounds.iter().any(|round| round.heap == 0) {
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
            is_leaking: is_leaking(&warm.iter().map(|round| round.heap as f64).collect::<Vec<_>>()),
            resident_growth: growth(|round| round.resident),
            slowdown: time(last) / time(first) - 1.0,
            is_same: rounds.iter().all(|round| round.hash == rounds[0].hash),
        })
    }

    /// Whether nothing was left behind. Less memory or time is no fault.
    pub fn passes(&self) -> bool {
        let Self { heap_growth, is_leaking, slowdown, is_same, .. } = *self;
        is_same && !is_leaking && heap_growth <= MOST_GROWTH && slowdown <= MOST_SLOWDOWN
    }
}

/// Whether live bytes rise steadily over at least a dozen rounds.
fn is_leaking(bytes: &[f64]) -> bool {
    let block = |i: usize| median(&bytes[i * bytes.len() / BLOCKS..(i + 1) * bytes.len() / BLOCKS]);
    let medians: [f64; BLOCKS] = std::array::from_fn(block);
    let changes: Vec<f64> = bytes.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    let rises = medians.windows(2).all(|pair| pair[1] > pair[0]);
    rises && medians[BLOCKS - 1] - medians[0] > LEAST_RISE * median(&changes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stress::Dice;
    use rhexis::snapshot::StateHash;

    fn round(heap: u64, ms: f32) -> Round {
        let (steps, tears, resets, is_restart, hash) = (1, 0, 2, false, StateHash(7));
        Round { steps, tears, resets, is_restart, hash, step_ms: [ms; STEADY], heap, resident: 2 * heap }
    }

    /// Rounds of 10 MB that grow by so many bytes each, with a noise of up to so many.
    fn noisy(count: usize, leak: f64, noise: f64, seed: u64) -> Vec<Round> {
        let mut dice = Dice::new(seed, 0);
        (0..count).map(|i| round((1e7 + leak * i as f64 + dice.between(-noise, noise)) as u64, 1.0)).collect()
    }

    #[test]
    fn a_steady_leak_is_found_however_small() {
        // 64 bytes a round are a hundred-thousandth of the heap over 15 rounds.
        for count in [15, 24, 100, 1000] {
            let verdict = Verdict::of(&noisy(count, 64.0, 0.0, 1)).unwrap();
            assert!(verdict.is_leaking && !verdict.passes(), "{count}: {verdict:?}");
        }
        // A leak of as much per round as the noise, in so many rounds that it shows.
        let found = (0..100).filter(|&seed| !Verdict::of(&noisy(100, 1000.0, 1000.0, seed)).unwrap().passes()).count();
        assert_eq!(found, 100);
        // A program that does not count tells nothing.
        assert_eq!(
            Verdict::of(&noisy(24, 0.0, 0.0, 1).into_iter().map(|r| Round { heap: 0, ..r }).collect::<Vec<_>>()),
            None
        );
    }

    #[test]
    fn noise_is_no_leak() {
        // The first third against the last differs by less than 1 % where single rounds are off by 0.5 %.
        for count in [15, 24, 100] {
            let failed = (0..1000).filter(|&seed| !Verdict::of(&noisy(count, 0.0, 5e4, seed)).unwrap().passes());
            // By chance 1 in 720 rises in six blocks; of those the most stay within the noise.
            assert!(failed.clone().count() <= 1, "{count}: {:?}", failed.collect::<Vec<_>>());
        }
        // One list that comes to be longer once more.
        let once: Vec<Round> = (0..60).map(|i| round(10_000_000 + if i > 30 { 4096 } else { 0 }, 1.0)).collect();
        assert!(Verdict::of(&once).unwrap().passes());
    }

    #[test]
    fn resident_memory_is_shown_and_judges_nothing() {
        let mut rounds = noisy(24, 0.0, 0.0, 1);
        rounds.iter_mut().enumerate().for_each(|(i, round)| round.resident = 20_000_000 + 100_000 * i as u64);
        let verdict = Verdict::of(&rounds).unwrap();
        assert!(verdict.resident_growth > 0.05 && verdict.passes(), "{verdict:?}");
    }

    #[test]
    fn what_grows_fails_and_what_warms_up_passes() {
        let rounds =
            |heap: fn(u64) -> u64, ms: fn(u64) -> f32| (0..100).map(|i| round(heap(i), ms(i))).collect::<Vec<_>>();
        assert_eq!(Verdict::of(&rounds(|_| 1000, |_| 1.0)[..14]), None);
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

//! Motion of closed jaws: the way that they go and the tremor of the hand.
//!
//! Tremor is the deviation of the jaws' place from a smoothed place, as the root mean square over all samples. Samples are taken every 10 ms,
//! between the ends of steps on a straight line. The smoothed place is the mean over ±440 ms with the weights (1 − u²)(3 − 7u²), u the
//! time over 440 ms (a kernel of fourth order after Epanechnikov; Gasser, Müller, Mammitzsch 1985, J R Stat Soc B 47:238). It follows straight
//! ways and constant accelerations, so that only their corners count. Of the amplitude of a sway the deviation has 0.7 % at 0.5 Hz, 9 % at 1, 70 % at 2,
//! and from 4 Hz on within 5 % all of it. Grasps shorter than the window have none, nor have the first and the last 440 ms of a grasp.

use glam::DVec3;
use std::collections::VecDeque;

/// Time between samples \[ms\].
const SAMPLE: f64 = 10.0;

/// Samples on either side of the window's middle; the last ones have no weight and are not kept.
const HALF_WINDOW: usize = 44;

/// Samples with a weight.
const WINDOW: usize = 2 * HALF_WINDOW - 1;

/// Sums over all jaws and grasps of a course.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct MotionSums {
    /// Way gone \[mm\].
    pub path: f64,
    /// Squared deviations \[mm²\], and their number.
    deviations: (f64, u64),
}

impl MotionSums {
    /// Root mean square of the deviations \[mm\]; `None` where no grasp has lasted for a window.
    pub(super) fn tremor(&self) -> Option<f64> {
        let (squares, count) = self.deviations;
        (count > 0).then(|| (squares / count as f64).sqrt())
    }
}

/// Motion of one pair of jaws since they closed.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct ToolMotion {
    /// Time \[ms\] and place \[mm\] at the end of the last step.
    last: (f64, DVec3),
    /// Time of the next sample \[ms\].
    next: f64,
    window: VecDeque<DVec3>,
}

impl ToolMotion {
    /// Jaws that have closed, at the end of a step \[ms\].
    pub(super) fn begin(time: f64, place: DVec3) -> Self {
        Self { last: (time, place), next: time + SAMPLE, window: VecDeque::from([place]) }
    }

    /// Takes in where they are at the end of another step.
    pub(super) fn go_on(&mut self, time: f64, place: DVec3, sums: &mut MotionSums) {
        let (before, from) = std::mem::replace(&mut self.last, (time, place));
        sums.path += from.distance(place);
        if time - before > SAMPLE * WINDOW as f64 || time + SAMPLE <= time {
            // A step longer than the window has no sway to tell of, nor has one at a time whose rounding is longer than a sample.
            self.window = VecDeque::from([place]);
            self.next = time + SAMPLE;
            return;
        }
        while self.next <= time {
            self.window.truncate(WINDOW - 1);
            self.window.push_front(from.lerp(place, (self.next - before) / (time - before)));
            self.next += SAMPLE;
            if self.window.len() == WINDOW {
                let deviation = self.window[HALF_WINDOW - 1] - self.smoothed();
                sums.deviations = (sums.deviations.0 + deviation.length_squared(), sums.deviations.1 + 1);
            }
        }
    }

    fn smoothed(&self) -> DVec3 {
        let weight = |number: usize| {
            let part = (number as f64 + 1.0) / HALF_WINDOW as f64 - 1.0;
            (1.0 - part * part) * (3.0 - 7.0 * part * part)
        };
        let weights: f64 = (0..WINDOW).map(weight).sum();
        self.window.iter().enumerate().map(|(number, &place)| weight(number) * place).sum::<DVec3>() / weights
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};

    /// Sums over a way, from its place over the time \[ms\], with steps of `dt` for five seconds.
    fn along(dt: f64, place: impl Fn(f64) -> DVec3) -> MotionSums {
        let mut sums = MotionSums::default();
        let mut motion = ToolMotion::begin(0.0, place(0.0));
        (1..=(5000.0 / dt) as u32).for_each(|i| motion.go_on(f64::from(i) * dt, place(f64::from(i) * dt), &mut sums));
        sums
    }

    /// RMS over amplitude/√2 of a sway with a frequency \[Hz\].
    fn gain(dt: f64, frequency: f64) -> f64 {
        let sway = |time: f64| 0.02 * (TAU * frequency * 1e-3 * time).sin() * DVec3::new(0.6, 0.0, 0.8);
        along(dt, sway).tremor().unwrap() * 2_f64.sqrt() / 0.02
    }

    #[test]
    fn the_gain_is_that_of_the_kernel() {
        for frequency in [0.5, 1.0, 2.0, 3.0, 4.0, 7.0, 10.0, 13.0] {
            let w = PI * frequency * 0.88;
            let (s, c) = w.sin_cos();
            let smoothed = 7.5 * c / w.powi(2) - 60.0 * s / w.powi(3) - 157.5 * c / w.powi(4) + 157.5 * s / w.powi(5);
            // Sums of 88 samples in place of integrals, and samples that do not fill whole periods.
            let found = gain(5.0, frequency);
            assert!((found - (1.0 - smoothed)).abs() < 0.01, "{frequency} Hz: {found} {}", 1.0 - smoothed);
        }
    }

    #[test]
    fn tremor_counts_and_the_way_of_the_hand_does_not() {
        assert!((gain(10.0, 10.0) - 1.0).abs() < 0.05);
        assert!(gain(10.0, 0.5) < 0.01);
        // Chords of 20 ms make a sway of 10 Hz smaller, by 1 − cos(2π·10·0.01) in the middle of each.
        assert!((0.8..1.0).contains(&gain(20.0, 10.0)));
        let straight = along(10.0, |time| DVec3::new(1e-3 * time, 2.0, -5e-4 * time));
        assert!(straight.tremor().unwrap() < 1e-12);
        // A hand on a circle of 2.3 mm, 210° in 4 s: an acceleration of 1.9 mm/s² whose direction turns.
        let round = along(10.0, |time| {
            let angle = 210_f64.to_radians() * time / 4000.0;
            2.3 * DVec3::new(angle.cos(), angle.sin(), 0.0)
        });
        assert!(round.tremor().unwrap() < 1e-3, "{:?}", round.tremor());
    }

    #[test]
    fn the_way_is_the_length_of_its_chords() {
        let straight = along(10.0, |time| DVec3::new(3e-3 * time, 4e-3 * time, 0.0));
        assert!((straight.path - 25.0).abs() < 1e-9);
        assert_eq!(along(10.0, |_| DVec3::X).path, 0.0);
    }

    #[test]
    fn short_grasps_and_long_steps_have_no_tremor() {
        let mut sums = MotionSums::default();
        let mut motion = ToolMotion::begin(0.0, DVec3::ZERO);
        for step in 1..80_u32 {
            motion.go_on(10.0 * f64::from(step), DVec3::X * f64::from(step % 2), &mut sums);
        }
        assert_eq!(sums.tremor(), None);
        // One of a day, as of a static run, takes no time and restarts the window.
        motion.go_on(1e8, DVec3::ZERO, &mut sums);
        assert_eq!((sums.tremor(), motion.window.len()), (None, 1));
        for time in [1e20, 1e20, f64::MAX] {
            motion.go_on(time, DVec3::ZERO, &mut sums);
        }
        assert_eq!(sums.tremor(), None);
    }
}

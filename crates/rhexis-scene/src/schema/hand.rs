//! A hand that pulls, trembles and is never quite still, as a scene file writes it.

use rhexis::components::Curve;
use rhexis::math::elementary;
use serde::Deserialize;
use std::f64::consts::TAU;

/// The most points of a hand's path.
const MOST_POINTS: f64 = 1e6;

/// `curve = { hand = { … } }`: a ramp, a tremor and noise, one value per `every`, linear between; afterwards the last value is
/// held. The same numbers on every machine.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HandSpec {
    /// Where the ramp ends: a multiple of the hold's `move`.
    pub to: f64,
    /// Duration of the ramp from zero \[ms\], > 0.
    pub within: f64,
    /// Amplitude of the tremor, a sine. Default 0.
    #[serde(default)]
    pub tremor: f64,
    /// Period of the tremor \[ms\], > 0. Default 100: 10 Hz, a surgeon's physiological tremor.
    #[serde(default = "period")]
    pub period: f64,
    /// Largest value of the noise, evenly distributed, new at every point. Default 0.
    #[serde(default)]
    pub noise: f64,
    /// Seed of the noise. Default 7.
    #[serde(default = "seed")]
    pub seed: u64,
    /// Time between points \[ms\], > 0. Default 1.
    #[serde(default = "every")]
    pub every: f64,
    /// How long the hand moves \[ms\].
    pub duration: f64,
}

fn period() -> f64 {
    100.0
}

fn seed() -> u64 {
    7
}

fn every() -> f64 {
    1.0
}

impl HandSpec {
    /// The curve; it begins at zero.
    ///
    /// # Errors
    /// For a time that is not positive, for too many points, and for a number that is not finite.
    pub fn curve(&self) -> Result<Curve, String> {
        let &Self { to, within, tremor, period, noise, every, duration, .. } = self;
        for (name, value) in [("within", within), ("period", period), ("every", every), ("duration", duration)] {
            if !(value > 0.0) {
                return Err(format!("the hand's `{name}` is {value}; give a time above zero [ms]"));
            }
        }
        let count = (duration / every).ceil();
        if !(count <= MOST_POINTS) {
            return Err(format!("the hand would have more than {MOST_POINTS} points; give a larger `every`"));
        }
        let mut state = self.seed;
        let point = |i: u32| {
            let t = f64::from(i) * every;
            let pull = to * (t / within).min(1.0) + tremor * elementary::sin(TAU * t / period);
            (t, if i == 0 { 0.0 } else { pull + noise * symmetric(&mut state) })
        };
        Curve::new((0..=count as u32).map(point).collect()).map_err(|bad| bad.to_string())
    }
}

/// The next number in [-1, 1) of SplitMix64 (Steele, Lea, Flood 2014).
fn symmetric(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    const HAND: HandSpec = HandSpec {
        to: 1.5,
        within: 100.0,
        tremor: 0.3,
        period: 100.0,
        noise: 0.01,
        seed: 7,
        every: 1.0,
        duration: 200.0,
    };

    #[test]
    fn a_hand_ramps_and_trembles_within_its_noise() {
        let curve = HAND.curve().unwrap();
        assert_eq!((curve.at(0.0), curve.points().len()), (0.0, 201));
        for (t, wanted) in [(25.0, 0.375 + 0.3), (50.0, 0.75), (100.0, 1.5), (125.0, 1.8), (175.0, 1.2)] {
            assert!((curve.at(t) - wanted).abs() <= 0.01, "{t}: {}", curve.at(t));
        }
        assert_ne!(curve, HandSpec { seed: 8, ..HAND }.curve().unwrap());
    }

    #[test]
    fn a_hand_without_time_is_refused() {
        for bad in
            [HandSpec { within: 0.0, ..HAND }, HandSpec { every: -1.0, ..HAND }, HandSpec { every: 1e-9, ..HAND }]
        {
            assert!(bad.curve().is_err());
        }
    }
}

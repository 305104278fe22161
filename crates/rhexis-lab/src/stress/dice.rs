//! Random choices that depend on the seed alone.

use glam::{DQuat, DVec3};
use rhexis::math::elementary;
use std::f64::consts::TAU;

/// SplitMix64 (Steele, Lea, Flood 2014).
pub(crate) struct Dice(u64);

impl Dice {
    /// Those of a case of a seed: cases are independent of each other.
    pub(crate) fn new(seed: u64, case: u64) -> Self {
        let mut dice = Self(seed);
        let start = dice.bits();
        let mut dice = Self(start ^ case.wrapping_mul(0xd134_2543_de82_ef95));
        dice.bits();
        dice
    }

    /// Others that start from these: what they say changes nothing of what these will.
    pub(crate) fn aside(&self) -> Self {
        Self(self.0 ^ 0x5851_f42d_4c95_7f2d)
    }

    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform from `low` to `high`.
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * ((self.bits() >> 11) as f64 / (1_u64 << 53) as f64)
    }

    /// 10 to the power of what is uniform from `low` to `high`.
    pub(crate) fn decades(&mut self, low: f64, high: f64) -> f64 {
        elementary::pow(10.0, self.between(low, high))
    }

    /// Below `count`, which is above zero.
    pub(crate) fn below(&mut self, count: usize) -> usize {
        (self.bits() % count as u64) as usize
    }

    /// True so often.
    pub(crate) fn chance(&mut self, part: f64) -> bool {
        self.between(0.0, 1.0) < part
    }

    /// In a cube from −1 to 1.
    pub(crate) fn point(&mut self) -> DVec3 {
        DVec3::from_array([(); 3].map(|()| self.between(-1.0, 1.0)))
    }

    /// Of length 1.
    pub(crate) fn direction(&mut self) -> DVec3 {
        self.point().normalize_or(DVec3::X)
    }

    /// Any rotation; about z in a plane.
    pub(crate) fn rotation(&mut self, is_planar: bool) -> DQuat {
        let axis = if is_planar { DVec3::Z } else { self.direction() };
        elementary::rotation(axis, self.between(0.0, TAU))
    }
}

//! Stand-in for a body's Cholesky factor without the feature `direct`: there never is one.

use super::Operator;
use crate::components::FreeAxes;
use glam::DVec3;

/// No factor. *State.*
#[derive(Debug, Default)]
pub struct Factor {}

/// Nothing to keep.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct FactorState {}

/// Why there is no factor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoFactor {
    /// The operator is not positive definite.
    Indefinite,
    /// The feature is missing.
    Unavailable,
}

impl Factor {
    /// Nothing.
    pub fn state(&self) -> FactorState {
        FactorState {}
    }

    /// No factor.
    ///
    /// # Errors
    /// Never.
    pub fn of_state(_state: &FactorState) -> Result<Self, NoFactor> {
        Ok(Self {})
    }

    /// False.
    pub fn is_of(&self, _corners: &[[u32; 3]], _free: &FreeAxes) -> bool {
        false
    }

    /// Does nothing.
    ///
    /// # Errors
    /// Always: there is none.
    pub fn renew(&mut self, _operator: &Operator, _free: &FreeAxes) -> Result<(), NoFactor> {
        Err(NoFactor::Unavailable)
    }

    /// Does nothing.
    ///
    /// # Errors
    /// Always: there is none.
    pub fn renew_for_next(&mut self, _operator: &Operator, _free: &FreeAxes) -> Result<(), NoFactor> {
        Err(NoFactor::Unavailable)
    }

    /// Zero.
    pub fn take_fallbacks(&mut self) -> u32 {
        0
    }

    /// Nothing.
    pub fn note(&mut self, _iterations: u32) {}

    /// Zero.
    pub fn take_work(&mut self) -> u32 {
        0
    }

    /// False.
    pub fn take_need(&mut self) -> bool {
        false
    }

    /// Nothing.
    pub fn begin(&mut self, _operator: &Operator, _free: &FreeAxes) {}

    /// Zero.
    pub fn apply(&mut self, _r: &[DVec3], _free: &FreeAxes, z: &mut [DVec3], _partials: &mut Vec<f64>) -> f64 {
        z.fill(DVec3::ZERO);
        0.0
    }
}

#[cfg(feature = "snapshot")]
impl FactorState {
    /// True.
    pub fn is_sound(&self) -> bool {
        true
    }
}

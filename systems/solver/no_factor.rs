//! Stand-in for a body's Cholesky factor without the feature `direct`: there never is one.

use super::{MixedPreconditioner, Operator};
use crate::components::FreeAxes;
use crate::storage::EditRecord;
use glam::{DVec3, Vec4};

/// No factor.
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
    pub fn factor_now(&mut self, _operator: &Operator, _free: &FreeAxes, _without: u32) -> Result<(), NoFactor> {
        Err(NoFactor::Unavailable)
    }

    /// False.
    pub fn is_factored_now(&mut self) -> bool {
        false
    }

    /// False.
    pub fn is_ready(&mut self, _operator: &Operator, _free: &FreeAxes) -> bool {
        false
    }

    /// None.
    pub fn most(&self, _inner: Option<MixedPreconditioner>) -> u32 {
        0
    }

    /// Nothing.
    pub fn has_served(&mut self, _iterations: u32, _most: u32, _operator: &Operator, _free: &FreeAxes) {}

    /// Nothing.
    pub fn discard(&mut self) {}

    /// Nothing.
    pub fn has_paused(&mut self, _iterations: u32) {}

    /// Nothing.
    pub fn follow(&mut self, _record: &EditRecord) {}

    /// Nothing.
    pub fn begin(&mut self, _operator: &Operator, _free: &FreeAxes) {}

    /// Zero.
    pub fn apply(&mut self, _r: &[DVec3], _free: &FreeAxes, z: &mut [DVec3], _partials: &mut Vec<f64>) -> f64 {
        z.fill(DVec3::ZERO);
        0.0
    }

    /// Zero.
    pub fn forward_sweep(&mut self, _xr: &[[Vec4; 2]], _row: &[u32]) -> f64 {
        0.0
    }

    /// Zero.
    pub fn backward_sweep(&mut self, _xr: &[[Vec4; 2]], _row: &[u32], z: &mut [Vec4]) {
        z.fill(Vec4::ZERO);
    }
}

#[cfg(feature = "snapshot")]
impl FactorState {
    /// True.
    pub fn is_sound(&self, _vertex_count: usize) -> bool {
        true
    }
}

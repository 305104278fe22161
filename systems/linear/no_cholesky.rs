//! What stands in for the sparse Cholesky factor without the feature `direct`: there never is one.

use super::Operator;
use glam::DVec3;

/// No factor.
#[derive(Debug, Default)]
pub struct Factor;

/// Why there is no factor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoFactor {
    /// The operator is not positive definite.
    Indefinite,
    /// The feature is missing.
    Unavailable,
}

impl Factor {
    /// False.
    pub fn fits(&self, _corners: &[[u32; 3]], _free: &[DVec3]) -> bool {
        false
    }

    /// Does nothing.
    ///
    /// # Errors
    /// Always: there is none.
    pub fn renew(&mut self, _operator: &Operator, _free: &[DVec3]) -> Result<(), NoFactor> {
        Err(NoFactor::Unavailable)
    }

    /// Zero.
    pub fn solve(&mut self, _residual: &[DVec3]) -> impl Fn(usize) -> DVec3 + Sync {
        |_| DVec3::ZERO
    }
}

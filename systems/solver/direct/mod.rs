//! A body's Cholesky factor through the solves.
//!
//! A factor is as good as the body is near the state it was made at. It is turned with the tissue, and renewed in the solve in which
//! it no longer serves, or after an edit of the mesh.

mod cholesky;
mod dissect;
mod operator_copy;
mod panels;
mod pattern;
mod rotation_warp;
mod state;

use super::{Operator, scale_to_single};
use crate::components::FreeAxes;
use crate::systems::{parallel, work};
use cholesky::Cholesky;
pub(super) use cholesky::NoFactor;
use glam::DVec3;
use operator_copy::OperatorCopy;
use rotation_warp::RotationWarp;
pub use state::FactorState;

/// Solves that begin with a factor after one that failed without; then solves are as before. Tissue that was crushed has
/// come free by then, or costs one such solve more in so many.
const NEEDED: u16 = 16;

/// A body's factor. *State*: its matrix is saved, and how long it has served.
#[derive(Default)]
pub struct Factor {
    current: Option<Box<InUse>>,
    /// Solves that still begin with it although another preconditioner is preferred.
    needed: u16,
    /// Fallback factors made since they were last taken into account.
    fallbacks: u16,
    /// Work beside the iterations since it was last taken into account.
    work: u32,
}

struct InUse {
    cholesky: Cholesky,
    rotation_warp: RotationWarp,
}

impl Factor {
    /// Whether there is a factor of an operator with these triangles and free axes.
    pub fn is_of(&self, corners: &[[u32; 3]], free: &FreeAxes) -> bool {
        self.current.as_ref().is_some_and(|current| current.cholesky.fits(corners, free))
    }

    /// Factors the operator at its state.
    ///
    /// # Errors
    /// Where the operator is not positive definite, or there is no memory; there is then no factor.
    pub fn renew(&mut self, operator: &Operator, free: &FreeAxes) -> Result<(), NoFactor> {
        let has_new_pattern = !self.is_of(&operator.triangles.corners, free);
        self.work = self.work.saturating_add(work::FACTOR * (1 + u32::from(has_new_pattern)));
        let before = self.current.take().map(|current| current.cholesky);
        let cholesky = Cholesky::new(&OperatorCopy::new(operator, free), before);
        let cholesky = cholesky.inspect_err(|_| self.needed = 0)?;
        self.current = Some(Box::new(InUse { cholesky, rotation_warp: RotationWarp::new(operator) }));
        Ok(())
    }

    /// Factors the operator at its state for a solve that has failed otherwise, and for the next ones.
    ///
    /// # Errors
    /// As [`renew`](Self::renew).
    pub fn renew_for_next(&mut self, operator: &Operator, free: &FreeAxes) -> Result<(), NoFactor> {
        self.renew(operator, free)?;
        self.needed = NEEDED;
        self.fallbacks = self.fallbacks.saturating_add(1);
        Ok(())
    }

    /// Number of factors made [for solves that have failed otherwise](Self::renew_for_next) since the last call.
    pub fn take_fallbacks(&mut self) -> u32 {
        u32::from(std::mem::take(&mut self.fallbacks))
    }

    /// Counts iterations with the factor.
    pub fn note(&mut self, iterations: u32) {
        self.work = self.work.saturating_add(iterations.saturating_mul(work::FACTOR_ITERATION - 1));
    }

    /// Work of factors beside the iterations of solves since the last call.
    pub fn take_work(&mut self) -> u32 {
        std::mem::take(&mut self.work)
    }

    /// Counts down the solves after a failure without a factor; returns whether this one begins with a factor made on the spot.
    pub fn take_need(&mut self) -> bool {
        let is_needed = self.needed > 0;
        self.needed = self.needed.saturating_sub(1);
        is_needed
    }

    /// Before solves with the factor at a state: how far the tissue has turned.
    pub fn begin(&mut self, operator: &Operator, free: &FreeAxes) {
        if let Some(InUse { rotation_warp, .. }) = self.current.as_deref_mut() {
            rotation_warp.update(operator, free);
        }
    }

    /// The factor's answer z \[mm\] to a residual r \[N\], zero along prescribed axes (`free` 0); returns r·z. Without a
    /// factor all of it is zero.
    pub fn apply(&mut self, r: &[DVec3], free: &FreeAxes, z: &mut [DVec3], partials: &mut Vec<f64>) -> f64 {
        let Some(InUse { cholesky, rotation_warp }) = self.current.as_deref_mut() else {
            z.fill(DVec3::ZERO);
            return 0.0;
        };
        let (scale, turns) = (scale_to_single(r), rotation_warp.turns());
        match turns.is_empty() {
            true => r.iter().enumerate().for_each(|(v, r)| cholesky.put(v, *r * scale)),
            false => turns.iter().enumerate().for_each(|(v, turn)| cholesky.put(v, turn.transpose() * (r[v] * scale))),
        }
        cholesky.forward_sweep();
        cholesky.backward_sweep();
        for (v, z) in z.iter_mut().enumerate() {
            let answer = cholesky.part(v);
            *z = turns.get(v).map_or(answer, |turn| *turn * answer) * free[v] / scale;
        }
        parallel::sum_rows(z, partials, |v, z| r[v].dot(*z))
    }
}

impl std::fmt::Debug for Factor {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Factor").field("is_made", &self.current.is_some()).finish_non_exhaustive()
    }
}

//! Preconditioned conjugate gradients in single precision, scalar products in double, passes over the vectors fused with the
//! preconditioner's.

use super::empty;
use super::matrix::Matrix;
use super::partition::Partition;
use crate::systems::solver::CgError;
use crate::systems::solver::estimate::{EnergyError, Limits};
use glam::{DVec2, Vec4};

/// The vectors, in the order of the preconditioner.
#[derive(Debug, Default)]
pub(super) struct Vectors {
    /// Answer and residual: they change in one pass.
    pub xr: Vec<[Vec4; 2]>,
    /// Search direction.
    pub p: Vec<Vec4>,
    /// Operator times direction.
    pub q: Vec<Vec4>,
    /// Preconditioned residual.
    pub z: Vec<Vec4>,
    /// Sums per chunk of rows.
    pub partials: Vec<f64>,
    /// Sums of r·r and r·z per chunk of rows.
    pub pairs: Vec<DVec2>,
}

/// A preconditioner M, with the vector passes of an iteration around it.
pub(super) trait Precondition {
    /// A step length under this, which is no less than the inverse of the largest eigenvalue of M⁻¹·A, shows that M is broken.
    const LEAST_STEP: f64 = 0.0;

    /// x += α·p, r −= α·q and as much of z = M⁻¹·r as it takes to know r·z; returns r·r and r·z.
    fn descend(&mut self, alpha: f32, vectors: &mut Vectors) -> DVec2;

    /// The rest of z = M⁻¹·r, then p = z + β·p.
    fn ascend(&mut self, beta: f32, vectors: &mut Vectors);
}

/// How far the iterations have come.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reached {
    /// Iterations done.
    pub iterations: u32,
    /// Squared norm of the residual.
    pub residual_sq: f64,
    /// Squared energy norm of the error, as estimated.
    pub energy: f64,
    /// Whether time was up.
    pub is_late: bool,
    /// Whether the preconditioner is broken.
    pub is_broken: bool,
}

/// Solves A·x = r for the `r` in `vectors`, whose `x` is zero, up to the limits.
///
/// # Errors
/// See [`CgError`].
pub(super) fn solve<P: Precondition>(
    matrix: &mut Matrix,
    partition: &Partition,
    preconditioner: &mut P,
    vectors: &mut Vectors,
    limits: &Limits,
) -> Result<Reached, CgError> {
    let n = vectors.xr.len();
    for zero in [&mut vectors.p, &mut vectors.q, &mut vectors.z] {
        empty(zero, n);
        zero.resize(n, Vec4::ZERO);
    }
    let DVec2 { x: mut residual_sq, y: mut rz } = preconditioner.descend(0.0, vectors);
    let (mut iterations, mut error, mut beta) = (0, EnergyError::new(rz), 0.0);
    let (mut is_late, mut is_broken) = (false, false);
    while !limits.allow_stop(residual_sq, &error) && iterations < limits.iterations && !is_late {
        preconditioner.ascend(beta, vectors);
        let curvature = matrix.apply(partition, &vectors.p, &mut vectors.q, &mut vectors.partials);
        if !(curvature.is_finite() && rz.is_finite()) {
            return Err(CgError::NotFinite { iteration: iterations });
        }
        if curvature <= 0.0 {
            return Err(CgError::Indefinite { iteration: iterations });
        }
        let (before, alpha) = (rz, rz / curvature);
        is_broken = alpha < P::LEAST_STEP;
        if is_broken {
            break;
        }
        DVec2 { x: residual_sq, y: rz } = preconditioner.descend(alpha as f32, vectors);
        beta = (rz / before) as f32;
        error.advance(alpha, rz);
        iterations += 1;
        is_late = limits.is_late(iterations);
    }
    Ok(Reached { iterations, residual_sq, energy: error.squared(), is_late, is_broken })
}

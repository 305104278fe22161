//! The recurrence of preconditioned conjugate gradients (Hestenes, Stiefel 1952), once for every precision and kind of constraint.

use super::CgError;
use super::cg::CgInfo;
use super::estimate::{EnergyError, Limits};
use glam::DVec2;

/// Vectors of an iteration: answer x, residual r, direction p, product q = A·p and preconditioned residual z = M⁻¹·r.
pub(super) trait Vectors {
    /// Step length under which the preconditioner counts as broken.
    fn least_step(&self) -> f64 {
        f64::NEG_INFINITY
    }

    /// p = z + β·p, which is z where β is zero.
    fn next_direction(&mut self, beta: f64);

    /// q = A·p. Returns p·q.
    fn multiply(&mut self) -> f64;

    /// Whether a non-positive curvature p·q is rounding at convergence, not indefiniteness.
    fn is_at_end(&mut self, curvature: f64, rz: f64) -> bool;

    /// x += α·p, r −= α·q, z = M⁻¹·r. Returns r·r and r·z.
    fn advance(&mut self, alpha: f64) -> DVec2;
}

/// Result of the iterations.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reached {
    /// Iterations done.
    pub iterations: u32,
    /// Squared norm of the residual.
    pub residual_sq: f64,
    /// Squared energy norm of the error, as estimated.
    pub energy: f64,
    /// Whether the tolerances were reached.
    pub is_solved: bool,
    /// Whether time was up.
    pub is_late: bool,
    /// Whether the preconditioner is broken.
    pub is_broken: bool,
}

impl Reached {
    /// The solve's report, with the residual relative to a squared reference norm: the step's largest right-hand side.
    pub(super) fn beside(&self, reference_sq: f64) -> CgInfo {
        let &Self { iterations, residual_sq, energy: error_energy, is_solved, is_late, .. } = self;
        let relative_residual = if reference_sq > 0.0 { (residual_sq / reference_sq).sqrt() } else { 0.0 };
        CgInfo { iterations, relative_residual, error_energy, is_solved, is_late }
    }
}

/// Iterates from r·r and r·z of the first residual up to the limits.
///
/// # Errors
/// See [`CgError`].
pub(super) fn iterate(
    vectors: &mut impl Vectors,
    DVec2 { x: mut residual_sq, y: mut rz }: DVec2,
    limits: &Limits,
) -> Result<Reached, CgError> {
    let (mut iterations, mut error, mut beta) = (0, EnergyError::new(rz), 0.0);
    let (mut is_late, mut is_broken) = (false, false);
    while !limits.allow_stop(residual_sq, &error) && iterations < limits.iterations && !is_late {
        vectors.next_direction(beta);
        let curvature = vectors.multiply();
        if !(curvature.is_finite() && rz.is_finite()) {
            return Err(CgError::NotFinite { iteration: iterations });
        }
        if curvature <= 0.0 {
            if vectors.is_at_end(curvature, rz) {
                break;
            }
            return Err(CgError::Indefinite { iteration: iterations });
        }
        let (before, alpha) = (rz, rz / curvature);
        is_broken = alpha < vectors.least_step();
        if is_broken {
            break;
        }
        DVec2 { x: residual_sq, y: rz } = vectors.advance(alpha);
        beta = rz / before;
        error.advance(alpha, rz);
        iterations += 1;
        is_late = limits.is_late(iterations);
    }
    let is_solved = limits.allow_stop(residual_sq, &error);
    Ok(Reached { iterations, residual_sq, energy: error.squared(), is_solved, is_late, is_broken })
}

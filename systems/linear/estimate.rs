//! How far conjugate gradients are from the answer, in the norm that a tissue feels.
//!
//! The residual misleads: at the same residual the error of the stress grows with the mesh. The squared energy norm of the
//! error, ‖x − x_k‖²_A = Σ_{j≥k} α_j·(r_j·z_j) (Hestenes, Stiefel 1952), is twice the elastic energy of the strains that are still
//! missing (and the inertia and drag of the motion), so its root over that of twice the stored energy is the relative error
//! of the stress, in the mean that the compliance weights. What later iterations will add is not known yet; but r_k·z_k is the same
//! error measured with the preconditioner, and how the two compare is seen on the iterations done: Σ_{j≤i<k} α_i·(r_i·z_i)
//! over r_j·z_j, the larger of that for the first residual and for one a few iterations ago (Strakoš, Tichý 2002 justify
//! such sums in floating point).

use crate::settings::LinearParams;
use std::time::Instant;

/// When a solve may stop, and when it must.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Squared norm of the residual \[N²\] from which on it may.
    pub residual_sq: f64,
    /// Squared energy norm of the error \[mJ\] from which on it may.
    pub energy: f64,
    /// Squared norm of the residual \[N²\] that is small enough whatever the error: what is stored may be next to nothing.
    pub least_sq: f64,
    /// Iterations at the most.
    pub iterations: u32,
    /// When it must, however far it has come.
    pub end: Option<Instant>,
}

/// A relative residual this far under its tolerance is small enough,
const FAR_BELOW: f64 = 1e-3;
/// and so is this, where the tolerance allows it.
const SMALL: f64 = 1e-6;

impl Limits {
    /// The limits of a solve that begins now. `reference_sq` is the squared norm of its right-hand side \[N²\], `stored` twice the
    /// energy in the body \[mJ\].
    pub fn new(params: &LinearParams, reference_sq: f64, stored: f64) -> Self {
        Self {
            residual_sq: params.tolerance * params.tolerance * reference_sq,
            energy: if params.stress_tolerance.is_finite() {
                params.stress_tolerance.powi(2) * stored
            } else {
                f64::INFINITY
            },
            iterations: params.iterations,
            least_sq: (FAR_BELOW * params.tolerance).max(SMALL.min(params.tolerance)).powi(2) * reference_sq,
            end: params.time.map(|time| Instant::now() + time),
        }
    }

    /// The limits where residual and error are measured in units of `norm`.
    pub fn in_units_of(self, norm: f64) -> Self {
        let norm_sq = norm * norm;
        let Self { residual_sq, energy, least_sq, .. } = self;
        Self { residual_sq: residual_sq / norm_sq, energy: energy / norm_sq, least_sq: least_sq / norm_sq, ..self }
    }

    /// Whether it may stop.
    pub fn are_met(&self, residual_sq: f64, energy: f64) -> bool {
        residual_sq <= self.residual_sq && (energy <= self.energy || residual_sq <= self.least_sq)
    }

    /// Whether time is up.
    pub fn is_late(&self) -> bool {
        self.end.is_some_and(|end| Instant::now() >= end)
    }
}

/// Iterations back to the later of the two comparisons.
const BACK: usize = 4;

/// The squared energy norm of the error through the iterations of a solve \[mJ\].
#[derive(Clone, Copy, Debug)]
pub struct EnergyError {
    /// r·z now.
    rz: f64,
    first_rz: f64,
    /// Σ α·(r·z) so far.
    sum: f64,
    /// That sum and r·z at the last residuals.
    last: [(f64, f64); BACK],
    count: usize,
}

impl EnergyError {
    /// Before the first iteration, with r·z of the first residual.
    pub fn new(rz: f64) -> Self {
        Self { rz, first_rz: rz, sum: 0.0, last: [(0.0, rz); BACK], count: 0 }
    }

    /// After an iteration of step length `alpha`, with r·z of the new residual.
    pub fn advance(&mut self, alpha: f64, rz: f64) {
        self.sum += alpha * self.rz;
        self.count += 1;
        self.rz = rz;
        self.last[self.count % BACK] = (self.sum, rz);
    }

    /// The estimate; from the second iteration on it is more than a guess.
    pub fn squared(&self) -> f64 {
        // The oldest that is kept.
        let (sum, rz) = if self.count < BACK { (0.0, self.first_rz) } else { self.last[(self.count + 1) % BACK] };
        let ratio = (self.sum / self.first_rz).max((self.sum - sum) / rz).max(1.0);
        // A residual of zero leaves no error, whatever its ratio.
        if self.rz > 0.0 { self.rz * ratio } else { 0.0 }
    }
}

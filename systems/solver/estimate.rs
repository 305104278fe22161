//! How far conjugate gradients are from the answer, in the norm that a tissue feels.
//!
//! The residual misleads: at the same residual the error of the stress grows with the mesh. The squared energy norm of the error is
//! ‖x − x_k‖²_A = Σ_{j≥k} α_j·(r_j·z_j) (Hestenes, Stiefel 1952). It is twice the elastic energy of the strains that are still
//! missing (and the inertia and drag of the motion). So its root over that of twice the stored energy is the relative error of the
//! stress, in the mean that the compliance weights.
//!
//! The increments of later iterations are not known yet. But r_k·z_k is the same error measured with the preconditioner, and the
//! iterations done show how the two compare. The ratio is Σ_{j≤i<k} α_i·(r_i·z_i) over r_j·z_j, the larger of that for the first
//! residual and for one a few iterations ago. Strakoš, Tichý 2002 justify such sums in floating point.

use crate::clock::Moment;
use crate::components::Stops;
use crate::math::elementary;
use crate::settings::LinearParams;

/// Stopping limits of a linear solve.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Squared residual norm \[N²\] at which the solve may stop, if the energy limit is met too.
    pub residual_sq: f64,
    /// Squared energy norm of the error \[mJ\] at which the solve may stop, if the residual limit is met too.
    pub energy: f64,
    /// Squared residual norm \[N²\] that suffices whatever the error estimate, for bodies that store almost no energy.
    pub least_sq: f64,
    /// Squared energy norm of the error \[mJ\] that meets the position tolerance, whatever the residual; zero without one.
    pub near: f64,
    /// Iteration limit.
    pub iterations: u32,
    /// Deadline of the solve.
    pub end: Option<Moment>,
    /// Iteration at which the solve of a repeated step stops, in place of the deadline.
    pub stop: Option<u32>,
}

/// Relative residual, over the stress tolerance, that suffices by itself.
const FAR_BELOW: f64 = 1e-3;

/// Smallest ratio of the residual after one round to that before it that is asked for; below a tenth of it single precision only adds noise.
const MOST_REDUCTION: f64 = 1e-5;

/// Largest ratio of remaining to removed squared error at which the position tolerance may stop a solve.
const PROGRESS: f64 = 1.0;

/// A round aims a little below the tolerance, lest the last digits of single precision ask for another.
const AIM: f64 = 0.95;

impl Limits {
    /// The limits of a solve that begins now. `reference_sq` is the squared norm \[N²\] that residuals are measured by, `twice_stored` twice the
    /// energy in the body \[mJ\] and `near` the energy of the position error that is allowed.
    pub(super) fn new(params: &LinearParams, reference_sq: f64, [twice_stored, near]: [f64; 2]) -> Self {
        Self {
            near,
            residual_sq: params.tolerance * params.tolerance * reference_sq,
            energy: if params.stress_tolerance.is_finite() {
                params.stress_tolerance * params.stress_tolerance * twice_stored
            } else {
                f64::INFINITY
            },
            iterations: params.iterations,
            least_sq: elementary::powi((FAR_BELOW * params.stress_tolerance).min(params.tolerance), 2) * reference_sq,
            end: params.time.and_then(|time| Moment::now().after(time)),
            stop: None,
        }
    }

    /// Limits of a solve that stops by the squared energy norm of its error \[mJ\] alone, or after `iterations`.
    pub(super) fn by_energy(energy: f64, iterations: u32) -> Self {
        let residual_sq = f64::INFINITY;
        Self { residual_sq, energy, least_sq: 0.0, near: 0.0, iterations, end: None, stop: None }
    }

    /// Limits of one round in single precision, in units of the residual's norm: a little below the tolerance asked for, but no further
    /// than single precision can go.
    pub(super) fn of_round(self, norm: f64, iterations: u32) -> Self {
        let norm_sq = norm * norm;
        let aim = |residual_sq: f64| (AIM * AIM * residual_sq / norm_sq).max(MOST_REDUCTION * MOST_REDUCTION);
        let (residual_sq, least_sq) = (aim(self.residual_sq), aim(self.least_sq));
        Self { residual_sq, least_sq, energy: self.energy / norm_sq, near: self.near / norm_sq, iterations, ..self }
    }

    /// The limits of a round of iterations that stops where it stopped before, where that is being repeated.
    pub(super) fn repeating(self, stops: &mut Stops) -> Self {
        if self.end.is_none() { self } else { Self { stop: stops.next_round(), ..self } }
    }

    /// Whether residual and energy error meet the limits.
    pub(super) fn are_met(&self, residual_sq: f64, energy: f64) -> bool {
        residual_sq <= self.residual_sq && (energy <= self.energy || residual_sq <= self.least_sq)
    }

    /// Whether a finished answer meets the limits, the position tolerance included.
    pub(super) fn are_met_at_end(&self, residual_sq: f64, energy: f64) -> bool {
        self.are_met(residual_sq, energy) || self.is_near(energy)
    }

    /// Whether a running solve may stop. The position tolerance counts only after a few iterations that removed half of the squared error;
    /// otherwise slow vertices would never move.
    pub(super) fn allow_stop(&self, residual_sq: f64, error: &EnergyError) -> bool {
        let energy = error.squared();
        self.are_met(residual_sq, energy)
            || error.count >= BACK && energy <= PROGRESS * error.sum && self.is_near(energy)
    }

    /// Whether an error of this squared energy norm \[mJ\] leaves positions as near as is asked.
    fn is_near(&self, energy: f64) -> bool {
        self.near > 0.0 && energy <= self.near
    }

    /// Whether time is up after so many iterations.
    pub(super) fn is_late(&self, iterations: u32) -> bool {
        match self.stop {
            Some(stop) => iterations >= stop,
            None => self.end.is_some_and(|end| Moment::now() >= end),
        }
    }
}

/// Residuals kept for the later of the two comparisons, the present one included.
const BACK: usize = 4;

/// The squared energy norm of the error through the iterations of a solve \[mJ\].
#[derive(Clone, Copy, Debug)]
pub(super) struct EnergyError {
    /// r·z now.
    rz: f64,
    first_rz: f64,
    /// Σ α·(r·z) so far.
    sum: f64,
    /// Σ α·(r·z) and r·z at each of the last residuals.
    last: [(f64, f64); BACK],
    count: usize,
}

impl EnergyError {
    /// Before the first iteration, with r·z of the first residual.
    pub(super) fn new(rz: f64) -> Self {
        Self { rz, first_rz: rz, sum: 0.0, last: [(0.0, rz); BACK], count: 0 }
    }

    /// After an iteration of step length `alpha`, with r·z of the new residual.
    pub(super) fn advance(&mut self, alpha: f64, rz: f64) {
        self.sum += alpha * self.rz;
        self.count += 1;
        self.rz = rz;
        self.last[self.count % BACK] = (self.sum, rz);
    }

    /// The estimate; from the second iteration on it is more than a guess.
    pub(super) fn squared(&self) -> f64 {
        // The oldest that is kept.
        let (sum, rz) = if self.count < BACK { (0.0, self.first_rz) } else { self.last[(self.count + 1) % BACK] };
        let ratio = (self.sum / self.first_rz).max((self.sum - sum) / rz).max(1.0);
        // A residual of zero leaves no error, whatever its ratio.
        if self.rz > 0.0 { self.rz * ratio } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Conjugate gradients on the stiffness of a net of springs, held at its rim and preconditioned by its diagonal: the
    /// energy of the error is known in every iteration.
    #[test]
    fn the_estimate_stays_near_the_error() {
        const SIDE: usize = 12;
        const N: usize = SIDE * SIDE;
        let apply = |x: &[f64; N]| -> [f64; N] {
            std::array::from_fn(|i| {
                let (row, column) = (i / SIDE, i % SIDE);
                // Stiffer along the rows, as along fibres, but for one spring in five.
                let along = |column: usize| if column.is_multiple_of(5) { 1.0 } else { 10.0 };
                let beside =
                    |inside: bool, j: usize, stiffness: f64| stiffness * (x[i] - if inside { x[j] } else { 0.0 });
                beside(column > 0, i.wrapping_sub(1), along(column))
                    + beside(column + 1 < SIDE, i + 1, along(column + 1))
                    + beside(row > 0, i.wrapping_sub(SIDE), 1.0)
                    + beside(row + 1 < SIDE, i + SIDE, 1.0)
            })
        };
        let dot = |a: &[f64; N], b: &[f64; N]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let diagonal: [f64; N] = std::array::from_fn(|i| {
            let mut unit = [0.0; N];
            unit[i] = 1.0;
            apply(&unit)[i]
        });
        let answer: [f64; N] = std::array::from_fn(|i| (0.07 * (i * i) as f64).sin());
        let (mut x, mut r) = ([0.0; N], apply(&answer));
        let precondition = |r: &[f64; N]| -> [f64; N] { std::array::from_fn(|i| r[i] / diagonal[i]) };
        let mut p = precondition(&r);
        let mut rz = dot(&r, &p);
        let mut error = EnergyError::new(rz);
        let first = rz;
        for k in 1..=N {
            let q = apply(&p);
            let alpha = rz / dot(&p, &q);
            (0..N).for_each(|i| (x[i], r[i]) = (x[i] + alpha * p[i], r[i] - alpha * q[i]));
            let z = precondition(&r);
            let next = dot(&r, &z);
            (0..N).for_each(|i| p[i] = z[i] + next / rz * p[i]);
            rz = next;
            error.advance(alpha, rz);
            let missing: [f64; N] = std::array::from_fn(|i| answer[i] - x[i]);
            let true_error = dot(&missing, &apply(&missing));
            if k < 4 || true_error < 1e-12 * first {
                continue;
            }
            // A stop is decided on it, not a digit: within a factor of three either way.
            let ratio = (error.squared() / true_error).sqrt();
            assert!((0.3..3.0).contains(&ratio), "iteration {k}: {ratio}");
        }
    }

    #[test]
    fn next_to_nothing_stored_leaves_the_residual_to_decide() {
        let params = LinearParams { tolerance: 0.1, iterations: 10, ..LinearParams::default() };
        let limits = Limits::new(&params, 4.0, [0.0; 2]);
        assert!(!limits.are_met(0.03, 1e-30) && limits.are_met(3e-12, 1.0));
        let alone = Limits::new(&LinearParams { stress_tolerance: f64::INFINITY, ..params }, 4.0, [0.0, 0.0]);
        assert!(alone.are_met(0.03, 1e30) && !alone.is_late(5));
        let late = Limits::new(&LinearParams { time: Some(std::time::Duration::ZERO), ..params }, 4.0, [1.0, 0.0]);
        assert!(late.is_late(1));
        let repeated = Limits { stop: Some(3), ..late };
        assert!(!repeated.is_late(2) && repeated.is_late(3));
    }
}

//! Preconditioned conjugate gradients on the free axes, warm started, with scratch owned by the caller.

use super::estimate::Limits;
use super::initial_guess::{fit, is_none, residual_without};
use super::recurrence::{Vectors, iterate};
use super::{Operator, ProductMemory};
use crate::components::{FreeAxes, SolverScratch};
use crate::settings::LinearParams;
use crate::systems::parallel;
use glam::{DVec2, DVec3};

/// A negative curvature up to this, over the lengths of the direction and of the operator's product with it, may be rounding: sums of
/// ten thousand terms are good to some 1e-14 of their largest.
const CURVATURE_ROUNDING: f64 = 1e-12;

/// Iterations, relative residual, error energy and outcome of a linear solve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CgInfo {
    /// Iterations done.
    pub iterations: u32,
    /// Norm of the residual over that of the step's largest right-hand side, prescribed motion included.
    pub relative_residual: f64,
    /// Squared energy norm of the error, as estimated \[mJ\].
    pub error_energy: f64,
    /// Whether the tolerances were reached, that of the residual and that of the stress.
    pub is_solved: bool,
    /// Whether it stopped because time was up.
    pub is_late: bool,
}

/// Reason why a solve stopped without an answer; the guess may have been scaled or moved along free axes.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum CgError {
    /// A direction of zero or negative curvature: the operator is not positive definite. In one that is, rounding may make such a
    /// direction: then the iterate reached is the answer.
    #[error("the operator is not positive definite (found in iteration {iteration})")]
    Indefinite {
        /// Iteration in which it was found.
        iteration: u32,
    },
    /// The right-hand side or the operator holds a NaN or an infinity.
    #[error("a value that is not finite (in iteration {iteration})")]
    NotFinite {
        /// Iteration in which it was found.
        iteration: u32,
    },
}

/// Solves A·x = b for the free axes of `x`, whose prescribed axes are given and stay. `scratch.residual` holds b on entry and
/// the residual on exit; `scratch.free` is read; the other vectors are overwritten. `precondition(r, free, z, partials)` writes z ≈ A⁻¹·r
/// with zeros along prescribed axes, and returns r·z.
///
/// # Errors
/// See [`CgError`]; `x` may then have been scaled and moved along free axes.
pub(super) fn solve(
    operator: &Operator,
    params: &LinearParams,
    memory: &mut ProductMemory<'_>,
    x: &mut [DVec3],
    scratch: &mut SolverScratch,
    mut precondition: impl FnMut(&[DVec3], &FreeAxes, &mut [DVec3], &mut Vec<f64>) -> f64,
) -> Result<CgInfo, CgError> {
    let n = x.len();
    let scales = [scratch.twice_stored, scratch.near];
    let SolverScratch { free, residual, direction, product, partials, pairs, stops, reference_sq, .. } = scratch;
    for vector in [&mut *direction, product] {
        vector.resize(n, DVec3::ZERO);
    }

    // The reference norm is that of the residual of a zero guess.
    let without_sq = residual_without(operator, (x, free, residual), direction, product, (partials, memory.passes))?;
    *reference_sq = reference_sq.max(without_sq);
    let b = direction;
    std::mem::swap(residual, b);
    let residual_sq = if is_none(x, free) {
        without_sq
    } else {
        operator.apply(x, free, memory, product, partials);
        let left = |v: usize, _| (b[v] - product[v]) * free[v];
        fit(x, free, residual, left, (pairs, partials)).unwrap_or(without_sq)
    };

    let limits = Limits::new(params, *reference_sq, scales).repeating(stops);
    let rz = precondition(residual, free, product, partials);
    let mut vectors = Free { operator, memory, x, free, residual, direction: b, product, partials, precondition };
    let reached = iterate(&mut vectors, DVec2::new(residual_sq, rz), &limits)?;
    stops.note(reached.iterations, reached.is_late);
    Ok(reached.beside(*reference_sq))
}

/// Vectors in double precision on free axes. z and A·p take turns in one: each has been used up where the other begins.
pub(super) struct Free<'a, 'b, P> {
    pub operator: &'a Operator<'a>,
    pub memory: &'a mut ProductMemory<'b>,
    pub x: &'a mut [DVec3],
    pub free: &'a FreeAxes,
    pub residual: &'a mut [DVec3],
    pub direction: &'a mut [DVec3],
    pub product: &'a mut [DVec3],
    pub partials: &'a mut Vec<f64>,
    pub precondition: P,
}

impl<P: FnMut(&[DVec3], &FreeAxes, &mut [DVec3], &mut Vec<f64>) -> f64> Vectors for Free<'_, '_, P> {
    fn next_direction(&mut self, beta: f64) {
        turn(self.direction, self.product, beta);
    }

    fn multiply(&mut self) -> f64 {
        self.operator.apply(self.direction, self.free, self.memory, self.product, self.partials)
    }

    fn is_at_end(&mut self, curvature: f64, _: f64) -> bool {
        let Self { operator, free, direction, product, partials, .. } = self;
        let n = direction.len();
        let sizes_sq = parallel::sum(n, partials, |v| direction[v].length_squared())
            * parallel::sum(n, partials, |v| (product[v] * free[v]).length_squared());
        operator.is_definite() && curvature >= -CURVATURE_ROUNDING * sizes_sq.sqrt()
    }

    fn advance(&mut self, alpha: f64) -> DVec2 {
        let Self { x, free, residual, direction, product, partials, precondition, .. } = self;
        parallel::for_rows(x, |v, x| *x += direction[v] * alpha);
        let residual_sq = parallel::sum_rows(residual, partials, |v, r| {
            *r -= product[v] * free[v] * alpha;
            r.length_squared()
        });
        DVec2::new(residual_sq, precondition(residual, free, product, partials))
    }
}

/// The next direction, p = z + β·p.
fn turn(direction: &mut [DVec3], z: &[DVec3], beta: f64) {
    if beta == 0.0 {
        direction.copy_from_slice(z);
    } else {
        parallel::for_rows(direction, |v, p| *p = z[v] + *p * beta);
    }
}

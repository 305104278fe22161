//! Residuals of the mixed-precision solver: that of the guess, in single precision where that will do, and those of the answers.

use super::cg::Vectors;
use super::{MixedSolver, size};
use crate::components::{FreeAxes, SolverScratch};
use crate::settings::LinearParams;
use crate::storage::room::grow;
use crate::systems::parallel;
use crate::systems::solver::initial_guess::{fit, is_none, residual_without};
use crate::systems::solver::{CgError, Operator, ProductMemory};
use glam::{DVec3, Vec4};

/// From this tolerance on all of a solve of few iterations is in single precision: the residual that it reports is then within
/// a hundredth of the tolerance of the true one.
const SINGLE: f64 = 1e-4;

/// Whether a solve of few iterations may stay in single precision.
pub(super) fn is_single(params: &LinearParams, scratch: &SolverScratch) -> bool {
    // A body in space may turn at next to no energy, and then the rounding of single precision is a turn.
    scratch.free.are_flat() && params.tolerance.min(params.stress_tolerance) >= SINGLE && !scratch.is_audited
}

impl MixedSolver {
    /// Forms the residual of the guess, which is [scaled](fit), and keeps b in `scratch.direction`. Returns the squared norms of
    /// the residuals' reference and of the guess's residual; and whether the operator's numbers have been taken for it.
    pub(super) fn first_residual(
        &mut self,
        operator: &Operator,
        is_single: bool,
        memory: &mut ProductMemory<'_>,
        x: &mut [DVec3],
        scratch: &mut SolverScratch,
    ) -> Result<(f64, f64, bool), CgError> {
        let SolverScratch { free, residual, direction, product, partials, pairs, reference_sq, .. } = scratch;
        for vector in [&mut *direction, product] {
            grow(vector, x.len(), residual.capacity());
            vector.resize(x.len(), DVec3::ZERO);
        }
        let without_sq =
            residual_without(operator, (x, free, residual), direction, product, (partials, memory.passes))?;
        *reference_sq = reference_sq.max(without_sq);
        let b = direction;
        std::mem::swap(residual, b);
        if is_none(x, free) {
            return Ok((*reference_sq, without_sq, false));
        }
        let residual_sq = if is_single {
            // Of a body that moves in a plane.
            self.assemble(operator, free, false);
            let scale = self.times_rounded(x, free);
            let (row, q) = (&self.order.row, &self.vectors.q);
            let left = |v: usize, without: DVec3| without - q[row[v] as usize].truncate().as_dvec3() * scale;
            fit(x, free, residual, left, (pairs, partials))
        } else {
            operator.apply(x, free, memory, product, partials);
            fit(x, free, residual, |v, _| (b[v] - product[v]) * free[v], (pairs, partials))
        };
        Ok((*reference_sq, residual_sq.unwrap_or(without_sq), is_single))
    }

    /// Rounds the free part of the guess `x` to single precision and multiplies it there. Returns the scale of the product.
    fn times_rounded(&mut self, x: &mut [DVec3], free: &FreeAxes) -> f64 {
        let Self { matrix, partition, order, vectors, .. } = self;
        let Vectors { p, q, partials, .. } = &mut **vectors;
        let largest = x.iter().zip(free).map(|(x, free)| (*x * *free).abs().max_element()).fold(0.0, f64::max);
        let scale = if largest.is_normal() { largest } else { 1.0 };
        size(p, x.len(), Vec4::ZERO);
        size(q, x.len(), Vec4::ZERO);
        parallel::for_rows(p, |row, p| {
            let v = order.vertex[row] as usize;
            *p = (x[v] * free[v] / scale).as_vec3().extend(0.0);
        });
        matrix.apply(partition, p, q, partials);
        parallel::for_rows(x, |v, x| {
            let rounded = p[order.row[v] as usize].truncate().as_dvec3() * scale;
            *x = rounded * free[v] + *x * (DVec3::ONE - free[v]);
        });
        scale
    }

    /// Adds the correction to `x`.
    pub(super) fn add_to(&self, x: &mut [DVec3], norm: f64) {
        let (row, xr) = (&self.order.row, &self.vectors.xr);
        parallel::for_rows(x, |v, x| *x += xr[row[v] as usize][0].truncate().as_dvec3() * norm);
    }

    /// Forms the residual anew, of the b in `scratch.direction`; returns its squared norm.
    pub(super) fn residual(
        &self,
        operator: &Operator,
        memory: &mut ProductMemory<'_>,
        x: &[DVec3],
        scratch: &mut SolverScratch,
    ) -> f64 {
        let SolverScratch { free, residual, direction: b, product, partials, .. } = scratch;
        operator.apply(x, free, memory, product, partials);
        parallel::sum_rows(residual, partials, |v, r| {
            *r = (b[v] - product[v]) * free[v];
            r.length_squared()
        })
    }
}

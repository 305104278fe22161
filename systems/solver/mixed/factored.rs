//! A Cholesky factor of an earlier operator as the preconditioner of the mixed-precision solver.

use super::cg::{Precondition, Vectors};
use super::matrix::dot;
use super::order::Order;
use crate::systems::parallel;
use crate::systems::solver::Factor;
use glam::DVec2;

/// The factor, and the order of the rows.
pub(super) struct Factored<'a> {
    /// The factor.
    pub factor: &'a mut Factor,
    /// The order.
    pub order: &'a Order,
}

impl Precondition for Factored<'_> {
    fn forward_sweep(&mut self, alpha: f32, vectors: &mut Vectors) -> DVec2 {
        let Vectors { xr, p, q, partials, .. } = vectors;
        let rr = parallel::sum_rows(xr, partials, |v, [x, r]| {
            *x += p[v] * alpha;
            *r -= q[v] * alpha;
            dot(*r, *r)
        });
        DVec2::new(rr, self.factor.forward_sweep(xr, &self.order.row))
    }

    fn backward_sweep(&mut self, beta: f32, vectors: &mut Vectors) {
        let Vectors { xr, p, z, .. } = vectors;
        self.factor.backward_sweep(xr, &self.order.row, z);
        parallel::for_rows(p, |v, p| *p = z[v] + *p * beta);
    }
}

//! The solve of a dynamic step in mixed precision: residuals in double precision, iterations in single.
//!
//! State, loads and residuals are double; the correction that a residual asks for is found by conjugate gradients in single
//! precision on the residual scaled to one, added, and the residual formed anew (Wilkinson 1963, iterative refinement). So the
//! answer is as good as that of double precision, and what is reported is the true residual. One round does at the tolerances
//! that a step is usually solved to; a tighter one takes several.

mod cg;
mod incomplete;
mod jacobi;
mod matrix;
mod multigrid;
mod order;
mod partition;
mod pattern;

use super::{CgError, CgInfo, Operator};
use crate::components::SolverScratch;
use crate::settings::LinearParams;
use crate::systems::parallel;
use cg::Vectors;
use glam::{DVec3, Vec4};
use incomplete::{Factored, Incomplete};
use jacobi::Jacobi;
use matrix::Matrix;
use multigrid::Multigrid;
use order::Order;
use partition::Partition;
use pattern::Pattern;

/// No round goes further than this below its own residual: from about ten times less on, single precision only adds noise.
const LEAST_GAIN: f64 = 1e-5;

/// A round aims a little below the tolerance, lest the last digits of single precision ask for another.
const AIM: f64 = 0.95;

/// A round that leaves more of the residual than this has come to nothing: double precision goes on.
const STALLED: f64 = 0.5;

/// The diagonal is raised by this fraction of itself before it is factored. Chosen on the lens capsule as it tears: without it
/// some solves do not converge, with 0.03 the fewest iterations are needed, with 0.2 a quarter more.
const SHIFT: f32 = 0.03;

/// A factor that needs more iterations than this for a round is a bad one: the next has its diagonal raised ten times as far.
const MOST_WITH_FACTOR: u32 = 500;

/// What makes the iterations few.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Inner {
    /// The inverse of each vertex' own block.
    BlockJacobi,
    /// An incomplete Cholesky factor.
    IncompleteCholesky,
    /// A V-cycle over coarser levels.
    Multigrid,
}

/// A body's operator in single precision and the vectors of its solves. What depends on the triangles alone is kept while
/// they stay. *Derived.*
#[derive(Debug, Default)]
pub struct InnerSolver {
    corners: Vec<[u32; 3]>,
    order: Order,
    partition: Partition,
    matrix: Matrix,
    jacobi: Jacobi,
    pattern: Pattern,
    incomplete: Incomplete,
    has_pattern: bool,
    multigrid: Multigrid,
    has_levels: bool,
    vectors: Vectors,
}

impl InnerSolver {
    /// Solves A·x = b for the rotated tangent, from the guess `x`, whose prescribed axes stay; `scratch` as in the solve in
    /// double precision. The second answer is whether the tolerance or the limit of iterations was reached. Where single
    /// precision has come to nothing instead, `x` is as far as it has come, and `scratch.residual` holds b again.
    ///
    /// # Errors
    /// [`CgError::NotFinite`] for a right-hand side or an operator that is not finite.
    pub fn solve(
        &mut self,
        operator: &Operator,
        params: &LinearParams,
        kind: Inner,
        corner: &mut [[DVec3; 3]],
        x: &mut [DVec3],
        scratch: &mut SolverScratch,
    ) -> Result<(CgInfo, bool), CgError> {
        let (reference_sq, mut residual_sq) = first_residual(operator, corner, x, scratch)?;
        let target_sq = params.tolerance * params.tolerance * reference_sq;
        let mut iterations = 0;
        let mut is_solved = true;
        let mut shift = SHIFT;
        if residual_sq > target_sq {
            self.prepare(operator, kind, &scratch.free, shift);
        }
        while residual_sq > target_sq && iterations < params.iterations {
            let norm = residual_sq.sqrt();
            let gain_sq = (AIM * AIM * target_sq / residual_sq).max(LEAST_GAIN * LEAST_GAIN);
            self.load(&scratch.residual, norm);
            let left = params.iterations - iterations;
            let most = if kind == Inner::IncompleteCholesky { left.min(MOST_WITH_FACTOR) } else { left };
            // A direction without curvature may be one that single precision has lost: double precision decides.
            let Ok(done) = self.iterate(kind, gain_sq, most) else {
                is_solved = false;
                break;
            };
            iterations += done;
            let before_sq = residual_sq;
            residual_sq = self.correct(operator, norm, corner, x, scratch);
            let has_stalled = !(residual_sq <= STALLED * STALLED * before_sq) && done < most;
            if !(residual_sq <= target_sq) && has_stalled {
                is_solved = false;
                break;
            }
            if residual_sq > target_sq && done == MOST_WITH_FACTOR && kind == Inner::IncompleteCholesky {
                shift *= 10.0;
                self.incomplete.factor(&self.pattern, &self.partition, &self.matrix, shift);
            }
        }
        if !is_solved {
            scratch.residual.copy_from_slice(&scratch.preconditioned);
        }
        let relative_residual = if reference_sq > 0.0 { (residual_sq / reference_sq).sqrt() } else { 0.0 };
        Ok((CgInfo { iterations, relative_residual }, is_solved))
    }

    /// Takes the operator's numbers, and what depends on the triangles where they have changed.
    fn prepare(&mut self, operator: &Operator, kind: Inner, free: &[DVec3], shift: f32) {
        let corners = &operator.triangles.corners;
        if self.corners != *corners {
            empty(&mut self.corners, corners.len());
            self.corners.extend_from_slice(corners);
            self.order.rebuild(corners, operator.topology);
            self.partition.rebuild(corners, &self.order.row);
            self.has_pattern = false;
            self.has_levels = false;
        }
        self.matrix.assemble(operator, &self.partition, &self.order.vertex, free);
        match kind {
            Inner::BlockJacobi => self.jacobi.factor(&self.partition, &self.matrix),
            Inner::IncompleteCholesky => {
                if !self.has_pattern {
                    self.pattern.rebuild(&self.partition, &self.order, corners, operator.topology);
                    self.has_pattern = true;
                }
                self.incomplete.factor(&self.pattern, &self.partition, &self.matrix, shift);
            }
            Inner::Multigrid => {
                if !self.has_levels {
                    let mesh = (operator.vertices, operator.triangles, operator.topology);
                    self.multigrid.rebuild(&self.partition, &self.order, mesh);
                    self.has_levels = true;
                }
                self.multigrid.assemble(&self.partition, &self.matrix);
            }
        }
    }

    /// Takes the residual over its norm as right-hand side.
    fn load(&mut self, residual: &[DVec3], norm: f64) {
        let vertex = &self.order.vertex;
        empty(&mut self.vectors.xr, vertex.len());
        self.vectors.xr.resize(vertex.len(), [Vec4::ZERO; 2]);
        parallel::for_rows(&mut self.vectors.xr, |row, xr| {
            *xr = [Vec4::ZERO, (residual[vertex[row] as usize] / norm).as_vec3().extend(0.0)];
        });
    }

    fn iterate(&mut self, kind: Inner, target_sq: f64, most: u32) -> Result<u32, CgError> {
        let Self { matrix, partition, pattern, vectors, .. } = self;
        match kind {
            Inner::BlockJacobi => cg::solve(matrix, partition, &mut self.jacobi, vectors, target_sq, most),
            Inner::IncompleteCholesky => {
                let mut factored = Factored { factor: &self.incomplete, pattern };
                cg::solve(matrix, partition, &mut factored, vectors, target_sq, most)
            }
            Inner::Multigrid => cg::solve(matrix, partition, &mut self.multigrid, vectors, target_sq, most),
        }
    }

    /// Adds the correction to `x` and forms the residual anew; returns its squared norm.
    fn correct(
        &self,
        operator: &Operator,
        norm: f64,
        corner: &mut [[DVec3; 3]],
        x: &mut [DVec3],
        scratch: &mut SolverScratch,
    ) -> f64 {
        let SolverScratch { free, residual, preconditioned, product, partials, .. } = scratch;
        let (row, xr) = (&self.order.row, &self.vectors.xr);
        parallel::for_rows(x, |v, x| *x += xr[row[v] as usize][0].truncate().as_dvec3() * norm);
        operator.apply(x, free, corner, product, partials);
        parallel::sum_rows(residual, partials, |v, r| {
            *r = (preconditioned[v] - product[v]) * free[v];
            r.length_squared()
        })
    }
}

/// Empties a list and makes room for `count` entries, with an eighth to spare where it has to grow: as a tear adds some, the
/// next steps find it large enough.
fn empty<T>(list: &mut Vec<T>, count: usize) {
    list.clear();
    if list.capacity() < count {
        list.reserve(count + count / 8);
    }
}

/// Keeps b in `scratch.preconditioned` and forms the residual of the guess, which is dropped where none is better. Returns the
/// squared norms of the residual of the prescribed motion alone, and of that of the guess.
fn first_residual(
    operator: &Operator,
    corner: &mut [[DVec3; 3]],
    x: &mut [DVec3],
    scratch: &mut SolverScratch,
) -> Result<(f64, f64), CgError> {
    let SolverScratch { free, residual, preconditioned, direction, product, partials, .. } = scratch;
    for vector in [&mut *preconditioned, direction, product] {
        vector.resize(x.len(), DVec3::ZERO);
    }
    preconditioned.copy_from_slice(residual);
    parallel::for_rows(direction, |v, p| *p = x[v] * (DVec3::ONE - free[v]));
    // Most bodies have no prescribed motion: its product is zero.
    if direction.iter().any(|p| *p != DVec3::ZERO) {
        operator.apply(direction, free, corner, product, partials);
    } else {
        product.fill(DVec3::ZERO);
    }
    let reference_sq = parallel::sum_rows(direction, partials, |v, p| {
        *p = (residual[v] - product[v]) * free[v];
        p.length_squared()
    });
    operator.apply(x, free, corner, product, partials);
    let residual_sq = parallel::sum_rows(residual, partials, |v, r| {
        *r = (*r - product[v]) * free[v];
        r.length_squared()
    });
    if !reference_sq.is_finite() || residual_sq.is_nan() {
        return Err(CgError::NotFinite { iteration: 0 });
    }
    if residual_sq <= reference_sq {
        return Ok((reference_sq, residual_sq));
    }
    // A guess that is worse than none: start from the prescribed motion alone.
    parallel::for_rows(x, |v, x| *x *= DVec3::ONE - free[v]);
    residual.copy_from_slice(direction);
    Ok((reference_sq, reference_sq))
}

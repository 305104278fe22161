//! The rounds of a solve in mixed precision: iterations in single precision on a residual, and the residual of their answer.

use super::residual::is_single;
use super::{MixedPreconditioner, MixedSolver, cg, size};
use crate::components::SolverScratch;
use crate::settings::LinearParams;
use crate::systems::parallel;
use crate::systems::solver::estimate::Limits;
use crate::systems::solver::recurrence::Reached;
use crate::systems::solver::{CgError, CgInfo, Operator, ProductMemory};
use glam::{DVec3, Vec4};

/// Residual ratio of a round above which it has stalled, and double precision takes over.
const STALLED: f64 = 0.5;

/// Iterations up to which the recursive residual of single precision is trusted.
const FEW_ITERATIONS: u32 = 20;

/// Least tolerance of a solve in space that may end with the recursive residual; tighter ones ask for its last digits.
const LOOSE: f64 = 1e-2;

/// Largest estimated rounding of the recursive residual in space, relative to it.
const MOST_ROUNDING: f64 = 0.01;

/// The diagonal is raised by this fraction of itself before it is factored (Manteuffel 1980). Chosen on the lens capsule as it tears.
const DIAGONAL_SHIFT: f32 = 0.01;

/// Iteration limit of a round with the incomplete factor; where that stalls or breaks, the diagonal is raised ten times as far, up to
/// [`MOST_SHIFT`].
const MOST_WITH_FACTOR: u32 = 150;

/// Maximum fraction by which the diagonal is raised.
const MOST_SHIFT: f32 = 1.0;

/// A solve between two rounds.
struct Progress {
    limits: Limits,
    /// Squared norm of the residual.
    residual_sq: f64,
    /// Whether a short solve stays in single precision throughout.
    is_single: bool,
    /// Whether the solve may end with the recursive residual in space.
    is_loose: bool,
    /// Fraction by which the diagonal of the incomplete factor is raised.
    shift: f32,
    info: CgInfo,
}

/// Next action after a round.
enum Next {
    /// Another round.
    Round,
    /// The end: the tolerances are met, or the time is up.
    End,
    /// Double precision: single precision has come to nothing.
    Double,
}

impl MixedSolver {
    /// Solves A·x = b for a tangent that is never indefinite, from the guess `x`, whose prescribed axes stay; `scratch` as in the solve in
    /// double precision. The second answer is `false` where double precision has to go on. Where single
    /// precision has come to nothing instead, `x` is as far as it has come, and `scratch.residual` holds b again. `scratch.direction` holds
    /// it in any case.
    ///
    /// # Errors
    /// [`CgError::NotFinite`] for a right-hand side or an operator that is not finite; `scratch.residual` is then as it was.
    pub fn solve(
        &mut self,
        operator: &Operator,
        params: &LinearParams,
        kind: MixedPreconditioner,
        memory: &mut ProductMemory<'_>,
        x: &mut [DVec3],
        scratch: &mut SolverScratch,
    ) -> Result<(CgInfo, bool), CgError> {
        let is_single = is_single(params, scratch);
        let (reference_sq, residual_sq, is_assembled) = self.first_residual(operator, is_single, memory, x, scratch)?;
        let limits = Limits::new(params, reference_sq, [scratch.twice_stored, scratch.near]);
        let info = CgInfo { error_energy: f64::INFINITY, ..CgInfo::default() };
        let is_loose = params.tolerance >= LOOSE && !scratch.is_audited;
        let mut progress = Progress { limits, residual_sq, is_single, is_loose, shift: DIAGONAL_SHIFT, info };
        if !progress.is_done() {
            if !is_assembled {
                self.assemble(operator, &scratch.free, kind.may_be_cut(operator));
            }
            self.set_up(operator, kind, DIAGONAL_SHIFT);
        }
        let mut is_solved = true;
        while !progress.is_done() && progress.info.iterations < limits.iterations && !progress.info.is_late {
            match self.round(operator, kind, &mut progress, memory, x, scratch) {
                Next::Round => {}
                Next::End => break,
                Next::Double => {
                    is_solved = false;
                    break;
                }
            }
        }
        if !is_solved {
            scratch.residual.copy_from_slice(&scratch.direction);
        }
        let (is_done, Progress { residual_sq, mut info, .. }) = (progress.is_done(), progress);
        info.is_solved = is_done;
        info.relative_residual = if reference_sq > 0.0 { (residual_sq / reference_sq).sqrt() } else { 0.0 };
        Ok((info, is_solved))
    }

    /// One round: iterations in single precision, their answer added to `x`, and its residual.
    fn round(
        &mut self,
        operator: &Operator,
        kind: MixedPreconditioner,
        progress: &mut Progress,
        memory: &mut ProductMemory<'_>,
        x: &mut [DVec3],
        scratch: &mut SolverScratch,
    ) -> Next {
        let (limits, norm) = (progress.limits, progress.residual_sq.sqrt());
        self.set_residual(&scratch.residual, norm);
        let most = self.max_iterations(kind, &limits, norm, progress.info.iterations);
        let is_own_factor = kind == MixedPreconditioner::IncompleteCholesky;
        let is_multigrid = kind == MixedPreconditioner::Multigrid;
        let round = limits.of_round(norm, most).repeating(&mut scratch.stops);
        let Ok(reached) = self.iterate(kind, &round) else {
            // L may have left the range of single precision.
            if is_own_factor && progress.shift < MOST_SHIFT {
                self.refactor(&mut progress.shift);
                return Next::Round;
            }
            // A direction without curvature may be one that single precision has lost: double precision decides.
            return Next::Double;
        };
        scratch.stops.note(reached.iterations, reached.is_late);
        progress.info.iterations += reached.iterations;
        progress.info.error_energy = reached.energy * norm * norm;
        progress.info.is_late = reached.is_late;
        let before_sq = progress.residual_sq;
        self.add_answer(operator, &reached, progress, memory, x, scratch);
        if is_multigrid {
            self.multigrid.has_served(reached.iterations, (progress.residual_sq / before_sq).sqrt());
        }
        if progress.is_done() {
            return Next::End;
        }
        let has_gained = progress.residual_sq <= STALLED * STALLED * before_sq;
        let is_used_up = reached.is_broken || reached.iterations == most;
        if is_own_factor && is_used_up && !has_gained && progress.shift < MOST_SHIFT {
            self.refactor(&mut progress.shift);
            return Next::Round;
        }
        let has_stalled = !has_gained && reached.iterations < most;
        if has_stalled && !progress.info.is_late {
            return Next::Double;
        }
        if reached.iterations == most && is_multigrid {
            self.multigrid.renew(&self.partition, &self.matrix);
        }
        Next::Round
    }

    /// Maximum iterations of a round on a residual of this norm, after so many iterations of the solve.
    fn max_iterations(&self, kind: MixedPreconditioner, limits: &Limits, norm: f64, done: u32) -> u32 {
        let most = match kind {
            MixedPreconditioner::BlockJacobi => u32::MAX,
            MixedPreconditioner::IncompleteCholesky => MOST_WITH_FACTOR,
            MixedPreconditioner::Multigrid => self.multigrid.most(limits.of_round(norm, 0).least_sq.sqrt()),
        };
        most.min(limits.iterations - done)
    }

    /// Adds the answer of a round to `x`, and takes the residual that it leaves: by the recursion where that will do, else formed anew.
    fn add_answer(
        &mut self,
        operator: &Operator,
        reached: &Reached,
        progress: &mut Progress,
        memory: &mut ProductMemory<'_>,
        x: &mut [DVec3],
        scratch: &mut SolverScratch,
    ) {
        if reached.iterations == 0 && progress.is_done() {
            return;
        }
        let norm = progress.residual_sq.sqrt();
        // Each iteration adds its rounding to the residual of the recursion: a few do not show.
        let by_recursion = reached.residual_sq * progress.residual_sq;
        let is_few = reached.iterations <= FEW_ITERATIONS;
        let is_known = is_few && (progress.is_single || progress.is_loose && self.is_exact(reached));
        self.add_to(x, norm);
        progress.residual_sq = if is_known && progress.limits.are_met_at_end(by_recursion, progress.info.error_energy) {
            let (row, xr) = (&self.order.row, &self.vectors.xr);
            let left = |v: usize| xr[row[v] as usize][1].truncate().as_dvec3() * norm;
            parallel::for_rows(&mut scratch.residual, |v, r| *r = left(v));
            by_recursion
        } else {
            self.residual(operator, memory, x, scratch)
        };
    }

    /// Whether the recursive residual of a body in space is the true one to [`MOST_ROUNDING`]. Rounding of the products is estimated as ε times
    /// the largest stiffness on the diagonal times the way.
    fn is_exact(&self, reached: &Reached) -> bool {
        if self.matrix.is_flat || self.ready != Some(MixedPreconditioner::IncompleteCholesky) {
            return false;
        }
        let way_sq: f64 = self.vectors.xr.iter().map(|[x, _]| f64::from(x.length_squared())).sum();
        let rounding = f64::from(f32::EPSILON * self.incomplete.stiffest) * way_sq.sqrt();
        rounding <= MOST_ROUNDING * reached.residual_sq.sqrt()
    }

    /// Factors again with a diagonal shift ten times as large.
    fn refactor(&mut self, shift: &mut f32) {
        *shift *= 10.0;
        self.incomplete.factor(&self.partition, self.order.dissection, &self.matrix, *shift);
    }

    /// Sets the right-hand side to the residual over its norm.
    pub(super) fn set_residual(&mut self, residual: &[DVec3], norm: f64) {
        let vertex = &self.order.vertex;
        size(&mut self.vectors.xr, vertex.len(), [Vec4::ZERO; 2]);
        parallel::for_rows(&mut self.vectors.xr, |row, xr| {
            *xr = [Vec4::ZERO, (residual[vertex[row] as usize] / norm).as_vec3().extend(0.0)];
        });
    }

    fn iterate(&mut self, kind: MixedPreconditioner, limits: &Limits) -> Result<Reached, CgError> {
        let Self { matrix, partition, vectors, .. } = self;
        match kind {
            MixedPreconditioner::BlockJacobi => cg::solve(matrix, partition, &mut *self.jacobi, vectors, limits),
            MixedPreconditioner::IncompleteCholesky => {
                cg::solve(matrix, partition, &mut *self.incomplete, vectors, limits)
            }
            MixedPreconditioner::Multigrid => cg::solve(matrix, partition, &mut *self.multigrid, vectors, limits),
        }
    }
}

impl Progress {
    /// Whether the answer meets the limits.
    fn is_done(&self) -> bool {
        self.limits.are_met_at_end(self.residual_sq, self.info.error_energy)
    }
}

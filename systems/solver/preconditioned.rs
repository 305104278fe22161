//! One linear solve: the preconditioners that are available, in the order in which they are tried, and conjugate gradients with each
//! until one meets the tolerance; a present factor always ends the solve.
//!
//! 1. a Cholesky factor of an earlier state;
//! 2. a Cholesky factor of the present state;
//! 3. the mixed-precision solver; for exact tangents, multigrid cycles in single precision within double-precision iterations;
//! 4. a Cholesky factor made on the spot, where the mixed-precision solver fails in a dynamic step;
//! 5. block Jacobi in double precision, which is always available.
//!
//! [Guides](guided) are a projection within the iterations; with them the list is 1, 2, 5.

use super::direct::{Factor, NoFactor};
use super::guided::{self, Guides};
use super::patch::Patch;
use super::{CgError, CgInfo, MixedPreconditioner, MixedSolver, Operator, ProductMemory, block_jacobi, cg};
use crate::clock::Moment;
use crate::components::{FreeAxes, SolverScratch};
use crate::settings::{LinearParams, Tangent};
use crate::systems::work;
use glam::DVec3;
use smallvec::SmallVec;

/// Iterations after which a factor of an earlier state is replaced by one of the present. A new one costs about as much as seven
/// iterations with it at 24,000 triangles, and more on larger bodies.
const MOST_WITH_OLD_CHOLESKY: u32 = 10;

/// Iteration limit with a factor of an earlier state where vertices are guided: unknown to it, they cost some iterations with any factor.
const MOST_WITH_OLD_CHOLESKY_GUIDED: u32 = 60;

/// Iterations with a factor of the present state at the most. One or two do where the operator is regular; where it is not,
/// rounding sets the limit, and more iterations come no nearer.
const MOST_WITH_FRESH_CHOLESKY: u32 = 50;

/// Largest number of iterations without a factor in a dynamic solve, after which one is made on the spot where there may be one;
/// fewer with less than 400 vertices. Slack tissue, stiff fibres, slivers and long steps leave operators for which an incomplete factor in
/// single precision needs thousands, or comes to nothing (`rhexis bench ablation --scene play`).
const MOST_WITHOUT_FACTOR: u32 = 500;

/// Iterations with a multigrid cycle of the present state at the most, in double precision: where they do not suffice rounding
/// in the cycle sets the limit, and block Jacobi, which has none, goes on.
const MOST_CYCLES: u32 = 200;

/// When a solve takes the Cholesky factor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FactorUse {
    /// Before all others.
    First,
    /// After a failure of the mixed-precision solver, and in the solves that follow; with guides, before all others.
    Fallback,
}

/// Preconditioners available to a solve. Double precision with block Jacobi is always available.
#[derive(Default)]
pub struct Available<'a> {
    /// Cholesky factor, renewed in the solve in which it no longer serves.
    pub factor: Option<(&'a mut Factor, FactorUse)>,
    /// Work that the budget leaves to the solve, if there is one.
    pub left: Option<u32>,
    /// Mixed-precision solver, for tangents that are never indefinite, and its preconditioner where there is no factor.
    pub mixed: Option<(&'a mut MixedSolver, MixedPreconditioner)>,
}

/// A preconditioner of the list, which block Jacobi ends.
#[derive(Clone, Copy, PartialEq)]
enum Attempt {
    /// Cholesky factor of an earlier state.
    EarlierFactor,
    /// Cholesky factor of the present state.
    PresentFactor,
    /// Multigrid cycles in single precision within double-precision iterations.
    Cycles,
    /// Mixed-precision solver.
    Mixed(MixedPreconditioner),
    /// Cholesky factor of the present state, for this solve and the next ones.
    FallbackFactor,
}

/// Outcome of an attempt.
enum Outcome {
    /// The solve ends here.
    End(CgInfo),
    /// Iterations done; the next preconditioner goes on from the guess that they leave.
    Next(u32),
}

/// Solves A·x = b by conjugate gradients.
///
/// # Errors
/// See [`CgError`]; `x` may then have been scaled and moved along free axes: keep a copy to start again.
pub fn solve(
    operator: &Operator,
    params: &LinearParams,
    available: &mut Available,
    memory: &mut ProductMemory<'_>,
    x: &mut [DVec3],
    scratch: &mut SolverScratch,
) -> Result<CgInfo, CgError> {
    if let Some((mixed, _)) = &mut available.mixed {
        mixed.forget_operator();
    }
    if operator.external.is_some_and(|external| !external.coupled.is_empty()) {
        // A factor has only the diagonal of springs between layers, and no rigid obstacles: it is of another operator.
        available.factor = None;
    }
    if operator.volume.is_some() {
        // Neither a factor nor the mixed-precision solver has the content of a compartment.
        (available.factor, available.mixed) = (None, None);
    }
    let mut guides = Guides::begin(operator, memory.passes, scratch);
    let attempts = available.attempts(operator, &scratch.free, guides.is_some());
    let mut solve = Solve { operator, params: *params, guides: guides.as_mut(), memory, x, scratch };
    let result = solve.in_order(&attempts, available);
    if let Some(guides) = guides {
        guides.end(scratch);
    }
    result
}

impl Available<'_> {
    /// The list for a solve, in order.
    fn attempts(&mut self, operator: &Operator, free: &FreeAxes, is_guided: bool) -> SmallVec<[Attempt; 4]> {
        let mut attempts = SmallVec::new();
        if let Some((factor, when)) = &mut self.factor
            && (is_guided || *when == FactorUse::First || factor.take_need())
        {
            // After a failure without a factor, one of an earlier state seldom serves.
            let may_serve = is_guided || *when == FactorUse::First;
            if may_serve && factor.is_of(&operator.triangles.corners, free) {
                attempts.push(Attempt::EarlierFactor);
            }
            attempts.push(Attempt::PresentFactor);
        }
        match &self.mixed {
            _ if is_guided => {}
            Some((_, MixedPreconditioner::Multigrid)) if operator.tangent == Tangent::Exact => {
                attempts.push(Attempt::Cycles);
            }
            Some((_, kind)) if operator.tangent != Tangent::Exact => {
                attempts.push(Attempt::Mixed(*kind));
                if matches!(self.factor, Some((_, FactorUse::Fallback))) {
                    attempts.push(Attempt::FallbackFactor);
                }
            }
            _ => {}
        }
        attempts
    }
}

/// A linear solve under way.
struct Solve<'a, 'b> {
    operator: &'a Operator<'a>,
    params: LinearParams,
    guides: Option<&'a mut Guides>,
    memory: &'a mut ProductMemory<'b>,
    x: &'a mut [DVec3],
    scratch: &'a mut SolverScratch,
}

impl Solve<'_, '_> {
    fn in_order(&mut self, attempts: &[Attempt], available: &mut Available) -> Result<CgInfo, CgError> {
        let (start, LinearParams { iterations, time, .. }) = (Moment::now(), self.params);
        let mut done = 0;
        for attempt in attempts {
            match self.attempt(*attempt, available)? {
                Outcome::End(info) => return Ok(CgInfo { iterations: done + info.iterations, ..info }),
                Outcome::Next(more) => {
                    done += more;
                    available.left = available.left.map(|left| left.saturating_sub(more));
                }
            }
            self.params.time = time.map(|time| time.saturating_sub(start.elapsed()));
            self.params.iterations = iterations - done.min(iterations);
        }
        let info = self.with_block_jacobi()?;
        Ok(CgInfo { iterations: done + info.iterations, ..info })
    }

    /// One attempt; where another goes on, the residual is the right-hand side again.
    fn attempt(&mut self, attempt: Attempt, available: &mut Available) -> Result<Outcome, CgError> {
        let left = available.left;
        let most_without_factor = match available.factor {
            Some((_, FactorUse::Fallback)) => {
                let within = left.map_or(u32::MAX, |left| left.saturating_sub(work::FACTORED));
                MOST_WITHOUT_FACTOR.min(100 + self.x.len() as u32).min(within)
            }
            _ => u32::MAX,
        };
        let most_with_factor = left.map_or(u32::MAX, work::iterations_with_factor);
        match (attempt, &mut available.factor, &mut available.mixed) {
            (Attempt::EarlierFactor, Some((factor, _)), _) => {
                let is_guided = self.guides.is_some();
                let most = if is_guided { MOST_WITH_OLD_CHOLESKY_GUIDED } else { MOST_WITH_OLD_CHOLESKY };
                self.scratch.rhs_backup.clone_from(&self.scratch.residual);
                let info = self.with_factor(factor, most.min(most_with_factor))?;
                if info.is_solved || info.is_late {
                    return Ok(Outcome::End(info));
                }
                self.scratch.residual.copy_from_slice(&self.scratch.rhs_backup);
                Ok(Outcome::Next(info.iterations))
            }
            (Attempt::PresentFactor, Some((factor, _)), _) => match factor.renew(self.operator, &self.scratch.free) {
                Ok(()) => self.with_present_factor(factor, most_with_factor),
                Err(NoFactor::Indefinite) if !self.operator.is_definite() => Err(CgError::Indefinite { iteration: 0 }),
                // There can be none, or rounding has left no factor.
                Err(_) => Ok(Outcome::Next(0)),
            },
            (Attempt::FallbackFactor, Some((factor, _)), _) => {
                match factor.renew_for_next(self.operator, &self.scratch.free) {
                    Ok(()) => self.with_present_factor(factor, most_with_factor),
                    Err(_) => Ok(Outcome::Next(0)),
                }
            }
            (Attempt::Cycles, _, Some((mixed, _))) => self.with_cycles(mixed),
            (Attempt::Mixed(kind), _, Some((mixed, _))) => {
                Ok(self.in_mixed_precision(mixed, kind, most_without_factor))
            }
            // The list names only solvers that are available.
            _ => Ok(Outcome::Next(0)),
        }
    }

    fn conjugate_gradients(
        &mut self,
        most: u32,
        mut precondition: impl FnMut(&[DVec3], &FreeAxes, &mut [DVec3], &mut Vec<f64>) -> f64,
    ) -> Result<CgInfo, CgError> {
        let Self { operator, guides, memory, x, scratch, .. } = self;
        let params = LinearParams { iterations: self.params.iterations.min(most), ..self.params };
        let patches = Patch::all(operator, &scratch.free);
        let precondition = |r: &[DVec3], free: &FreeAxes, z: &mut [DVec3], partials: &mut Vec<f64>| {
            let mut product = precondition(r, free, z, partials);
            for patch in &patches {
                let (answer, part) = patch.answer(|v| r[v]);
                patch.spread(&answer, |v, motion| z[v] += motion);
                product += part;
            }
            product
        };
        match guides {
            None => cg::solve(operator, &params, memory, x, scratch, precondition),
            Some(guides) => guided::solve(guides, operator, &params, memory, x, scratch, precondition),
        }
    }

    fn with_factor(&mut self, factor: &mut Factor, most: u32) -> Result<CgInfo, CgError> {
        factor.begin(self.operator, &self.scratch.free);
        let info = self.conjugate_gradients(most, |r, free, z, partials| factor.apply(r, free, z, partials))?;
        factor.note(info.iterations);
        Ok(info)
    }

    /// Last attempt of the solve: where a factor of the operator itself stops short, rounding is the limit.
    fn with_present_factor(&mut self, factor: &mut Factor, most: u32) -> Result<Outcome, CgError> {
        let regular = if self.guides.is_some() { u32::MAX } else { MOST_WITH_FRESH_CHOLESKY };
        self.with_factor(factor, most.min(regular)).map(Outcome::End)
    }

    fn with_block_jacobi(&mut self) -> Result<CgInfo, CgError> {
        let mut inverse = std::mem::take(&mut self.scratch.inverse_block);
        block_jacobi::invert_blocks(self.operator, &self.scratch.free, &mut inverse);
        let info =
            self.conjugate_gradients(u32::MAX, |r, _, z, partials| block_jacobi::apply(&inverse, r, z, partials));
        self.scratch.inverse_block = inverse;
        info
    }

    fn in_mixed_precision(&mut self, mixed: &mut MixedSolver, kind: MixedPreconditioner, most: u32) -> Outcome {
        let Self { operator, params, memory, x, scratch, .. } = self;
        let most = most.min(params.iterations);
        let limited = LinearParams { iterations: most, ..*params };
        match mixed.solve(operator, &limited, kind, memory, x, scratch) {
            Ok((info, true)) if info.iterations < most || most == params.iterations || info.is_late => {
                Outcome::End(info)
            }
            Ok((info, _)) => {
                scratch.residual.copy_from_slice(&scratch.direction);
                Outcome::Next(info.iterations)
            }
            // Single precision may have overflown: double precision tells.
            Err(_) => Outcome::Next(0),
        }
    }

    /// Double-precision iterations with multigrid cycles, repeated with present numbers where an earlier operator's do not suffice.
    fn with_cycles(&mut self, mixed: &mut MixedSolver) -> Result<Outcome, CgError> {
        self.scratch.rhs_backup.clone_from(&self.scratch.residual);
        mixed.begin_cycles(self.operator, &self.scratch.free);
        let (limit, mut done) = (self.params.iterations, 0);
        loop {
            let most = mixed.most_cycles(self.params.tolerance);
            let limited = most.unwrap_or(MOST_CYCLES).min(limit - done);
            let cycle =
                |r: &[DVec3], _: &FreeAxes, z: &mut [DVec3], partials: &mut Vec<f64>| mixed.cycle(r, z, partials);
            let info = self.conjugate_gradients(limited, cycle)?;
            mixed.end_cycles(info.iterations, info.relative_residual, info.is_solved);
            done += info.iterations;
            if info.is_solved || info.is_late || done >= limit {
                return Ok(Outcome::End(CgInfo { iterations: done, ..info }));
            }
            self.scratch.residual.copy_from_slice(&self.scratch.rhs_backup);
            if most.is_none() {
                return Ok(Outcome::Next(done));
            }
        }
    }
}

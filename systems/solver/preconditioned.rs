//! One linear solve, by the first of these preconditioners that is available and meets the tolerance:
//!
//! 1. a Cholesky factor of an earlier state, renewed on the spot where it needs too many iterations ([`Refresh::Now`]);
//! 2. a Cholesky factor made in the background, within its iteration limit ([`Refresh::Background`]);
//! 3. the mixed-precision solver with its own preconditioner, or multigrid cycles in double precision for exact tangents;
//! 4. a Cholesky factor made on the spot, where the mixed-precision solver fails in a dynamic step;
//! 5. block Jacobi in double precision, which is always available.

use super::factor::{Factor, NoFactor};
use super::{CgError, CgInfo, MixedPreconditioner, MixedSolver, Operator, ProductMemory, block_jacobi, cg, guided};
use crate::clock::Moment;
use crate::components::{FreeAxes, SolverScratch};
use crate::settings::{LinearParams, Tangent};
use glam::DVec3;

/// Iterations after which a factor of an earlier state is replaced by one of the present. A new one costs about as much as seven
/// iterations with it at 24,000 triangles, and more on larger bodies.
const MOST_WITH_OLD_CHOLESKY: u32 = 10;

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
    /// After the mixed-precision solver has come to nothing, and in the solves that follow.
    Fallback,
}

/// Preconditioners available to a solve, tried in this order. Double precision with block Jacobi is always available.
#[derive(Default)]
pub struct Available<'a> {
    /// Cholesky factor, renewed in the solve in which it no longer serves.
    pub factor: Option<(&'a mut Factor, FactorUse)>,
    /// Mixed-precision solver, for tangents that are never indefinite, and its preconditioner where there is no factor.
    pub mixed: Option<(&'a mut MixedSolver, MixedPreconditioner)>,
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
    if !scratch.guide_constraints.is_empty() {
        return guided::solve(operator, params, available, memory, x, scratch);
    }
    let start = Moment::now();
    let mut done = 0;
    if let Some((factor, when)) = &mut available.factor
        && (*when == FactorUse::First || factor.is_needed())
    {
        if factor.is_of(&operator.triangles.corners, &scratch.free) {
            scratch.rhs_backup.clone_from(&scratch.residual);
            let info = solve_with_factor(operator, params, MOST_WITH_OLD_CHOLESKY, factor, memory, x, scratch)?;
            if info.is_solved || info.is_late {
                return Ok(info);
            }
            done = info.iterations;
            scratch.residual.copy_from_slice(&scratch.rhs_backup);
        }
        match factor.renew(operator, &scratch.free) {
            Ok(()) => {
                let info = solve_with_factor(operator, params, MOST_WITH_FRESH_CHOLESKY, factor, memory, x, scratch)?;
                return Ok(CgInfo { iterations: done + info.iterations, ..info });
            }
            Err(NoFactor::Indefinite) if !operator.is_definite() => {
                return Err(CgError::Indefinite { iteration: done });
            }
            // There can be none, or rounding has left no factor.
            Err(_) => {}
        }
    }
    let time = params.time.map(|time| time.saturating_sub(start.elapsed()));
    let limited = LinearParams { iterations: params.iterations - done.min(params.iterations), time, ..*params };
    let info = solve_without_factor(operator, &limited, available, memory, x, scratch)?;
    Ok(CgInfo { iterations: done + info.iterations, ..info })
}

fn solve_without_factor(
    operator: &Operator,
    params: &LinearParams,
    available: &mut Available,
    memory: &mut ProductMemory<'_>,
    x: &mut [DVec3],
    scratch: &mut SolverScratch,
) -> Result<CgInfo, CgError> {
    let mut done = 0;
    match &mut available.mixed {
        Some((mixed, MixedPreconditioner::Multigrid)) if operator.tangent == Tangent::Exact => {
            let info = solve_with_cycles(operator, params, mixed, memory, x, scratch)?;
            if info.is_solved || info.iterations >= params.iterations || info.is_late {
                return Ok(info);
            }
            done = info.iterations;
            scratch.residual.copy_from_slice(&scratch.rhs_backup);
        }
        Some((mixed, kind)) if operator.tangent != Tangent::Exact => {
            let most = match available.factor {
                Some((_, FactorUse::Fallback)) => MOST_WITHOUT_FACTOR.min(100 + x.len() as u32).min(params.iterations),
                _ => params.iterations,
            };
            let limited = LinearParams { iterations: most, ..*params };
            match mixed.solve(operator, &limited, *kind, memory, x, scratch) {
                Ok((info, true)) if info.iterations < most || most == params.iterations || info.is_late => {
                    return Ok(info);
                }
                Ok((info, _)) => {
                    done = info.iterations;
                    scratch.residual.copy_from_slice(&scratch.direction);
                }
                // Single precision may have overflown: double precision tells.
                Err(_) => {}
            }
            if let Some((factor, FactorUse::Fallback)) = &mut available.factor
                && factor.renew_for_next(operator, &scratch.free).is_ok()
            {
                let left = LinearParams { iterations: params.iterations - done, ..*params };
                let info = solve_with_factor(operator, &left, MOST_WITH_FRESH_CHOLESKY, factor, memory, x, scratch)?;
                return Ok(CgInfo { iterations: done + info.iterations, ..info });
            }
        }
        _ => {}
    }
    let params = &LinearParams { iterations: params.iterations - done, ..*params };
    let mut inverse = std::mem::take(&mut scratch.inverse_block);
    block_jacobi::invert_blocks(operator, &scratch.free, &mut inverse);
    let precondition = |r: &[DVec3], _: &FreeAxes, z: &mut [DVec3], partials: &mut Vec<f64>| {
        block_jacobi::apply(&inverse, r, z, partials)
    };
    let info = cg::solve(operator, params, memory, x, scratch, precondition);
    scratch.inverse_block = inverse;
    info.map(|info| CgInfo { iterations: done + info.iterations, ..info })
}

/// Solve with multigrid cycles in double precision, repeated with present numbers where those of an earlier operator do not suffice.
fn solve_with_cycles(
    operator: &Operator,
    params: &LinearParams,
    mixed: &mut MixedSolver,
    memory: &mut ProductMemory<'_>,
    x: &mut [DVec3],
    scratch: &mut SolverScratch,
) -> Result<CgInfo, CgError> {
    scratch.rhs_backup.clone_from(&scratch.residual);
    mixed.begin_cycles(operator, &scratch.free);
    let mut done = 0;
    loop {
        let most = mixed.most_cycles(params.tolerance);
        let limited = LinearParams { iterations: most.unwrap_or(MOST_CYCLES).min(params.iterations - done), ..*params };
        let cycle = |r: &[DVec3], _: &FreeAxes, z: &mut [DVec3], partials: &mut Vec<f64>| mixed.cycle(r, z, partials);
        let info = cg::solve(operator, &limited, memory, x, scratch, cycle)?;
        mixed.end_cycles(info.iterations, info.relative_residual, info.is_solved);
        done += info.iterations;
        if info.is_solved || most.is_none() || done >= params.iterations || info.is_late {
            return Ok(CgInfo { iterations: done, ..info });
        }
        scratch.residual.copy_from_slice(&scratch.rhs_backup);
    }
}

fn solve_with_factor(
    operator: &Operator,
    params: &LinearParams,
    most: u32,
    factor: &mut Factor,
    memory: &mut ProductMemory<'_>,
    x: &mut [DVec3],
    scratch: &mut SolverScratch,
) -> Result<CgInfo, CgError> {
    let params = LinearParams { iterations: params.iterations.min(most), ..*params };
    factor.begin(operator, &scratch.free);
    let precondition =
        |r: &[DVec3], free: &FreeAxes, z: &mut [DVec3], partials: &mut Vec<f64>| factor.apply(r, free, z, partials);
    cg::solve(operator, &params, memory, x, scratch, precondition)
}

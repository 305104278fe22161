//! One solve with one of the preconditioners: block Jacobi, or a sparse Cholesky factor that serves as long as it is good.

use super::factor::{Factor, NoFactor};
use super::{CgError, CgInfo, Operator, block_jacobi, cg};
use crate::components::SolverScratch;
use crate::settings::LinearParams;
use glam::DVec3;

/// Iterations after which a factor of an earlier state is replaced by one of the present: a new one costs about as much as
/// seven iterations with it at 24,000 triangles, and more on larger bodies.
const MOST_WITH_EARLIER_FACTOR: u32 = 10;

/// Iterations with a factor of the present state at the most. One or two do where the operator is regular; where it is not,
/// rounding sets the limit, and more iterations come no nearer.
const MOST_WITH_OWN_FACTOR: u32 = 50;

/// How a solve uses its body's factor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Use {
    /// Not at all: block Jacobi.
    None,
    /// It is renewed on the spot when it no longer serves.
    Wait,
    /// It is renewed aside, and used while it is better than none.
    Aside,
}

/// Solves A·x = b by conjugate gradients, preconditioned by the factor where it is to be used and there can be one, else by
/// block Jacobi.
///
/// # Errors
/// See [`CgError`]; `x` is then unchanged along free axes up to the iterations done.
pub fn solve(
    operator: &Operator,
    params: &LinearParams,
    (factor, how): (&mut Factor, Use),
    corner: &mut [[DVec3; 3]],
    x: &mut [DVec3],
    scratch: &mut SolverScratch,
) -> Result<CgInfo, CgError> {
    let mut done = 0;
    match how {
        Use::None => {}
        Use::Wait => {
            if factor.is_of(&operator.triangles.corners, &scratch.free) {
                let rhs = scratch.residual.clone();
                let info = solve_with_factor(operator, params, MOST_WITH_EARLIER_FACTOR, factor, corner, x, scratch)?;
                if info.relative_residual <= params.tolerance {
                    return Ok(info);
                }
                done = info.iterations;
                scratch.residual = rhs;
            }
            match factor.renew(operator, &scratch.free) {
                Ok(()) => {
                    let info = solve_with_factor(operator, params, MOST_WITH_OWN_FACTOR, factor, corner, x, scratch)?;
                    return Ok(CgInfo { iterations: done + info.iterations, ..info });
                }
                Err(NoFactor::Indefinite) => return Err(CgError::Indefinite { iteration: done }),
                Err(NoFactor::Unavailable) => {}
            }
        }
        Use::Aside => {
            if factor.is_ready(operator, &scratch.free) {
                let info = solve_with_factor(operator, params, u32::MAX, factor, corner, x, scratch)?;
                factor.has_served(info.iterations, operator, &scratch.free);
                return Ok(info);
            }
        }
    }
    let mut inverse = std::mem::take(&mut scratch.inverse_block);
    block_jacobi::invert_blocks(operator, &scratch.free, &mut inverse);
    let precondition = |r: &[DVec3], _: &[DVec3], z: &mut [DVec3], partials: &mut Vec<f64>| {
        block_jacobi::apply(&inverse, r, z, partials)
    };
    let info = cg::solve(operator, params, corner, x, scratch, precondition);
    scratch.inverse_block = inverse;
    if let (Use::Aside, Ok(info)) = (how, &info) {
        factor.has_rested(info.iterations);
    }
    info.map(|info| CgInfo { iterations: done + info.iterations, ..info })
}

fn solve_with_factor(
    operator: &Operator,
    params: &LinearParams,
    most: u32,
    factor: &mut Factor,
    corner: &mut [[DVec3; 3]],
    x: &mut [DVec3],
    scratch: &mut SolverScratch,
) -> Result<CgInfo, CgError> {
    let params = LinearParams { iterations: params.iterations.min(most), ..*params };
    factor.begin(operator, &scratch.free);
    let precondition =
        |r: &[DVec3], free: &[DVec3], z: &mut [DVec3], partials: &mut Vec<f64>| factor.apply(r, free, z, partials);
    cg::solve(operator, &params, corner, x, scratch, precondition)
}

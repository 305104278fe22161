//! One solve with one of the preconditioners: block Jacobi, or a sparse Cholesky factor that serves as long as it is good.

use super::cholesky::{Factor, NoFactor};
use super::{CgError, CgInfo, Operator, block_jacobi, cg};
use crate::components::SolverScratch;
use crate::settings::LinearParams;
use crate::systems::parallel;
use glam::DVec3;

/// Iterations after which a factor of an earlier state is replaced by one of the present: a new one costs about as much as
/// seven iterations with it at 24,000 triangles, and more on larger bodies.
const MOST_WITH_EARLIER_FACTOR: u32 = 10;

/// Iterations with a factor of the present state at the most. One or two do where the operator is regular; where it is not,
/// rounding sets the limit, and more iterations come no nearer.
const MOST_WITH_OWN_FACTOR: u32 = 50;

/// Solves A·x = b by conjugate gradients, preconditioned by `factor` where one is given and there can be one, else by block
/// Jacobi.
///
/// # Errors
/// See [`CgError`]; `x` is then unchanged along free axes up to the iterations done.
pub fn solve(
    operator: &Operator,
    params: &LinearParams,
    factor: Option<&mut Factor>,
    corner: &mut [[DVec3; 3]],
    x: &mut [DVec3],
    scratch: &mut SolverScratch,
) -> Result<CgInfo, CgError> {
    let mut done = 0;
    if let Some(factor) = factor {
        if factor.fits(&operator.triangles.corners, &scratch.free) {
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
    let mut inverse = std::mem::take(&mut scratch.inverse_block);
    block_jacobi::invert_blocks(operator, &scratch.free, &mut inverse);
    let info =
        cg::solve(operator, params, corner, x, scratch, |r, z, partials| block_jacobi::apply(&inverse, r, z, partials));
    scratch.inverse_block = inverse;
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
    cg::solve(operator, &params, corner, x, scratch, |r, z, partials| {
        let answer = factor.solve(r);
        parallel::sum_rows(z, partials, |v, z| {
            *z = answer(v);
            r[v].dot(*z)
        })
    })
}

//! The linear system of a Newton iteration and its solvers: conjugate gradients in double precision without a matrix, and in
//! mixed precision on element matrices; Cholesky factors with the feature `direct`.

mod block_jacobi;
mod bordered;
mod cg;
#[cfg_attr(not(feature = "direct"), path = "direct/unavailable.rs")]
mod direct;
mod estimate;
pub mod group;
mod guided;
mod initial_guess;
mod load_stiffness;
mod mixed;
mod operator;
mod patch;
mod preconditioned;
pub mod reactions;
mod recurrence;
pub mod solve;

pub use cg::{CgError, CgInfo};
pub use direct::{Factor, FactorState};
pub use guided::scale as scale_guided;
pub use load_stiffness::{edge_loads, has_free_rim, load_block, load_product};
pub use mixed::{MixedPreconditioner, MixedSolver, MixedState};
pub use operator::{Operator, ProductMemory};
pub use preconditioned::{Available, FactorUse, solve};

use crate::math::elementary::{exponent, power_of_two};
use glam::DVec3;

/// Power of two that brings the largest component of a residual to order one, against over- and underflow in a preconditioner.
fn scale_to_single(r: &[DVec3]) -> f64 {
    let largest = r.iter().map(|r| r.abs().max_element()).fold(0.0, f64::max);
    if largest.is_normal() { power_of_two((-exponent(largest)).clamp(-1000, 1000)) } else { 1.0 }
}

//! The linear system of a Newton iteration, matrix-free, and its preconditioned conjugate-gradient solver.

mod block_jacobi;
#[cfg(feature = "direct")]
mod bridge;
mod cg;
#[cfg(feature = "direct")]
mod cholesky;
#[cfg_attr(not(feature = "direct"), path = "no_factor.rs")]
mod factor;
mod operator;
#[cfg(feature = "direct")]
mod panels;
#[cfg(feature = "direct")]
mod pattern;
mod preconditioned;
#[cfg(feature = "direct")]
mod snapshot;

pub use cg::{CgError, CgInfo};
pub use factor::Factor;
pub use operator::Operator;
pub use preconditioned::{Use, solve};

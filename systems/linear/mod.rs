//! The linear system of a Newton iteration, matrix-free, and its preconditioned conjugate-gradient solver.

mod block_jacobi;
mod cg;
#[cfg_attr(not(feature = "direct"), path = "no_cholesky.rs")]
mod cholesky;
mod operator;
#[cfg(feature = "direct")]
mod panels;
#[cfg(feature = "direct")]
mod pattern;
mod preconditioned;

pub use cg::{CgError, CgInfo};
pub use cholesky::Factor;
pub use operator::Operator;
pub use preconditioned::solve;

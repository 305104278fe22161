//! The linear system of a Newton iteration and its solvers: conjugate gradients in double precision without a matrix, and in
//! mixed precision on small matrices.

mod block_jacobi;
mod cg;
#[cfg_attr(not(feature = "direct"), path = "no_cholesky.rs")]
mod cholesky;
mod inner;
mod operator;
#[cfg(feature = "direct")]
mod pattern;
mod preconditioned;

pub use cg::{CgError, CgInfo};
pub use cholesky::Factor;
pub use inner::{Inner, InnerSolver};
pub use operator::Operator;
pub use preconditioned::{Means, solve};

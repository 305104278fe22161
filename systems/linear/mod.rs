//! The linear system of a Newton iteration, matrix-free, and its preconditioned conjugate-gradient solver.

mod block_jacobi;
mod cg;
mod operator;

pub use block_jacobi::invert_blocks;
pub use cg::{CgError, CgInfo, solve};
pub use operator::Operator;

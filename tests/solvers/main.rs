//! Linear systems and what solves them: factors, multigrid, precisions, what breaks down, what errors come to.

mod breakdown;
mod dynamic_factor;
mod load_stiffness;
mod static_solver;

#[path = "../common/mod.rs"]
mod common;
#[path = "../meshes/mod.rs"]
mod meshes;

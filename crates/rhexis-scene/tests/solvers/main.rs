//! Linear systems of scenes and what solves them: multigrid, precisions, what errors come to.

mod accumulated_error;
mod mixed_precision;
mod multigrid;

#[path = "../../../../tests/common/mod.rs"]
mod common;
#[path = "../../../../tests/meshes/mod.rs"]
mod meshes;

//! Tears: where they go and at which load, compared across meshes, time steps and modes, and with theory.

pub mod hausdorff;
pub mod square;

pub(super) mod energy;
pub(super) mod fibre;
pub(super) mod mesh;
pub(super) mod quality;
pub(super) mod shape;
pub(super) mod symmetry;
pub(super) mod time_step;

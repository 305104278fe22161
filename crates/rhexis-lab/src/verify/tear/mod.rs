//! Tears: where they go and at which load, compared across meshes, time steps and modes, and with theory.

mod cracked;
pub mod hausdorff;
mod pull;
pub mod square;
mod steady;

pub(super) mod energy;
pub(super) mod fibre;
pub(super) mod flap;
pub(super) mod hand_force;
pub(super) mod kink;
pub(super) mod load;
pub(super) mod mesh;
pub(super) mod quality;
pub(super) mod rate;
pub(super) mod release;
pub(super) mod shape;
pub(super) mod start;
pub(super) mod strip;
pub(super) mod symmetry;
pub(super) mod time_step;
pub(super) mod tip_stress;
pub(super) mod trouser;
pub(super) mod turn;
pub(super) mod two_points;

//! Tears in scenes and in meshes of polygons: how they go, what they leave, cuts, what decides on them, refinement around them.

mod account;
mod balance;
mod cuts;
mod energy_criterion;
mod fracture;
mod gliding;
mod held_shut;
mod random_tears;
mod refinement;
mod tears;

#[path = "../../../../tests/common/mod.rs"]
mod common;
#[path = "../../../../tests/meshes/mod.rs"]
mod meshes;

use glam::DVec2;

/// A square without a grid's structure.
fn unstructured(side: f64, edge: f64, seed: u64) -> meshes::Sheet {
    let corners = [DVec2::ZERO, DVec2::new(side, 0.0), DVec2::splat(side), DVec2::new(0.0, side)];
    rhexis_scene::generate::unstructured(&corners, edge, seed).unwrap().into()
}

//! What bodies of scenes do while they do not tear: laws of fibres as scene files write them, bending, the
//! integrator.

mod bending;
mod holzapfel_gasser_ogden;
mod integrator;
mod stiffening_fibres;

#[path = "../../../../tests/common/mod.rs"]
mod common;
#[path = "../../../../tests/meshes/mod.rs"]
mod meshes;

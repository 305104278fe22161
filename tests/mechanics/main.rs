//! What a body does while it does not tear: elements and their derivatives, fibres that stiffen, loads, the
//! integrator, rest, energy.

mod audit_of_constraints;
mod bed;
mod compartment;
mod containment;
mod edge_loads;
mod element;
mod energy;
mod found_by_stress;
mod guides;
mod holzapfel_gasser_ogden;
mod noise;
mod relaxation;
mod rest_and_release;
mod solved_further;
mod stiffening_fibres;

#[path = "../common/mod.rs"]
mod common;
#[path = "../meshes/mod.rs"]
mod meshes;

//! Tears: what decides on them, how they go, what they leave; the edits of the mesh beneath them, refinement around them.

mod account;
mod attributes;
mod criterion;
mod cuts;
mod edits;
mod energy_criterion;
mod fig2_tear;
mod fracture;
mod held_shut;
mod least_edge;
mod material_force;
mod no_dead_ends;
mod per_triangle;
mod random_edits;
mod random_tears;
mod refinement;
mod starts;
mod tear_meetings;
mod tear_modes;
mod tears;
mod tip_memory;
mod told;

#[path = "../common/mod.rs"]
mod common;
#[path = "../meshes/mod.rs"]
mod meshes;

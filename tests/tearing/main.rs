//! Tears: what decides on them, how they go, what they leave; the edits of the mesh beneath them, refinement around them.

mod attributes;
mod criterion;
mod edits;
mod fig2_tear;
mod least_edge;
mod many_cuts;
mod material_force;
mod no_dead_ends;
mod one_energy;
mod per_triangle;
mod random_edits;
mod starts;
mod tear_meetings;
mod tear_modes;
mod tip_memory;
mod told;

#[path = "../common/mod.rs"]
mod common;
#[path = "../meshes/mod.rs"]
mod meshes;

use rhexis::math::Sym2;
use rhexis::storage::{Topology, Triangles, Vertices};
use rhexis::systems::fracture::Surface;

/// Surface of a body without pre-stretch, stiffening fibres and bending.
fn plain_surface<'a>(
    vertices: &'a Vertices,
    triangles: &'a Triangles,
    topology: &'a Topology,
    is_planar: bool,
) -> Surface<'a> {
    Surface { vertices, triangles, topology, is_planar, unstretched: Sym2::IDENTITY, fibres: None, bending: None }
}

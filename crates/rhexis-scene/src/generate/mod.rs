//! Mesh generators: those of the engine, and lattices and unstructured meshes of polygons.

mod polygon;

pub use polygon::{lattice, unstructured};
pub use rhexis::generate::{GenerateError, MOST_TRIANGLES, cap, disc, grid, jittered, mapped_grid, plate_with_hole};

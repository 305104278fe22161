//! A triangle mesh as it comes from a file or a generator, and the checks at the door.

use glam::DVec3;

/// An indexed triangle mesh with an optional fibre direction per triangle: what readers and generators give and a body takes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// Vertex positions \[mm\].
    pub positions: Vec<DVec3>,
    /// Corner indices, counter-clockwise.
    pub triangles: Vec<[u32; 3]>,
    /// One direction per triangle, if the source carries fibres; need not be unit, must not be zero.
    pub fibres: Option<Vec<DVec3>>,
}

/// Why a mesh is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// No vertices or no triangles.
    #[error("the mesh has no {0}")]
    Empty(&'static str),
}

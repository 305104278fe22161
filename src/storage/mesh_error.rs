//! Defects of a triangle mesh, and how to mend them.

use glam::DVec3;

use super::NONE;
use super::mesh::THINNEST;

/// Most triangles at a vertex: a walk round a vertex takes the square of their number.
pub(super) const MOST_AT_VERTEX: usize = 1000;

/// The first few of a list that may be as long as a file, and their number.
fn few(list: &[usize]) -> String {
    match list {
        [a, b, c, d, _, ..] => format!("{a}, {b}, {c}, {d} and {} more", list.len() - 4),
        _ => list.iter().map(usize::to_string).collect::<Vec<_>>().join(", "),
    }
}

/// Why a mesh is refused. Vertices and triangles are counted from 0.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// No vertices or no triangles.
    #[error("the mesh has no {0}; give a surface of triangles")]
    Empty(&'static str),
    /// More vertices or triangles than a row number can name.
    #[error("the mesh has {count} {what}, more than the {} that can be numbered; coarsen it", NONE)]
    TooLarge {
        /// Which kind.
        what: &'static str,
        /// How many there are.
        count: usize,
    },
    /// A coordinate is NaN, or above 1e75 in size.
    #[error("vertex {vertex} has the position {position}; give three numbers of at most 1e75 in size")]
    NonFinitePosition {
        /// The vertex.
        vertex: usize,
        /// Position of the vertex \[mm\].
        position: DVec3,
    },
    /// A corner names a vertex that does not exist.
    #[error("triangle {triangle} names vertex {index}, but there are only {count} (0 to {}); correct the index", count.saturating_sub(1))]
    IndexOutOfRange {
        /// The triangle.
        triangle: usize,
        /// The index it names.
        index: u32,
        /// Number of vertices.
        count: usize,
    },
    /// A triangle names one vertex twice.
    #[error("triangle {triangle} has vertex {vertex} as a corner twice; remove the triangle or correct the corner")]
    RepeatedCorner {
        /// The triangle.
        triangle: usize,
        /// The repeated vertex.
        vertex: u32,
    },
    /// No area, or so thin that its shape has no digits left.
    #[error(
        "triangle {triangle} is degenerate: its smallest altitude is {ratio:e} of its longest edge (least allowed {THINNEST:e}); \
         collapse its shortest edge or flip its longest"
    )]
    Degenerate {
        /// The triangle.
        triangle: usize,
        /// Smallest altitude over longest edge.
        ratio: f64,
    },
    /// Two triangles with the same three corners.
    #[error("triangles {first} and {second} have the same corners; remove one of them")]
    Duplicate {
        /// The earlier one.
        first: usize,
        /// The later one.
        second: usize,
    },
    /// More than two triangles at an edge.
    #[error(
        "the edge between vertices {} and {} belongs to more than two triangles ({}); remove the extra sheets",
        edge[0], edge[1], few(triangles)
    )]
    NonManifoldEdge {
        /// The ends of the edge.
        edge: [u32; 2],
        /// All triangles at it.
        triangles: Vec<usize>,
    },
    /// Two neighbours run their shared edge the same way: one lies face down.
    #[error(
        "triangles {first} and {second} face opposite ways across the edge between vertices {} and {}; \
         swap two corners of one of them",
        edge[0], edge[1]
    )]
    InconsistentOrientation {
        /// The ends of the edge.
        edge: [u32; 2],
        /// The earlier triangle.
        first: usize,
        /// The later triangle.
        second: usize,
    },
    /// One-sided, as a Möbius strip is.
    #[error(
        "the surface is one-sided: going round, triangles {first} and {second} meet face to back at the edge between vertices \
         {} and {}; cut it open there",
        edge[0], edge[1]
    )]
    NotOrientable {
        /// The ends of the edge where the contradiction shows.
        edge: [u32; 2],
        /// The earlier triangle.
        first: usize,
        /// The later triangle.
        second: usize,
    },
    /// A vertex that joins triangles which share no edge there.
    #[error(
        "vertex {vertex} joins {fans} separate fans of triangles (a bowtie); give each fan its own copy of the vertex, or join \
         the fans along an edge"
    )]
    Bowtie {
        /// The vertex.
        vertex: usize,
        /// Number of fans.
        fans: usize,
    },
    /// More triangles at a vertex than a mesh that is to be stepped has.
    #[error(
        "vertex {vertex} has {triangles} triangles, {MOST_AT_VERTEX} at the most: their angles are under half a degree on average; mesh the surface \
         anew, with triangles of even size"
    )]
    Crowded {
        /// The vertex.
        vertex: usize,
        /// Number of triangles at the vertex.
        triangles: usize,
    },
    /// A vertex without triangles has no mass and cannot be solved for.
    #[error("vertex {vertex} is used by no triangle; remove it (TriangleMesh::without_unused_vertices does)")]
    UnusedVertex {
        /// The vertex.
        vertex: usize,
    },
    /// Fibres and triangles differ in number.
    #[error("there are {fibres} fibres for {triangles} triangles; give one direction per triangle")]
    FibreCount {
        /// Number of fibres.
        fibres: usize,
        /// Number of triangles.
        triangles: usize,
    },
    /// A fibre without direction.
    #[error(
        "the fibre {fibre} of triangle {triangle} has no direction; give three numbers, not all zero, of a length from 1e-75 to 1e75"
    )]
    BadFibre {
        /// The triangle.
        triangle: usize,
        /// The fibre as given.
        fibre: DVec3,
    },
}

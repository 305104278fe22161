//! A topology edit as a value, and the reasons why one is refused.

use smallvec::SmallVec;

/// A change of the mesh. Rows refer to the tables as they are when the edit is applied.
///
/// Rows are dense. New ones go to the end of the tables; where one is removed, the last row takes its place, and the record
/// says who went where. All others stay where they are. Keys outlive every move.
#[derive(Clone, Debug, PartialEq)]
pub enum Edit {
    /// Puts a new vertex on an edge, `weight` of the way from its first corner to its second, and splits the triangles on
    /// both sides. Each keeps the half at the edge's first corner as *it* sees the edge.
    SplitEdge {
        /// Row of one of the triangles at the edge.
        triangle: u32,
        /// The edge, from corner `edge` to the next.
        edge: usize,
        /// In (0, 1).
        weight: f64,
    },
    /// Puts a new vertex inside a triangle, which becomes three.
    SplitTriangle {
        /// Row of the triangle.
        triangle: u32,
        /// Barycentric weights of the new vertex, positive, with sum 1.
        weights: [f64; 3],
    },
    /// Replaces an edge by the other diagonal of its two triangles.
    Flip {
        /// Row of one of the triangles at the edge.
        triangle: u32,
        /// The edge, from corner `edge` to the next.
        edge: usize,
    },
    /// Moves a vertex inside the surface along one of its edges, in the rest shape and in space.
    Slide {
        /// Row of the vertex.
        vertex: u32,
        /// Row of the vertex at the other end of the edge.
        towards: u32,
        /// How far along the edge, in (0, 1).
        weight: f64,
    },
    /// Moves the tip of a tear, a vertex where two lips of equal length meet, to a point of one of its triangles, in the rest
    /// shape and in space.
    Glide {
        /// Row of the vertex.
        vertex: u32,
        /// Row of a triangle at the vertex.
        triangle: u32,
        /// Barycentric weights of the point, by the triangle's corners, with sum 1; that of the vertex lies in (0, 1).
        weights: [f64; 3],
    },
    /// Moves a vertex along one of its edges onto the other end, in the rest shape and in space, where it vanishes with the
    /// one or two triangles at the edge. A vertex on the boundary goes along a straight boundary only.
    Collapse {
        /// Row of the vertex that vanishes.
        vertex: u32,
        /// Row of the vertex at the other end of the edge, which stays as it is.
        into: u32,
    },
    /// Opens the edges along a path. Every vertex of the path is duplicated, once per extra component of its fan; the
    /// component with the lowest triangle row keeps the old vertex, so no two fans ever share one.
    Open {
        /// Rows of the vertices, each joined to the next by an edge inside the surface. Equal ends make a loop.
        path: SmallVec<[u32; 4]>,
    },
}

/// Why an edit was not applied; nothing has changed then.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Refusal {
    /// A row is beyond the end of its table.
    #[error("there is no {what} {row}")]
    NoSuchRow {
        /// `"vertex"` or `"triangle"`.
        what: &'static str,
        /// The row.
        row: u32,
    },
    /// Two vertices are not joined, or an edge index is not 0, 1 or 2.
    #[error("no edge joins vertices {from} and {to}")]
    NoSuchEdge {
        /// Row of the first vertex.
        from: u32,
        /// Row of the second vertex.
        to: u32,
    },
    /// The vertex is no corner of the triangle.
    #[error("vertex {vertex} is no corner of triangle {triangle}")]
    NotACorner {
        /// Row of the vertex.
        vertex: u32,
        /// Row of the triangle.
        triangle: u32,
    },
    /// The edge has a triangle on one side only.
    #[error("the edge between vertices {from} and {to} lies on the boundary")]
    BoundaryEdge {
        /// Row of the first vertex.
        from: u32,
        /// Row of the second vertex.
        to: u32,
    },
    /// The vertex lies on the boundary, where a slide, or a collapse along an edge inside, would change the shape.
    #[error("vertex {vertex} lies on the boundary")]
    BoundaryVertex {
        /// Row of the vertex.
        vertex: u32,
    },
    /// The vertex lies inside the surface, so that no tear ends there and a glide would be a slide.
    #[error("vertex {vertex} lies inside the surface: no tear ends there")]
    InnerVertex {
        /// Row of the vertex.
        vertex: u32,
    },
    /// The two boundary edges at the vertex are not the lips of a tear, of equal length, so a glide would change the shape.
    #[error(
        "the boundary edges at vertex {vertex} end {gap:.3e} mm apart in the rest shape, not at one point as the lips of a tear"
    )]
    LipsApart {
        /// Row of the vertex.
        vertex: u32,
        /// Distance of their far ends \[mm, rest shape\].
        gap: f64,
    },
    /// The boundary bends at the vertex, so a collapse would change the shape.
    #[error("the boundary bends at vertex {vertex}")]
    BentBoundary {
        /// Row of the vertex.
        vertex: u32,
    },
    /// The vertex has so few triangles that its collapse would leave none, or two with the same corners.
    #[error("there are too few triangles around vertex {vertex}")]
    TooFewTriangles {
        /// Row of the vertex.
        vertex: u32,
    },
    /// The edge that a flip or a collapse would make is there already.
    #[error("vertices {from} and {to} are already joined")]
    EdgeExists {
        /// Row of the first vertex.
        from: u32,
        /// Row of the second vertex.
        to: u32,
    },
    /// A weight lies outside its open interval, or weights do not sum to one.
    #[error("interpolation weight {weight} is out of range")]
    WeightOutOfRange {
        /// The weight, or the sum of the weights.
        weight: f64,
    },
    /// A triangle would lose its area or turn over, in the rest shape or in space.
    #[error("triangle {triangle} would turn over")]
    WouldInvert {
        /// Row of the triangle.
        triangle: u32,
    },
    /// A triangle would become a sliver.
    #[error("a sliver with an angle of {:.3}° would be left", angle.to_degrees())]
    WouldMakeSliver {
        /// The smallest angle \[rad\].
        angle: f64,
    },
    /// A path has fewer than two vertices, or passes through one twice.
    #[error("the path of {count} vertices is too short or crosses itself")]
    BadPath {
        /// Number of vertices.
        count: usize,
    },
    /// No vertex of the path would fall into several fans: a single edge with both ends inside stays whole.
    #[error("opening the path would separate nothing")]
    NothingOpens,
    /// The record to undo is not that of the last edit, or the rows it removed have been released.
    #[error("only the last edit can be undone")]
    NotTheLast,
}

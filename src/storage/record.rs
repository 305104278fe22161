//! What an edit did: enough to undo it bit for bit, and for everything derived from the mesh to follow.

use super::{Edit, TriangleRow, Triangles, VertexRow, Vertices};
use smallvec::SmallVec;
use std::ops::{Add, Mul};

/// Where a new vertex comes from: up to three older vertices and their weights, which sum to one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parents {
    rows: [u32; 3],
    weights: [f64; 3],
    count: usize,
}

impl Parents {
    /// A duplicate of one vertex.
    pub fn duplicate(row: u32) -> Self {
        Self { rows: [row; 3], weights: [1.0, 0.0, 0.0], count: 1 }
    }

    /// A point `weight` of the way along an edge.
    pub fn on_edge(from: u32, to: u32, weight: f64) -> Self {
        Self { rows: [from, to, to], weights: [1.0 - weight, weight, 0.0], count: 2 }
    }

    /// A point inside a triangle.
    pub fn in_triangle(rows: [u32; 3], weights: [f64; 3]) -> Self {
        Self { rows, weights, count: 3 }
    }

    /// Rows of the parents.
    pub fn rows(&self) -> &[u32] {
        &self.rows[..self.count]
    }

    /// Weights of the parents.
    pub fn weights(&self) -> &[f64] {
        &self.weights[..self.count]
    }

    /// Whether the new vertex is a copy of its one parent.
    pub fn is_duplicate(&self) -> bool {
        self.count == 1
    }

    /// The weighted mean of a quantity given at the parents. A duplicate gets its parent's value, bit for bit.
    pub fn blend<T: Add<Output = T> + Mul<f64, Output = T>>(&self, at: impl Fn(u32) -> T) -> T {
        let mut value = at(self.rows[0]) * self.weights[0];
        for i in 1..self.count {
            value = value + at(self.rows[i]) * self.weights[i];
        }
        value
    }
}

/// A triangle that an edit has added.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewTriangle {
    /// Row of the triangle it was cut from, which also keeps a part.
    pub parent: u32,
    /// Its corners.
    pub corners: [u32; 3],
}

/// A triangle that an edit has changed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChangedTriangle {
    /// Its row.
    pub row: u32,
    /// All its columns before the edit.
    pub before: TriangleRow,
    /// Its corners after the edit.
    pub corners: [u32; 3],
}

/// An edit that was applied.
#[derive(Clone, Debug, PartialEq)]
pub struct EditRecord {
    /// The edit.
    pub edit: Edit,
    /// Row of the first new vertex; the others follow.
    pub first_vertex: u32,
    /// Where the new vertices come from, in the order of their rows.
    pub new_vertices: SmallVec<[Parents; 2]>,
    /// Row of the first new triangle; the others follow.
    pub first_triangle: u32,
    /// The new triangles, in the order of their rows.
    pub new_triangles: SmallVec<[NewTriangle; 2]>,
    /// Vertices whose columns have changed (often only the mass), with all columns before the edit; ascending rows.
    pub changed_vertices: SmallVec<[(u32, VertexRow); 8]>,
    /// Triangles whose corners or rest data have changed; ascending rows.
    pub changed_triangles: SmallVec<[ChangedTriangle; 8]>,
}

impl EditRecord {
    /// The new vertices with their rows.
    pub fn created(&self) -> impl Iterator<Item = (u32, &Parents)> {
        (self.first_vertex..).zip(&self.new_vertices)
    }

    /// Rows of the vertices that the edit has parted: those it has duplicated.
    pub fn parted(&self) -> impl Iterator<Item = u32> {
        self.new_vertices.iter().filter(|parents| parents.is_duplicate()).map(|parents| parents.rows()[0])
    }

    /// Whether the edit has put a vertex on a boundary edge.
    pub fn has_split_boundary(&self) -> bool {
        matches!(self.edit, Edit::SplitEdge { .. }) && self.new_triangles.len() == 1
    }
}

/// The tables beside an edit record: after the edit for [`Follow::apply`], before it for [`Follow::undo`].
#[derive(Clone, Copy, Debug)]
pub struct Tables<'a> {
    /// The vertices.
    pub vertices: &'a Vertices,
    /// The triangles.
    pub triangles: &'a Triangles,
}

/// Something derived from the mesh, or attached to it, that follows edits instead of being rebuilt.
///
/// After `apply` it must equal what a rebuild would give; after `undo` it must be what it was.
pub trait Follow {
    /// Follows an edit that was just applied to the tables.
    fn apply(&mut self, record: &EditRecord, tables: Tables<'_>);

    /// Goes back behind the last edit, which was just undone in the tables.
    fn undo(&mut self, record: &EditRecord, tables: Tables<'_>);
}

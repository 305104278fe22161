//! Record of an edit: enough to undo it bit for bit, and for everything derived from the mesh to follow.

use super::{Edit, TriangleKey, TriangleRow, Triangles, VertexKey, VertexRow, Vertices};
use smallvec::SmallVec;
use std::ops::{Add, Mul};

/// Origin of a new vertex: up to three older vertices and their weights, which sum to one.
///
/// ```
/// # let (mut simulation, body) = rhexis::internal::example()?;
/// use rhexis::{components::Change, glam::DVec3, storage::Parents};
/// # let mut changes = rhexis::components::ChangeSet::default();
/// # simulation.drain_changes(body, &mut changes)?;
/// let mut colours = vec![1.0; changes.vertex_count as usize];
/// let colour = |of: &[f64], parents: &Parents| parents.blend(|row| of[row as usize]);
/// simulation.cut(body, &[DVec3::new(0.0, 5.0, 0.0), DVec3::new(4.0, 5.0, 0.0)])?;
/// simulation.drain_changes(body, &mut changes)?;
/// for change in &changes.list {
///     match change {
///         Change::VertexAdded { parents, .. } => colours.push(colour(&colours, parents)),
///         Change::VertexMoved { row, parents } => colours[*row as usize] = colour(&colours, parents),
///         Change::VertexRemoved { row } => _ = colours.swap_remove(*row as usize),
///         _ => {}
///     }
/// }
/// assert!(colours.len() == changes.vertex_count as usize && colours.iter().all(|c| (c - 1.0).abs() < 1e-12));
/// # Ok::<(), rhexis::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parents {
    rows: [u32; 3],
    weights: [f64; 3],
    count: usize,
}

impl Parents {
    /// A duplicate of one vertex.
    pub(crate) fn duplicate(row: u32) -> Self {
        Self { rows: [row; 3], weights: [1.0, 0.0, 0.0], count: 1 }
    }

    /// A point `weight` of the way along an edge.
    pub(crate) fn on_edge(from: u32, to: u32, weight: f64) -> Self {
        Self { rows: [from, to, to], weights: [1.0 - weight, weight, 0.0], count: 2 }
    }

    /// A point inside a triangle.
    pub(crate) fn in_triangle(rows: [u32; 3], weights: [f64; 3]) -> Self {
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
    pub(crate) fn is_duplicate(&self) -> bool {
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
    /// Corners of the added triangle.
    pub corners: [u32; 3],
}

/// A triangle that an edit has changed, or moved to another row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChangedTriangle {
    /// Row of the triangle after the edit.
    pub row: u32,
    /// Row of the triangle before the edit: another one only where a removal has moved it.
    pub row_before: u32,
    /// All its columns before the edit.
    pub before: TriangleRow,
    /// Corners of the triangle after the edit.
    pub corners: [u32; 3],
}

/// Vertex and triangles that a collapse has removed. Rows are those before the edit.
#[derive(Clone, Debug, PartialEq)]
pub struct Removed {
    /// Row of the vertex.
    pub vertex: u32,
    /// Key of the vertex, which is buried until the edit is undone or released.
    pub vertex_key: VertexKey,
    /// All its columns.
    pub vertex_before: VertexRow,
    /// Row of the vertex it went into.
    pub into: u32,
    /// The triangles at the edge: descending rows.
    pub triangles: SmallVec<[RemovedTriangle; 2]>,
}

/// A triangle that a collapse has taken away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RemovedTriangle {
    /// Row of the triangle before the edit.
    pub row: u32,
    /// Key of the triangle, which is buried until the edit is undone or released.
    pub key: TriangleKey,
    /// All its columns.
    pub before: TriangleRow,
}

/// An edit that was applied.
#[derive(Clone, Debug, PartialEq)]
pub struct EditRecord {
    /// The edit.
    pub edit: Edit,
    /// Row of the first new vertex; the others follow. Equal to the number of vertices before the edit.
    pub first_vertex: u32,
    /// Where the new vertices come from, in the order of their rows.
    pub new_vertices: SmallVec<[Parents; 2]>,
    /// Row of the first new triangle; the others follow. Equal to the number of triangles before the edit.
    pub first_triangle: u32,
    /// The new triangles, in the order of their rows.
    pub new_triangles: SmallVec<[NewTriangle; 2]>,
    /// Vertices whose columns have changed (often only the mass), with all columns before the edit; ascending rows as they
    /// were then.
    pub changed_vertices: SmallVec<[(u32, VertexRow); 24]>,
    /// Triangles whose row, corners or rest data have changed; ascending by the row before the edit.
    pub changed_triangles: SmallVec<[ChangedTriangle; 16]>,
    /// Vertex and triangles that a collapse has removed.
    pub removed: Option<Removed>,
}

impl EditRecord {
    /// The new vertices with their rows.
    pub fn created(&self) -> impl Iterator<Item = (u32, &Parents)> {
        (self.first_vertex..).zip(&self.new_vertices)
    }

    /// Rows of the triangles that the edit has changed or made.
    pub fn shaped_triangles(&self) -> impl Iterator<Item = u32> + '_ {
        let new = self.first_triangle..self.first_triangle + self.new_triangles.len() as u32;
        self.changed_triangles.iter().map(|changed| changed.row).chain(new)
    }

    /// Row of the vertex that a slide or a glide has moved, and the parents between which it lies now.
    pub fn moved(&self) -> Option<(u32, Parents)> {
        match self.edit {
            Edit::Slide { vertex, towards, weight } => Some((vertex, Parents::on_edge(vertex, towards, weight))),
            Edit::Glide { vertex, triangle, weights } => {
                let around = self.changed_triangles.iter().find(|changed| changed.row == triangle)?;
                Some((vertex, Parents::in_triangle(around.corners, weights)))
            }
            _ => None,
        }
    }

    /// Rows of the vertices that the edit has parted: those it has duplicated.
    pub fn parted(&self) -> impl Iterator<Item = u32> {
        self.new_vertices.iter().filter(|parents| parents.is_duplicate()).map(|parents| parents.rows()[0])
    }

    /// Where a vertex is after the edit that was at `row` before it; `None` for the one that was removed.
    pub fn vertex_after(&self, row: u32) -> Option<u32> {
        after_removals(row, self.first_vertex, self.removed.iter().map(|removed| removed.vertex))
    }

    /// Where a triangle is after the edit that was at `row` before it; `None` for one that was removed.
    pub fn triangle_after(&self, row: u32) -> Option<u32> {
        let removed = self.removed.iter().flat_map(|removed| &removed.triangles);
        after_removals(row, self.first_triangle, removed.map(|triangle| triangle.row))
    }

    /// Row after the edit of the heir of the vertex at `row` before it: the vertex itself, or the one
    /// that it was collapsed into.
    pub fn heir(&self, row: u32) -> u32 {
        let row = self.removed.as_ref().filter(|removed| removed.vertex == row).map_or(row, |removed| removed.into);
        self.vertex_after(row).unwrap_or(row)
    }

    /// Number of vertices after the edit.
    pub fn vertex_count(&self) -> usize {
        self.first_vertex as usize + self.new_vertices.len() - usize::from(self.removed.is_some())
    }

    /// Number of triangles after the edit.
    pub fn triangle_count(&self) -> usize {
        let removed = self.removed.as_ref().map_or(0, |removed| removed.triangles.len());
        self.first_triangle as usize + self.new_triangles.len() - removed
    }

    /// Rows and corners before the edit of all triangles that it has changed, moved or removed.
    pub(super) fn triangles_before(&self) -> impl Iterator<Item = (u32, [u32; 3])> + Clone {
        let removed = self.removed.iter().flat_map(|removed| &removed.triangles);
        let changed = self.changed_triangles.iter().map(|c| (c.row_before, c.before.corners));
        changed.chain(removed.map(|t| (t.row, t.before.corners)))
    }

    /// Rows and corners after the edit of all triangles that it has changed, moved or added.
    pub(super) fn triangles_after(&self) -> impl Iterator<Item = (u32, [u32; 3])> + Clone {
        let new = (self.first_triangle..).zip(&self.new_triangles).map(|(row, new)| (row, new.corners));
        self.changed_triangles.iter().map(|c| (c.row, c.corners)).chain(new)
    }

    /// Whether the edit has put a vertex on a boundary edge.
    pub fn has_split_boundary(&self) -> bool {
        matches!(self.edit, Edit::SplitEdge { .. }) && self.new_triangles.len() == 1
    }
}

/// Where `row` of a table of `count` rows is after `gone` were removed, descending, each time the last row taking the place.
fn after_removals(row: u32, count: u32, gone: impl Iterator<Item = u32>) -> Option<u32> {
    let mut row = row;
    for (gone, last) in gone.zip((0..count).rev()) {
        if row == gone {
            return None;
        }
        if row == last {
            row = gone;
        }
    }
    Some(row)
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
/// After `apply` it must equal the result of a rebuild; after `undo` it must be as it was.
pub trait Follow {
    /// Follows an edit that was just applied to the tables.
    fn apply(&mut self, record: &EditRecord, tables: Tables<'_>);

    /// Goes back behind the last edit, which was just undone in the tables.
    fn undo(&mut self, record: &EditRecord, tables: Tables<'_>);

    /// Drops the data kept for undoing: the edits so far will not be undone any more.
    fn release(&mut self) {}
}

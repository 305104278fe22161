//! Changes of a body's mesh since they were last drained.

use crate::storage::{EditRecord, Parents};
use std::ops::Range;

/// A change of the rows of vertices and triangles. In their order, the changes turn arrays that belong to vertices or triangles
/// (indices, texture coordinates, colours) into those of the mesh as it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// A vertex was added at the end: a copy of its one parent where tissue was parted, else a point between its parents.
    VertexAdded {
        /// Row of the new vertex: the number of vertices before.
        row: u32,
        /// Rows and weights of the vertices that it comes from, by [`Parents::blend`].
        parents: Parents,
    },
    /// A vertex was moved in the rest shape.
    VertexMoved {
        /// Row of the vertex.
        row: u32,
        /// Rows, its own among them, and weights of the vertices between which it is now.
        parents: Parents,
    },
    /// A vertex was removed, and the last one took its row: `swap_remove`.
    VertexRemoved {
        /// Row of the vertex.
        row: u32,
    },
    /// A triangle has other corners.
    TriangleChanged {
        /// Row of the triangle.
        row: u32,
        /// Rows of its vertices.
        corners: [u32; 3],
    },
    /// A triangle was added at the end.
    TriangleAdded {
        /// Row of the new triangle: the number of triangles before.
        row: u32,
        /// Row of the triangle that it was cut from.
        parent: u32,
        /// Rows of its vertices.
        corners: [u32; 3],
    },
    /// A triangle was removed, and the last one took its row: `swap_remove`.
    TriangleRemoved {
        /// Row of the triangle.
        row: u32,
    },
}

/// List of mesh changes by tears, cuts, refinement and coarsening, for whoever keeps a copy of the mesh: a renderer, a
/// network. [`Simulation::drain_changes`](crate::simulation::Simulation::drain_changes) empties it. *Derived*: where it is
/// thrown away, all of the mesh counts as new. A body without this component keeps none.
#[derive(Clone, Debug, PartialEq)]
pub struct Changes {
    pub(crate) log: Vec<Change>,
    /// Whether a copy has to begin anew, and the log is empty for that reason.
    pub(crate) is_whole: bool,
}

/// Changes per triangle at the most: as many as half a triangle's memory. Refinement to twice the triangles makes three.
const MOST_PER_TRIANGLE: usize = 4;

impl Default for Changes {
    /// The whole mesh is new.
    fn default() -> Self {
        Self { log: Vec::new(), is_whole: true }
    }
}

impl Changes {
    /// Notes an edit. Where nobody empties the list until it has several changes per triangle, all of the mesh counts as new.
    pub(crate) fn note(&mut self, record: &EditRecord, triangle_count: usize) {
        if self.is_whole {
            return;
        }
        if self.log.len() > MOST_PER_TRIANGLE * triangle_count.max(256) {
            return self.forget();
        }
        self.log.extend(record.created().map(|(row, &parents)| Change::VertexAdded { row, parents }));
        self.log.extend(record.moved().into_iter().map(|(row, parents)| Change::VertexMoved { row, parents }));
        let changed = record.changed_triangles.iter();
        self.log.extend(changed.map(|t| Change::TriangleChanged { row: t.row_before, corners: t.corners }));
        let added = (record.first_triangle..).zip(&record.new_triangles);
        self.log.extend(added.map(|(row, t)| Change::TriangleAdded { row, parent: t.parent, corners: t.corners }));
        if let Some(removed) = &record.removed {
            self.log.extend(removed.triangles.iter().map(|triangle| Change::TriangleRemoved { row: triangle.row }));
            self.log.push(Change::VertexRemoved { row: removed.vertex });
        }
    }

    /// Everything is new: rows have been sorted, or the list has become too long.
    pub(crate) fn forget(&mut self) {
        self.log.clear();
        self.is_whole = true;
    }
}

/// Changes since the last call, in a buffer of the caller's that keeps its memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ChangeSet {
    /// Whether the whole mesh is new: the first time, after [`Simulation::reorder`](crate::simulation::Simulation::reorder), and
    /// where nobody has asked for a long time. The list is empty then and the ranges span all rows. After a
    /// [`restore`](crate::simulation::Simulation::restore) a copy with data of its own asks once before the next step, whose changes are
    /// listed only then.
    pub is_whole: bool,
    /// The changes in their order.
    pub list: Vec<Change>,
    /// Ranges of rows, ascending, of the vertices that are new, have moved in the rest shape, or come from another row.
    /// Positions and velocities change everywhere in every step.
    pub vertices: Vec<Range<u32>>,
    /// Ranges of rows, ascending, of the triangles that are new, have other corners, or come from another row.
    pub triangles: Vec<Range<u32>>,
    /// Number of vertices now: a copy is cut or extended to it.
    pub vertex_count: u32,
    /// Number of triangles now.
    pub triangle_count: u32,
    rows: Vec<u32>,
}

impl ChangeSet {
    /// Whether nothing has changed.
    pub fn is_empty(&self) -> bool {
        !self.is_whole && self.list.is_empty()
    }

    /// The vertices that parted tissue has left as copies: row of the copy and of its source, each at the moment of its change.
    pub fn copies(&self) -> impl Iterator<Item = (u32, u32)> {
        self.list.iter().filter_map(|change| match change {
            Change::VertexAdded { row, parents } => match *parents.rows() {
                [source] => Some((*row, source)),
                _ => None,
            },
            _ => None,
        })
    }

    /// Where the vertex is now that was in a row before these changes; `None` where it was removed, and where the whole mesh is new.
    pub fn vertex_destination(&self, row: u32) -> Option<u32> {
        self.destination(row, self.vertex_count, |change| match change {
            Change::VertexAdded { .. } => Some(None),
            Change::VertexRemoved { row } => Some(Some(*row)),
            _ => None,
        })
    }

    /// Present row of the triangle, or of its remaining part, that was in a row before these changes; `None` where it was removed, and
    /// where the whole mesh is new.
    pub fn triangle_destination(&self, row: u32) -> Option<u32> {
        self.destination(row, self.triangle_count, |change| match change {
            Change::TriangleAdded { .. } => Some(None),
            Change::TriangleRemoved { row } => Some(Some(*row)),
            _ => None,
        })
    }

    /// Follows a row through rows that are added at the end, `Some(None)`, and removed, `Some(Some(row))`.
    fn destination(&self, row: u32, now: u32, kind: impl Fn(&Change) -> Option<Option<u32>>) -> Option<u32> {
        let [mut added, mut removed] = [0, 0];
        for change in self.list.iter().filter_map(&kind) {
            *(if change.is_some() { &mut removed } else { &mut added }) += 1;
        }
        let mut count = now + removed - added;
        if self.is_whole || row >= count {
            return None;
        }
        let mut at = row;
        for change in self.list.iter().filter_map(kind) {
            let Some(gone) = change else {
                count += 1;
                continue;
            };
            count -= 1;
            match at {
                _ if at == gone => return None,
                _ if at == count => at = gone,
                _ => {}
            }
        }
        Some(at)
    }

    /// Takes the entries of a body's list; the list is empty afterwards.
    pub(crate) fn take(&mut self, changes: &mut Changes, vertex_count: u32, triangle_count: u32) {
        self.is_whole = std::mem::take(&mut changes.is_whole);
        self.list.clear();
        std::mem::swap(&mut self.list, &mut changes.log);
        (self.vertex_count, self.triangle_count) = (vertex_count, triangle_count);
        if self.is_whole {
            for (ranges, count) in [(&mut self.vertices, vertex_count), (&mut self.triangles, triangle_count)] {
                ranges.clear();
                ranges.push(0..count);
            }
            return;
        }
        let of_vertex = |change: &Change| match *change {
            Change::VertexAdded { row, .. } | Change::VertexMoved { row, .. } | Change::VertexRemoved { row } => {
                Some(row)
            }
            _ => None,
        };
        let of_triangle = |change: &Change| match *change {
            Change::TriangleChanged { row, .. }
            | Change::TriangleAdded { row, .. }
            | Change::TriangleRemoved { row } => Some(row),
            _ => None,
        };
        self.rows.clear();
        self.rows.extend(self.list.iter().filter_map(of_vertex));
        ranges_of(&mut self.rows, vertex_count, &mut self.vertices);
        self.rows.clear();
        self.rows.extend(self.list.iter().filter_map(of_triangle));
        ranges_of(&mut self.rows, triangle_count, &mut self.triangles);
    }
}

/// Rows below `count` as ascending ranges. An entry at a row beyond has been moved below, to a row that is listed itself.
fn ranges_of(rows: &mut Vec<u32>, count: u32, ranges: &mut Vec<Range<u32>>) {
    rows.sort_unstable();
    rows.dedup();
    ranges.clear();
    for &row in rows.iter().take_while(|&&row| row < count) {
        match ranges.last_mut() {
            Some(last) if last.end == row => last.end = row + 1,
            _ => ranges.push(row..row + 1),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::components::{Attributes, Increment};
    use crate::storage::{Edit, Mesh, Topology, Triangles, Vertices, apply};
    use glam::DVec3;

    #[test]
    fn followers_of_a_tip_blend_its_three_parents() {
        let (mut simulation, body) = crate::internal::example().unwrap();
        type Query<'a> = (&'a mut Vertices, &'a mut Triangles, &'a mut Topology);
        let (vertices, triangles, topology) = simulation.world_mut().query_one_mut::<Query<'_>>(body.entity()).unwrap();
        let mut mesh = Mesh { vertices, triangles, topology };
        // A notch of two edges from the lower rim of 8 × 8 cells.
        let tip = 22;
        apply(&mut mesh, &Edit::Open { path: [4, 13, tip].into_iter().collect() }).unwrap();

        let mut copy = mesh.vertices.rest_position.clone();
        let mut attributes = Attributes::new(3, copy.iter().flat_map(|p| p.to_array()).collect());
        let mut increment = Increment { start: copy.clone(), ..Increment::default() };
        let mut changes = Changes { log: Vec::new(), is_whole: false };
        for entry in mesh.topology.incident[tip as usize].clone() {
            let mut weights = [0.1, 0.2, 0.3];
            weights[entry as usize % 3] = 1.0 - weights[(entry as usize + 1) % 3] - weights[(entry as usize + 2) % 3];
            let record = apply(&mut mesh, &Edit::Glide { vertex: tip, triangle: entry / 3, weights }).unwrap();
            changes.note(&record, mesh.triangles.len());
            attributes.follow(&record);
            increment.follow(&record);
        }

        let rest = &mesh.vertices.rest_position;
        let mut set = ChangeSet::default();
        set.take(&mut changes, rest.len() as u32, mesh.triangles.len() as u32);
        for change in &set.list {
            if let Change::VertexMoved { row, parents } = change {
                assert!(*row == tip && parents.rows().len() == 3 && parents.rows().contains(&tip));
                copy[*row as usize] = parents.blend(|parent| copy[parent as usize]);
            }
        }
        assert!(copy == *rest && increment.start == *rest && rest[tip as usize] != DVec3::new(5.0, 2.5, 0.0));
        assert!(attributes.values.iter().eq(rest.iter().flat_map(|p| p.as_ref())));
        assert!(set.vertices.len() == 1 && set.vertices[0] == (tip..tip + 1));
        assert!((0..rest.len() as u32).all(|row| set.vertex_destination(row) == Some(row)));
    }
}

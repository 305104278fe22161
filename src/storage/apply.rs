//! The one place where the mesh changes: an edit is drafted, committed, checked; a record is undone.

use super::draft::{Draft, draft};
use super::{
    ChangedTriangle, Edit, EditRecord, Follow, NewTriangle, Refusal, Removed, RemovedTriangle, Tables, Topology,
    Triangles, Vertices, measure, validate,
};
use glam::DVec3;
use smallvec::SmallVec;

/// A body's mesh, borrowed to be edited.
#[derive(Debug)]
pub struct Mesh<'a> {
    /// The vertices.
    pub vertices: &'a mut Vertices,
    /// The triangles.
    pub triangles: &'a mut Triangles,
    /// Their topology.
    pub topology: &'a mut Topology,
}

impl Mesh<'_> {
    /// The tables, to look at.
    pub fn tables(&self) -> Tables<'_> {
        Tables { vertices: self.vertices, triangles: self.triangles }
    }

    /// Gives up the way back: the keys of rows that edits have removed so far are freed, and these edits cannot be undone any
    /// more. Whoever drops the records of collapses calls it; without it a removed row leaves some bytes behind.
    pub fn release(&mut self) {
        self.vertices.release();
        self.triangles.release();
        if let Some(relaxing) = &mut self.triangles.relaxing {
            relaxing.release();
        }
    }

    /// The first broken invariant, if any.
    ///
    /// # Errors
    /// As [`validate`](super::validate).
    pub fn validate(&self) -> Result<(), super::Broken> {
        validate(self.vertices, self.triangles, self.topology)
    }
}

/// Applies an edit. Total mass and linear momentum stay; splits and openings keep area and elastic energy as well.
/// Flips, slides, glides and collapses change the strains of triangles, and so the elastic energy; they keep the area of flat
/// sheets, on curved ones it changes at second order in the edge length.
///
/// # Errors
/// Why the edit is not legal here; nothing has changed then.
pub fn apply(mesh: &mut Mesh<'_>, edit: &Edit) -> Result<EditRecord, Refusal> {
    let mut draft = draft(mesh, edit)?;
    let record = commit(mesh, edit, &mut draft);
    debug_assert_eq!(mesh.validate(), Ok(()), "after {edit:?}");
    Ok(record)
}

/// Takes the last edit back: every column of every row has the bits it had, removed rows live again under the same
/// keys, and the topology is as it was. Keys of rows that the edit had added are dead.
///
/// # Errors
/// [`Refusal::NotTheLast`] where rows were added or removed after this edit, or the rows it had removed have been
/// [released](Mesh::release); nothing has changed then.
pub fn undo(mesh: &mut Mesh<'_>, record: &EditRecord) -> Result<(), Refusal> {
    if !is_last(mesh, record) {
        return Err(Refusal::NotTheLast);
    }
    for _ in &record.new_triangles {
        mesh.triangles.pop();
    }
    for _ in &record.new_vertices {
        mesh.vertices.pop();
    }
    if let Some(removed) = &record.removed {
        for triangle in removed.triangles.iter().rev() {
            mesh.triangles.exhume(triangle.row, triangle.before);
        }
        mesh.vertices.exhume(removed.vertex, removed.vertex_before);
    }
    for changed in &record.changed_triangles {
        mesh.triangles.set(changed.row_before, changed.before);
    }
    for &(row, before) in &record.changed_vertices {
        mesh.vertices.set(row, before);
    }
    if let Some(relaxing) = &mut mesh.triangles.relaxing {
        relaxing.undo(record);
    }
    mesh.topology.undo(record, Tables { vertices: mesh.vertices, triangles: mesh.triangles });
    debug_assert_eq!(mesh.validate(), Ok(()), "after undoing {:?}", record.edit);
    Ok(())
}

fn is_last(mesh: &Mesh<'_>, record: &EditRecord) -> bool {
    let has_buried = |removed: &Removed| {
        let keys = removed.triangles.iter().rev().map(|triangle| &triangle.key);
        mesh.vertices.buried().last() == Some(&removed.vertex_key)
            && mesh.triangles.buried().iter().rev().take(removed.triangles.len()).eq(keys)
    };
    mesh.vertices.len() == record.vertex_count()
        && mesh.triangles.len() == record.triangle_count()
        && record.changed_triangles.iter().all(|c| mesh.triangles.corners[c.row as usize] == c.corners)
        && record.removed.as_ref().is_none_or(has_buried)
}

fn commit(mesh: &mut Mesh<'_>, edit: &Edit, draft: &mut Draft) -> EditRecord {
    let mut record = EditRecord {
        edit: edit.clone(),
        first_vertex: mesh.vertices.len() as u32,
        new_vertices: draft.new_vertices.iter().map(|&(parents, _)| parents).collect(),
        first_triangle: mesh.triangles.len() as u32,
        new_triangles: draft.added.iter().map(|&(parent, row)| NewTriangle { parent, corners: row.corners }).collect(),
        changed_vertices: SmallVec::new(),
        changed_triangles: SmallVec::new(),
        removed: removed(mesh, draft),
    };
    let patch = corners_of(mesh, draft);
    let with_moved = record.removed.is_some().then(|| {
        add_moved(mesh, &record, draft);
        corners_of(mesh, draft)
    });
    let touched = with_moved.as_ref().unwrap_or(&patch);
    // Extended in place: a collected value is moved, a kilobyte each time.
    let old = touched.iter().take_while(|&&v| v < record.first_vertex);
    record.changed_vertices.extend(old.map(|&v| (v, mesh.vertices.at(v))));
    for (row, after) in &draft.changed {
        let changed = ChangedTriangle {
            row: record.triangle_after(*row).unwrap_or(*row),
            row_before: *row,
            before: mesh.triangles.at(*row),
            corners: after.corners,
        };
        record.changed_triangles.push(changed);
    }

    for &(_, row) in &draft.new_vertices {
        mesh.vertices.push(row);
    }
    if let Some((row, moved)) = draft.moved {
        mesh.vertices.set(row, moved);
    }
    for &(row, after) in &draft.changed {
        mesh.triangles.set(row, after);
    }
    for &(_, row) in &draft.added {
        mesh.triangles.push(row);
    }
    if let Some(removed) = &record.removed {
        for triangle in &removed.triangles {
            mesh.triangles.bury(triangle.row);
        }
        mesh.vertices.bury(removed.vertex);
    }
    if let Some(relaxing) = &mut mesh.triangles.relaxing {
        relaxing.apply(&record);
    }
    mesh.topology.apply(&record, Tables { vertices: mesh.vertices, triangles: mesh.triangles });
    for vertex in touched.iter().filter_map(|&vertex| record.vertex_after(vertex)) {
        mesh.vertices.mass[vertex as usize] = measure::lumped_mass(mesh.triangles, mesh.topology, vertex);
    }
    if draft.shifts_momentum {
        restore_momentum(mesh.vertices, &record, &patch);
    }
    record
}

/// Vertex and triangles that a draft removes.
fn removed(mesh: &Mesh<'_>, draft: &Draft) -> Option<Removed> {
    let (vertex, into) = draft.removed_vertex?;
    let triangle =
        |&row: &u32| Some(RemovedTriangle { row, key: mesh.triangles.key(row)?, before: mesh.triangles.at(row) });
    Some(Removed {
        vertex,
        vertex_key: mesh.vertices.key(vertex)?,
        vertex_before: mesh.vertices.at(vertex),
        into,
        triangles: draft.removed_triangles.iter().filter_map(triangle).collect(),
    })
}

/// Puts the triangles into the draft that a removal moves to another row, or whose corner it moves, and names all corners by
/// the rows they have after it.
fn add_moved(mesh: &Mesh<'_>, record: &EditRecord, draft: &mut Draft) {
    let tail = record.triangle_count() as u32..record.first_triangle;
    let around_last = mesh.topology.incident[record.first_vertex as usize - 1].iter().map(|entry| entry / 3);
    for row in tail.chain(around_last) {
        let is_there = draft.changed.iter().any(|&(changed, _)| changed == row);
        if !is_there && record.triangle_after(row).is_some() {
            draft.changed.push((row, mesh.triangles.at(row)));
        }
    }
    draft.changed.sort_unstable_by_key(|&(row, _)| row);
    for (_, row) in &mut draft.changed {
        row.corners = row.corners.map(|corner| record.vertex_after(corner).unwrap_or(corner));
    }
}

/// All corners of the triangles of a draft, before and after: ascending, so that new vertices come last.
fn corners_of(mesh: &Mesh<'_>, draft: &Draft) -> SmallVec<[u32; 128]> {
    let old = draft.changed.iter().map(|(row, _)| row).chain(&draft.removed_triangles);
    let old = old.map(|&row| mesh.triangles.corners[row as usize]);
    let new = draft.changed.iter().chain(&draft.added).map(|(_, row)| row.corners);
    let mut corners: SmallVec<[u32; 128]> = old.chain(new).flatten().collect();
    corners.sort_unstable();
    corners.dedup();
    corners
}

/// Gives the vertices of the patch that is meshed anew the one velocity increment that restores their linear momentum. None
/// of them is new here.
fn restore_momentum(vertices: &mut Vertices, record: &EditRecord, patch: &[u32]) {
    let mut missing = DVec3::ZERO;
    let mut mass = 0.0;
    for &(row, before) in record.changed_vertices.iter().filter(|(row, _)| patch.contains(row)) {
        missing += before.velocity * before.mass;
        if let Some(row) = record.vertex_after(row) {
            missing -= vertices.velocity[row as usize] * vertices.mass[row as usize];
            mass += vertices.mass[row as usize];
        }
    }
    for row in patch.iter().filter_map(|&row| record.vertex_after(row)) {
        vertices.velocity[row as usize] += missing / mass;
    }
}

//! The one place where the mesh changes: an edit is drafted, committed, checked; a record is undone.

use super::draft::{Draft, draft};
use super::{
    ChangedTriangle, Edit, EditRecord, Follow, NewTriangle, Refusal, Tables, Topology, Triangles, Vertices, measure,
    validate,
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

    /// The first broken invariant, if any.
    ///
    /// # Errors
    /// As [`validate`](super::validate).
    pub fn validate(&self) -> Result<(), super::Broken> {
        validate(self.vertices, self.triangles, self.topology)
    }
}

/// Applies an edit. Total mass and linear momentum stay; splits and openings keep area and elastic energy as well.
/// Flips and slides keep the area of flat sheets; on curved ones it changes at second order in the edge length.
///
/// # Errors
/// Why the edit is not legal here; nothing has changed then.
pub fn apply(mesh: &mut Mesh<'_>, edit: &Edit) -> Result<EditRecord, Refusal> {
    let draft = draft(mesh, edit)?;
    let record = commit(mesh, edit, draft);
    debug_assert_eq!(mesh.validate(), Ok(()), "after {edit:?}");
    Ok(record)
}

/// Takes the last edit back: every column of every row has the bits it had, and so has the topology. Keys of rows that the
/// edit had added are dead.
///
/// # Errors
/// [`Refusal::NotTheLast`] where rows were added after this edit; nothing has changed then.
pub fn undo(mesh: &mut Mesh<'_>, record: &EditRecord) -> Result<(), Refusal> {
    let is_last = mesh.vertices.len() == record.first_vertex as usize + record.new_vertices.len()
        && mesh.triangles.len() == record.first_triangle as usize + record.new_triangles.len()
        && record.changed_triangles.iter().all(|c| mesh.triangles.corners[c.row as usize] == c.corners);
    if !is_last {
        return Err(Refusal::NotTheLast);
    }
    for _ in &record.new_triangles {
        mesh.triangles.pop();
    }
    for _ in &record.new_vertices {
        mesh.vertices.pop();
    }
    for changed in &record.changed_triangles {
        mesh.triangles.set(changed.row, changed.before);
    }
    for &(row, before) in &record.changed_vertices {
        mesh.vertices.set(row, before);
    }
    mesh.topology.undo(record, Tables { vertices: mesh.vertices, triangles: mesh.triangles });
    debug_assert_eq!(mesh.validate(), Ok(()), "after undoing {:?}", record.edit);
    Ok(())
}

fn commit(mesh: &mut Mesh<'_>, edit: &Edit, draft: Draft) -> EditRecord {
    let mut record = EditRecord {
        edit: edit.clone(),
        first_vertex: mesh.vertices.len() as u32,
        new_vertices: draft.new_vertices.iter().map(|&(parents, _)| parents).collect(),
        first_triangle: mesh.triangles.len() as u32,
        new_triangles: draft.added.iter().map(|&(parent, row)| NewTriangle { parent, corners: row.corners }).collect(),
        changed_vertices: SmallVec::new(),
        changed_triangles: draft
            .changed
            .iter()
            .map(|&(row, after)| ChangedTriangle { row, before: mesh.triangles.at(row), corners: after.corners })
            .collect(),
    };
    let touched = touched_vertices(&record);
    let old = touched.iter().take_while(|&&v| v < record.first_vertex);
    record.changed_vertices = old.map(|&v| (v, mesh.vertices.at(v))).collect();

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
    mesh.topology.apply(&record, Tables { vertices: mesh.vertices, triangles: mesh.triangles });
    for &vertex in &touched {
        mesh.vertices.mass[vertex as usize] = measure::lumped_mass(mesh.triangles, mesh.topology, vertex);
    }
    if draft.shifts_momentum {
        restore_momentum(mesh.vertices, &record);
    }
    record
}

/// All corners of changed and new triangles, before and after: ascending, so that new vertices come last.
fn touched_vertices(record: &EditRecord) -> SmallVec<[u32; 64]> {
    let changed = record.changed_triangles.iter().flat_map(|c| c.before.corners.into_iter().chain(c.corners));
    let mut touched: SmallVec<[u32; 64]> =
        changed.chain(record.new_triangles.iter().flat_map(|new| new.corners)).collect();
    touched.sort_unstable();
    touched.dedup();
    touched
}

/// Gives the touched vertices the one velocity increment that restores their linear momentum. No vertex is new here.
fn restore_momentum(vertices: &mut Vertices, record: &EditRecord) {
    let mut missing = DVec3::ZERO;
    let mut mass = 0.0;
    for &(row, before) in &record.changed_vertices {
        let row = row as usize;
        missing += before.velocity * before.mass - vertices.velocity[row] * vertices.mass[row];
        mass += vertices.mass[row];
    }
    for &(row, _) in &record.changed_vertices {
        vertices.velocity[row as usize] += missing / mass;
    }
}

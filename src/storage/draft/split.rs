//! Splitting an edge or a triangle. The parts lie in the plane of their parent and are mapped as it was, so neither area,
//! mass, momentum nor elastic energy changes.

use super::{
    Draft, checked_rest, corner_positions, corners_at, edge_sides, new_vertex, normal, open_interval, rest_of,
    sum_to_one,
};
use crate::storage::{Mesh, Parents, Refusal, TriangleRow, VertexRow};

pub(super) fn edge(mesh: &Mesh<'_>, triangle: u32, edge: usize, weight: f64) -> Result<Draft, Refusal> {
    let sides = edge_sides(mesh, triangle, edge)?;
    open_interval(weight)?;
    let row = mesh.vertices.len() as u32;
    let (parents, vertex) = new_vertex(mesh, Parents::on_edge(sides.from, sides.to, weight));
    let mut draft = Draft::default();
    draft.new_vertices.push((parents, vertex));
    for (t, e) in [Some((triangle, edge)), sides.other].into_iter().flatten() {
        draft.changed.push((t, part(mesh, t, (e + 1) % 3, row, &vertex)?));
        draft.added.push((t, part(mesh, t, e, row, &vertex)?));
    }
    draft.changed.sort_unstable_by_key(|&(t, _)| t);
    Ok(draft)
}

pub(super) fn triangle(mesh: &Mesh<'_>, triangle: u32, weights: [f64; 3]) -> Result<Draft, Refusal> {
    let corners = corners_at(mesh, triangle)?;
    for weight in weights {
        open_interval(weight)?;
    }
    sum_to_one(weights)?;
    let row = mesh.vertices.len() as u32;
    let (parents, vertex) = new_vertex(mesh, Parents::in_triangle(corners, weights));
    let mut draft = Draft::default();
    draft.new_vertices.push((parents, vertex));
    draft.changed.push((triangle, part(mesh, triangle, 2, row, &vertex)?));
    for corner in 0..2 {
        draft.added.push((triangle, part(mesh, triangle, corner, row, &vertex)?));
    }
    Ok(draft)
}

/// The part of a triangle in which one corner is replaced by the new vertex.
fn part(mesh: &Mesh<'_>, t: u32, corner: usize, row: u32, vertex: &VertexRow) -> Result<TriangleRow, Refusal> {
    let mut part = mesh.triangles.at(t);
    part.corners[corner] = row;
    let (rest, _) = corner_positions(mesh, part.corners, row, vertex);
    let old = rest_of(mesh, t);
    part.rest = checked_rest(t, rest, part.fibre, normal(old), [old].into_iter())?;
    Ok(part)
}

//! Moving a vertex inside the surface along an edge.

use super::{
    Draft, checked_rest, corner_positions, current_of, keep_mass, normal, open_interval, rest_of, same_side,
    triangle_mass,
};
use crate::storage::{Mesh, Parents, Refusal, VertexRow};

pub(super) fn slide(mesh: &Mesh<'_>, vertex: u32, towards: u32, weight: f64) -> Result<Draft, Refusal> {
    for row in [vertex, towards] {
        if row as usize >= mesh.vertices.len() {
            return Err(Refusal::NoSuchRow { what: "vertex", row });
        }
    }
    open_interval(weight)?;
    if !mesh.topology.is_edge(&mesh.triangles.corners, vertex, towards) {
        return Err(Refusal::NoSuchEdge { from: vertex, to: towards });
    }
    if mesh.topology.is_boundary_vertex(vertex) {
        return Err(Refusal::BoundaryVertex { vertex });
    }
    let (_, moved) = super::new_vertex(mesh, Parents::on_edge(vertex, towards, weight));
    let moved = VertexRow { mass: mesh.vertices.mass[vertex as usize], ..moved };

    let mut draft = Draft { moved: Some((vertex, moved)), shifts_momentum: true, ..Draft::default() };
    let mut mass = 0.0;
    let around = &mesh.topology.incident[vertex as usize];
    let old = around.iter().map(|&e| rest_of(mesh, e / 3));
    for &entry in around {
        let row = entry / 3;
        let mut triangle = mesh.triangles.at(row);
        mass += triangle_mass(&triangle);
        let (rest, now) = corner_positions(mesh, triangle.corners, vertex, &moved);
        triangle.rest = checked_rest(row, rest, triangle.fibre, normal(rest_of(mesh, row)), old.clone())?;
        if !same_side(normal(now), normal(current_of(mesh, row))) {
            return Err(Refusal::WouldInvert { triangle: row });
        }
        draft.changed.push((row, triangle));
    }
    keep_mass(&mut draft.changed, mass);
    Ok(draft)
}

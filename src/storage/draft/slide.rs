//! Moving a vertex inside the surface along an edge, or the tip of a tear through one of its triangles.
//!
//! Both lips of a tear end at its tip. Where their other ends lie at one point, the strip that a moved tip adds on one side is the one
//! that it takes from the other, so that area and outline stay.

use super::{
    Draft, are_vertices, beside_on_boundary, checked_rest, corner_positions, corners_at, current_of, field, keep_mass,
    normal, open_interval, rest_of, same_side, sum_to_one, triangle_mass,
};
use crate::storage::measure::rest_corners;
use crate::storage::{Mesh, Parents, Refusal, VertexRow};

/// Largest distance of the far ends of two lips, relative to the lips: those split at the weights w and 1 − w differ by some
/// roundings of their coordinates, six orders of magnitude less.
const LIP_GAP: f64 = 1e-9;

pub(super) fn slide(mesh: &Mesh<'_>, vertex: u32, towards: u32, weight: f64) -> Result<Draft, Refusal> {
    are_vertices(mesh, &[vertex, towards])?;
    open_interval(weight)?;
    if !mesh.topology.is_edge(&mesh.triangles.corners, vertex, towards) {
        return Err(Refusal::NoSuchEdge { from: vertex, to: towards });
    }
    if mesh.topology.is_boundary_vertex(vertex) {
        return Err(Refusal::BoundaryVertex { vertex });
    }
    moved(mesh, vertex, Parents::on_edge(vertex, towards, weight))
}

pub(super) fn glide(mesh: &Mesh<'_>, vertex: u32, triangle: u32, weights: [f64; 3]) -> Result<Draft, Refusal> {
    are_vertices(mesh, &[vertex])?;
    let corners = corners_at(mesh, triangle)?;
    let Some(corner) = corners.iter().position(|&row| row == vertex) else {
        return Err(Refusal::NotACorner { vertex, triangle });
    };
    open_interval(weights[corner])?;
    if let Some(&weight) = weights.iter().find(|weight| !(0.0..1.0).contains(*weight)) {
        return Err(Refusal::WeightOutOfRange { weight });
    }
    sum_to_one(weights)?;
    lips_meet(mesh, vertex)?;
    moved(mesh, vertex, Parents::in_triangle(corners, weights))
}

/// Whether the boundary edges at a vertex are two lips of equal length.
fn lips_meet(mesh: &Mesh<'_>, vertex: u32) -> Result<(), Refusal> {
    // A vertex has one fan, so it has two boundary edges or none, and never both to one vertex: they would be one edge inside.
    let [previous, next] = beside_on_boundary(mesh, vertex).ok_or(Refusal::InnerVertex { vertex })?;
    let [a, x, b] = rest_corners(mesh.vertices, [previous, vertex, next]);
    let gap = a.distance(b);
    if gap <= LIP_GAP * x.distance(b) { Ok(()) } else { Err(Refusal::LipsApart { vertex, gap }) }
}

/// The draft of a vertex that moves to the blend of its parents.
fn moved(mesh: &Mesh<'_>, vertex: u32, parents: Parents) -> Result<Draft, Refusal> {
    let (_, moved) = super::new_vertex(mesh, parents);
    let moved = VertexRow { mass: mesh.vertices.mass[vertex as usize], ..moved };

    let mut draft = Draft { moved: Some((vertex, moved)), shifts_momentum: true, ..Draft::default() };
    let mut mass = 0.0;
    let around = &mesh.topology.incident[vertex as usize];
    let old = around.iter().map(|&e| rest_of(mesh, e / 3));
    for &entry in around {
        let row = entry / 3;
        let old_row = mesh.triangles.at(row);
        mass += triangle_mass(&old_row);
        let (rest, now) = corner_positions(mesh, old_row.corners, vertex, &moved);
        let mut triangle = field::at_point(mesh, row, field::centroid(rest));
        triangle.rest = checked_rest(row, rest, triangle.fibre, normal(rest_of(mesh, row)), old.clone())?;
        if !same_side(normal(now), normal(current_of(mesh, row))) {
            return Err(Refusal::WouldInvert { triangle: row });
        }
        draft.changed.push((row, triangle));
    }
    keep_mass(&mut draft.changed, mass);
    Ok(draft)
}

//! Collapsing an edge: the vertex at one end goes onto the other, and the triangles at the edge vanish.
//!
//! The surface stays the same surface if and only if the link condition holds (Dey, Edelsbrunner, Guha, Nekhayev 1999, theorem 1).
//! No vertex is joined to both ends but those opposite to the edge, and no edge stands opposite to both ends in a triangle each. A
//! vertex inside may go anywhere within its fan: the shape stays, on flat sheets exactly. One on the boundary takes the boundary
//! along, so it must lie on the straight line between its neighbours there.
//!
//! The triangles that stay take the values that their fields have at their new centroids; the mass of those that vanish goes to them as
//! density where it does not come along with the area. Their strains change, and the elastic energy with them; the caller judges that change.

use super::{
    Draft, are_vertices, beside_on_boundary, checked_rest, current_of, field, keep_mass, normal, rest_of, same_side,
    triangle_mass,
};
use crate::storage::measure::rest_corners;
use crate::storage::{Mesh, NONE, Refusal, TriangleRow};

/// Largest distance of a boundary vertex from the line between its neighbours on the boundary, relative to theirs: that
/// left by splits and openings of a straight edge is six orders of magnitude below.
const STRAIGHT_BOUNDARY: f64 = 1e-9;

pub(super) fn collapse(mesh: &Mesh<'_>, vertex: u32, into: u32) -> Result<Draft, Refusal> {
    are_vertices(mesh, &[vertex, into])?;
    if !mesh.topology.is_edge(&mesh.triangles.corners, vertex, into) {
        return Err(Refusal::NoSuchEdge { from: vertex, to: into });
    }
    boundary_stays(mesh, vertex, into)?;
    link_condition(mesh, vertex, into)?;

    let mut draft = Draft { removed_vertex: Some((vertex, into)), shifts_momentum: true, ..Draft::default() };
    let mut mass = 0.0;
    let around = &mesh.topology.incident[vertex as usize];
    let old = around.iter().map(|&e| rest_of(mesh, e / 3));
    for &entry in around {
        let row = entry / 3;
        let mut triangle = mesh.triangles.at(row);
        mass += triangle_mass(&triangle);
        if triangle.corners.contains(&into) {
            draft.removed_triangles.insert(0, row);
            continue;
        }
        triangle.corners[(entry % 3) as usize] = into;
        let rest = rest_corners(mesh.vertices, triangle.corners);
        triangle = TriangleRow { corners: triangle.corners, ..field::at_point(mesh, row, field::centroid(rest)) };
        triangle.rest = checked_rest(row, rest, triangle.fibre, normal(rest_of(mesh, row)), old.clone())?;
        let now = triangle.corners.map(|c| mesh.vertices.position[c as usize]);
        if !same_side(normal(now), normal(current_of(mesh, row))) {
            return Err(Refusal::WouldInvert { triangle: row });
        }
        draft.changed.push((row, triangle));
    }
    keep_mass(&mut draft.changed, mass);
    Ok(draft)
}

/// A vertex on the boundary may go along the boundary, where that is straight.
fn boundary_stays(mesh: &Mesh<'_>, vertex: u32, into: u32) -> Result<(), Refusal> {
    let Some([previous, next]) = beside_on_boundary(mesh, vertex) else { return Ok(()) };
    if into != next && into != previous {
        return Err(Refusal::BoundaryVertex { vertex });
    }
    let [a, x, b] = rest_corners(mesh.vertices, [previous, vertex, next]);
    let is_straight =
        (x - a).cross(b - x).length() <= STRAIGHT_BOUNDARY * a.distance_squared(b) && (x - a).dot(b - x) > 0.0;
    if is_straight { Ok(()) } else { Err(Refusal::BentBoundary { vertex }) }
}

fn link_condition(mesh: &Mesh<'_>, vertex: u32, into: u32) -> Result<(), Refusal> {
    let corners = &mesh.triangles.corners;
    let around = &mesh.topology.incident[vertex as usize];
    let at_edge = |row: u32| corners[row as usize].contains(&into);
    let is_opposite = |w: u32| around.iter().any(|&e| at_edge(e / 3) && corners[(e / 3) as usize].contains(&w));
    for &entry in around.iter().filter(|&&e| !at_edge(e / 3)) {
        let (row, corner) = (entry / 3, entry as usize % 3);
        let ends = [1, 2].map(|step| corners[row as usize][(corner + step) % 3]);
        let joined = |&&w: &&u32| !is_opposite(w) && mesh.topology.is_edge(corners, into, w);
        if let Some(&to) = ends.iter().find(joined) {
            return Err(Refusal::EdgeExists { from: into, to });
        }
        let across = mesh.topology.neighbours[row as usize][(corner + 1) % 3];
        if across != NONE && at_edge(across) {
            return Err(Refusal::TooFewTriangles { vertex });
        }
    }
    if around.iter().all(|&e| at_edge(e / 3)) {
        return Err(Refusal::TooFewTriangles { vertex });
    }
    Ok(())
}

//! Replacing an edge by the other diagonal.
//!
//! The two new triangles overlap both old ones: each takes the area-weighted mean of the values that the fields of both have at its centroid.

use super::{
    Draft, SmallVec, checked_rest, current_of, edge_sides, field, keep_mass, normal, rest_of, same_side, triangle_mass,
};
use crate::storage::measure::rest_corners;
use crate::storage::{Mesh, Refusal, TriangleRow};

pub(super) fn flip(mesh: &Mesh<'_>, triangle: u32, edge: usize) -> Result<Draft, Refusal> {
    let sides = edge_sides(mesh, triangle, edge)?;
    let Some((other, back)) = sides.other else {
        return Err(Refusal::BoundaryEdge { from: sides.from, to: sides.to });
    };
    let far = mesh.triangles.corners[other as usize][(back + 2) % 3];
    let corners = &mesh.triangles.corners;
    if far == sides.opposite || mesh.topology.is_edge(corners, sides.opposite, far) {
        return Err(Refusal::EdgeExists { from: sides.opposite, to: far });
    }

    let (a, b) = (mesh.triangles.at(triangle), mesh.triangles.at(other));
    let share = b.rest.area / (a.rest.area + b.rest.area);
    let turned = |mut corners: [u32; 3], edge: usize, far: u32| {
        corners[(edge + 1) % 3] = far;
        let point = field::centroid(rest_corners(mesh.vertices, corners));
        let [a, b] = [triangle, other].map(|row| field::at_point(mesh, row, point));
        TriangleRow { corners, ..field::mean(&a, &b, share) }
    };
    let (mut first, mut second) = (turned(a.corners, edge, far), turned(b.corners, back, sides.opposite));

    let (rest_a, rest_b) = (rest_of(mesh, triangle), rest_of(mesh, other));
    let old_normal = normal(rest_a) + normal(rest_b);
    let current_normal = normal(current_of(mesh, triangle)) + normal(current_of(mesh, other));
    for (row, part) in [(triangle, &mut first), (other, &mut second)] {
        let rest = rest_corners(mesh.vertices, part.corners);
        part.rest = checked_rest(row, rest, part.fibre, old_normal, [rest_a, rest_b].into_iter())?;
        let now = part.corners.map(|c| mesh.vertices.position[c as usize]);
        if !same_side(normal(now), current_normal) {
            return Err(Refusal::WouldInvert { triangle: row });
        }
    }
    let mut changed = SmallVec::from_iter([(triangle, first), (other, second)]);
    changed.sort_unstable_by_key(|&(t, _)| t);
    keep_mass(&mut changed, triangle_mass(&a) + triangle_mass(&b));
    Ok(Draft { changed, shifts_momentum: true, ..Draft::default() })
}

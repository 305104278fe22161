//! Replacing an edge by the other diagonal.
//!
//! The two new triangles overlap both old ones, so where those differ in material, both take the area-weighted mean;
//! where they agree, the value is kept bit for bit.

use super::{
    Draft, SmallVec, checked_rest, current_of, edge_sides, keep_mass, normal, rest_of, same_side, triangle_mass,
};
use crate::math::Orthotropic;
use crate::storage::measure::rest_corners;
use crate::storage::{Mesh, Refusal, TriangleRow};
use std::ops::{Add, Mul};

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
    let blended = blend(&a, &b);
    let (mut first, mut second) = (blended, blended);
    (first.corners, second.corners) = (a.corners, b.corners);
    first.corners[(edge + 1) % 3] = far;
    second.corners[(back + 1) % 3] = sides.opposite;

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

fn blend(a: &TriangleRow, b: &TriangleRow) -> TriangleRow {
    let share = b.rest.area / (a.rest.area + b.rest.area);
    // A fibre is an axis: of ±b the one nearer to a is meant, so the mean cannot vanish.
    let b_fibre = if a.fibre.dot(b.fibre) < 0.0 { -b.fibre } else { b.fibre };
    let fibre = if a.fibre == b_fibre { a.fibre } else { (a.fibre * (1.0 - share) + b_fibre * share).normalize() };
    let (p, q) = (a.stiffness, b.stiffness);
    TriangleRow {
        fibre,
        stiffness: Orthotropic {
            q11: mean(p.q11, q.q11, share),
            q12: mean(p.q12, q.q12, share),
            q22: mean(p.q22, q.q22, share),
            q66: mean(p.q66, q.q66, share),
        },
        thickness: mean(a.thickness, b.thickness, share),
        density: mean(a.density, b.density, share),
        pre_stretch: mean(a.pre_stretch, b.pre_stretch, share),
        strength: mean(a.strength, b.strength, share),
        toughness: mean(a.toughness, b.toughness, share),
        ..*a
    }
}

fn mean<T: PartialEq + Add<Output = T> + Mul<f64, Output = T>>(a: T, b: T, share: f64) -> T {
    if a == b { a } else { a * (1.0 - share) + b * share }
}

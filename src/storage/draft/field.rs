//! Tables of triangles as fields of the rest shape: the values of a triangle whose centroid an edit moves.
//!
//! A value is linear between alike triangles. With d the way to a neighbour's centroid, its gradient is the least-squares solution of ∇f·d = f' − f,
//! and the value leaves the range of those that it was taken from by at most the range's width. Nothing is taken over a border of materials.

use super::{normal, rest_of};
use crate::math::{Orthotropic, Sym2};
use crate::storage::{Mesh, NONE, TriangleRow};
use glam::{DMat2, DVec2, DVec3};
use smallvec::SmallVec;

/// Part of the trace that is added to the diagonal of the least-squares matrix: neighbours on one line leave it singular.
const REGULAR: f64 = 1e-9;

/// Values of a triangle that are fields of the rest shape: fibre, stiffness, thickness, density, pre-stretch, strength, toughness.
type Values = [f64; 14];

/// The row of a triangle with the values that its fields have at a point \[mm, rest shape\].
pub(super) fn at_point(mesh: &Mesh<'_>, triangle: u32, point: DVec3) -> TriangleRow {
    let own = mesh.triangles.at(triangle);
    if mesh.triangles.is_uniform() {
        return own;
    }
    let corners = rest_of(mesh, triangle);
    let centre = centroid(corners);
    let along = (corners[1] - corners[0]).normalize();
    let across = normal(corners).normalize().cross(along);
    let flat = |point: DVec3| DVec2::new((point - centre).dot(along), (point - centre).dot(across));

    let neighbours = mesh.topology.neighbours[triangle as usize].into_iter().filter(|&other| other != NONE);
    let alike = neighbours.map(|other| (other, mesh.triangles.at(other))).filter(|(_, row)| own.is_alike(row));
    let values = values(&own);
    let near: SmallVec<[(DVec2, Values); 3]> =
        alike.map(|(other, row)| (flat(centroid(rest_of(mesh, other))), values_beside(&row, own.fibre))).collect();
    let outer = |way: DVec2| DMat2::from_cols(way * way.x, way * way.y);
    let matrix: DMat2 = near.iter().map(|&(way, _)| outer(way)).sum();
    let trace = matrix.x_axis.x + matrix.y_axis.y;
    let weights = (matrix + DMat2::IDENTITY * (REGULAR * trace)).inverse() * flat(point);
    // No alike neighbour, or triangles so small that squares of their sides vanish.
    if !weights.is_finite() {
        return own;
    }
    let value = |i: usize| {
        let (mut sum, mut least, mut most) = (values[i], values[i], values[i]);
        for (way, other) in &near {
            sum += way.dot(weights) * (other[i] - values[i]);
            (least, most) = (least.min(other[i]), most.max(other[i]));
        }
        let width = most - least;
        sum.clamp(least - width, most + width)
    };
    with_values(&own, std::array::from_fn(value))
}

/// The row of a triangle with the means of the values of two, the second with this share.
pub(super) fn mean(a: &TriangleRow, b: &TriangleRow, share: f64) -> TriangleRow {
    let (p, q) = (values(a), values_beside(b, a.fibre));
    let mean = |i: usize| if p[i] == q[i] { p[i] } else { p[i] * (1.0 - share) + q[i] * share };
    with_values(a, std::array::from_fn(mean))
}

pub(super) fn centroid(corners: [DVec3; 3]) -> DVec3 {
    (corners[0] + corners[1] + corners[2]) / 3.0
}

fn values(row: &TriangleRow) -> Values {
    let (f, q, e) = (row.fibre, row.stiffness, row.pre_stretch);
    let [thickness, density, strength, toughness] = [row.thickness, row.density, row.strength, row.toughness];
    [f.x, f.y, f.z, q.q11, q.q12, q.q22, q.q66, e.xx, e.yy, e.xy, thickness, density, strength, toughness]
}

/// The values of a row beside a triangle with this fibre. A fibre is an axis: of ±f the one nearer to it is meant.
fn values_beside(row: &TriangleRow, fibre: DVec3) -> Values {
    let fibre = if row.fibre.dot(fibre) < 0.0 { -row.fibre } else { row.fibre };
    values(&TriangleRow { fibre, ..*row })
}

/// The row of a triangle with other values; its fibre keeps its bits where it has not turned.
fn with_values(row: &TriangleRow, values: Values) -> TriangleRow {
    let [x, y, z, q11, q12, q22, q66, xx, yy, xy, thickness, density, strength, toughness] = values;
    let fibre = DVec3::new(x, y, z);
    TriangleRow {
        fibre: if fibre == row.fibre { fibre } else { fibre.normalize() },
        stiffness: Orthotropic { q11, q12, q22, q66 },
        pre_stretch: Sym2 { xx, yy, xy },
        thickness,
        density,
        strength,
        toughness,
        ..*row
    }
}

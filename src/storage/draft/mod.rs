//! Drafts: the effect of an edit, computed from the mesh without touching it. Whatever can be refused is refused here.

mod collapse;
mod field;
mod flip;
mod open;
mod slide;
mod split;

use super::measure::{rest_corners, triangle_mass};
use super::{Edit, Mesh, NONE, Parents, Refusal, TriangleRow, VertexRow};
use crate::math::{RestTriangle, SmallestAngle};
use glam::DVec3;
use smallvec::SmallVec;

/// An edit may leave an angle below 1° only where it replaces one that was no better. This is the square of its tangent.
const SLIVER_TANGENT_SQ: f64 = 3.046_792_916_482_916e-4;

/// Mass that a flip, slide, glide or collapse may gain or lose, relative to the triangles it touches, before their densities are
/// corrected. Rounding of a dozen triangle areas stays below, so that flat uniform sheets keep their densities bit for bit.
const MASS_ROUNDING: f64 = 1e-13;

/// The new rows of an edit. Masses are left to the commit, which sums them from the triangles.
#[derive(Default)]
pub(super) struct Draft {
    pub new_vertices: SmallVec<[(Parents, VertexRow); 2]>,
    pub moved: Option<(u32, VertexRow)>,
    pub changed: SmallVec<[(u32, TriangleRow); 16]>,
    /// New triangles with the row of the triangle each was cut from.
    pub added: SmallVec<[(u32, TriangleRow); 2]>,
    /// The vertex that vanishes and the one it goes into.
    pub removed_vertex: Option<(u32, u32)>,
    /// The triangles that vanish: descending rows.
    pub removed_triangles: SmallVec<[u32; 2]>,
    /// Whether mass moves between vertices in a way that does not keep linear momentum by itself.
    pub shifts_momentum: bool,
}

/// Computes the draft of an edit.
pub(super) fn draft(mesh: &Mesh<'_>, edit: &Edit) -> Result<Draft, Refusal> {
    match *edit {
        Edit::SplitEdge { triangle, edge, weight } => split::edge(mesh, triangle, edge, weight),
        Edit::SplitTriangle { triangle, weights } => split::triangle(mesh, triangle, weights),
        Edit::Flip { triangle, edge } => flip::flip(mesh, triangle, edge),
        Edit::Slide { vertex, towards, weight } => slide::slide(mesh, vertex, towards, weight),
        Edit::Glide { vertex, triangle, weights } => slide::glide(mesh, vertex, triangle, weights),
        Edit::Collapse { vertex, into } => collapse::collapse(mesh, vertex, into),
        Edit::Open { ref path } => open::open(mesh, path),
    }
}

/// An edge with its triangle, and the triangle on its other side, if any, as (row, edge there).
struct EdgeSides {
    from: u32,
    to: u32,
    opposite: u32,
    other: Option<(u32, usize)>,
}

/// Refuses rows beyond the end of the vertices.
fn are_vertices(mesh: &Mesh<'_>, rows: &[u32]) -> Result<(), Refusal> {
    let beyond = rows.iter().find(|&&row| row as usize >= mesh.vertices.len());
    beyond.map_or(Ok(()), |&row| Err(Refusal::NoSuchRow { what: "vertex", row }))
}

/// Corners of a triangle, if there is one in that row.
fn corners_at(mesh: &Mesh<'_>, triangle: u32) -> Result<[u32; 3], Refusal> {
    let corners = mesh.triangles.corners.get(triangle as usize);
    corners.copied().ok_or(Refusal::NoSuchRow { what: "triangle", row: triangle })
}

fn edge_sides(mesh: &Mesh<'_>, triangle: u32, edge: usize) -> Result<EdgeSides, Refusal> {
    let corners = corners_at(mesh, triangle)?;
    if edge > 2 {
        return Err(Refusal::NoSuchEdge { from: NONE, to: NONE });
    }
    let (from, to, opposite) = (corners[edge], corners[(edge + 1) % 3], corners[(edge + 2) % 3]);
    let other = match mesh.topology.neighbours[triangle as usize][edge] {
        NONE => None,
        _ => mesh.topology.directed_edge(&mesh.triangles.corners, to, from),
    };
    Ok(EdgeSides { from, to, opposite, other })
}

fn open_interval(weight: f64) -> Result<(), Refusal> {
    if weight > 0.0 && weight < 1.0 { Ok(()) } else { Err(Refusal::WeightOutOfRange { weight }) }
}

/// Refuses barycentric weights whose sum differs from 1 by more than the few roundings of a division by their sum.
fn sum_to_one(weights: [f64; 3]) -> Result<(), Refusal> {
    let sum: f64 = weights.iter().sum();
    if (sum - 1.0).abs() <= 1e-14 { Ok(()) } else { Err(Refusal::WeightOutOfRange { weight: sum }) }
}

/// The vertices before and after one along the boundary; `None` for a vertex inside.
fn beside_on_boundary(mesh: &Mesh<'_>, vertex: u32) -> Option<[u32; 2]> {
    let fan = mesh.topology.fan(vertex);
    let (&(first, i), &(last, j)) = (fan.sectors.first()?, fan.sectors.last()?);
    let corners = &mesh.triangles.corners;
    (!fan.is_closed).then(|| [corners[last as usize][(j + 2) % 3], corners[first as usize][(i + 1) % 3]])
}

fn new_vertex(mesh: &Mesh<'_>, parents: Parents) -> (Parents, VertexRow) {
    let v = &*mesh.vertices;
    let row = VertexRow {
        position: parents.blend(|r| v.position[r as usize]),
        velocity: parents.blend(|r| v.velocity[r as usize]),
        rest_position: parents.blend(|r| v.rest_position[r as usize]),
        mass: 0.0,
    };
    (parents, row)
}

/// Rest and current corner positions, with `special` standing in for the vertex in row `row`.
fn corner_positions(mesh: &Mesh<'_>, corners: [u32; 3], row: u32, special: &VertexRow) -> ([DVec3; 3], [DVec3; 3]) {
    let v = &*mesh.vertices;
    let rest = corners.map(|c| if c == row { special.rest_position } else { v.rest_position[c as usize] });
    let now = corners.map(|c| if c == row { special.position } else { v.position[c as usize] });
    (rest, now)
}

/// The rest triangle of new corner positions; refused where the triangle turns over or has become a sliver with an angle
/// below the smallest of the triangles `old`.
fn checked_rest(
    row: u32,
    rest: [DVec3; 3],
    fibre: DVec3,
    old_normal: DVec3,
    old: impl Iterator<Item = [DVec3; 3]>,
) -> Result<RestTriangle, Refusal> {
    let shape = RestTriangle::new(rest, fibre).ok_or(Refusal::WouldInvert { triangle: row })?;
    if !same_side(normal(rest), old_normal) {
        return Err(Refusal::WouldInvert { triangle: row });
    }
    let angle = SmallestAngle::new(rest);
    let is_worse = || SmallestAngle::among(old).is_none_or(|old| angle.is_smaller_than(&old));
    if angle.is_below_tangent_sq(SLIVER_TANGENT_SQ) && is_worse() {
        return Err(Refusal::WouldMakeSliver { angle: angle.radians() });
    }
    Ok(shape)
}

/// A normal of a triangle with twice its area as length.
fn normal(x: [DVec3; 3]) -> DVec3 {
    (x[1] - x[0]).cross(x[2] - x[0])
}

fn rest_of(mesh: &Mesh<'_>, triangle: u32) -> [DVec3; 3] {
    rest_corners(mesh.vertices, mesh.triangles.corners[triangle as usize])
}

fn current_of(mesh: &Mesh<'_>, triangle: u32) -> [DVec3; 3] {
    mesh.triangles.corners[triangle as usize].map(|c| mesh.vertices.position[c as usize])
}

/// Whether two normals point to the same side; `false` where one of them is not finite.
fn same_side(a: DVec3, b: DVec3) -> bool {
    a.dot(b) > 0.0
}

/// Corrects the densities of changed triangles where their mass is no longer `mass`. On a curved surface flips, slides, glides
/// and collapses change the area at second order in the edge length, and between unequal triangles they carry thickness along.
fn keep_mass(changed: &mut [(u32, TriangleRow)], mass: f64) {
    let present: f64 = changed.iter().map(|(_, row)| triangle_mass(row)).sum();
    if (present - mass).abs() > MASS_ROUNDING * mass {
        for (_, row) in changed {
            row.density *= mass / present;
        }
    }
}

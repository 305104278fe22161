//! Flips that raise the smallest angle (Lawson 1977), near recent edits and only where an angle is poor: a flip interpolates
//! the state again, so good triangles are left alone.

use crate::math::{SmallestAngle, elementary};
use crate::storage::{Edit, Mesh, NONE};
use crate::systems::fracture::Cutter;
use glam::DVec3;
use smallvec::SmallVec;

/// Cosine of the largest angle between the normals of two triangles in the rest shape that may be flipped, and between
/// those around a vertex that may be moved and their mean: 20°.
const COPLANAR: f64 = 0.939_692_620_785_908_4;
/// A flip must gain this \[rad\] (about 1°).
const FLIP_GAIN: f64 = 0.02;
/// Flips per event; a run-away would be a defect of the mesh, not of the tear.
const MOST_FLIPS: usize = 24;

impl Cutter<'_, '_> {
    /// Flips edges around the triangles touched by the records from `start` on, except those along the path `keep`.
    pub(in crate::systems::fracture) fn relax(&mut self, start: usize, keep: &[u32]) {
        let mut pending: SmallVec<[u32; 32]> = SmallVec::new();
        for record in self.shaped(start) {
            let new = record.first_triangle..record.first_triangle + record.new_triangles.len() as u32;
            pending.extend(record.changed_triangles.iter().map(|c| c.row).chain(new));
        }
        pending.sort_unstable();
        pending.dedup();
        let mut flips = 0;
        let limit = elementary::powi(elementary::tan(self.quality.flip), 2);
        let is_poor = |cutter: &Self, triangle| SmallestAngle::new(cutter.rest_of(triangle)).is_below_tangent_sq(limit);
        while let Some(triangle) = pending.pop() {
            let is_poor_itself = is_poor(self, triangle);
            for edge in 0..3 {
                // Most pairs are good, and found so without an arctangent.
                let other = self.mesh.topology.neighbours[triangle as usize][edge];
                if other == NONE
                    || !(is_poor_itself || is_poor(self, other))
                    || !self.is_useful_flip((triangle, edge), other, keep)
                {
                    continue;
                }
                if flips < MOST_FLIPS && self.edit(&Edit::Flip { triangle, edge }).is_ok() {
                    flips += 1;
                    pending.extend([triangle, other]);
                    break;
                }
            }
        }
    }

    /// Whether the flip of the edge between a triangle and another would raise the smallest angle of the two.
    fn is_useful_flip(&self, (triangle, edge): (u32, usize), other: u32, keep: &[u32]) -> bool {
        let triangles = &*self.mesh.triangles;
        let corners = triangles.corners[triangle as usize];
        let (u, v, o) = (corners[edge], corners[(edge + 1) % 3], corners[(edge + 2) % 3]);
        if keep.windows(2).any(|edge| *edge == [u, v] || *edge == [v, u]) {
            return false;
        }
        let Some(p) = triangles.corners[other as usize].into_iter().find(|&c| c != u && c != v) else { return false };
        let [u, v, o, p] = [u, v, o, p].map(|row| self.mesh.vertices.rest_position[row as usize]);
        let old = SmallestAngle::new([u, v, o]).or_smaller(SmallestAngle::new([v, u, p]));
        let new = SmallestAngle::new([u, p, o]).or_smaller(SmallestAngle::new([v, o, p]));
        if new.is_smaller_than(&old) || new.radians() <= old.radians() + FLIP_GAIN {
            return false;
        }
        let (n, m) = (normal(u, v, o), normal(v, u, p));
        let is_convex = normal(u, p, o).dot(n) > 0.0 && normal(v, o, p).dot(n) > 0.0;
        is_convex && are_coplanar(n, m) && triangles.at(triangle).is_alike(&triangles.at(other))
    }
}

/// Whether the edge between two triangles may be flipped as far as shape and material go: no ridge, no border of materials.
pub(in crate::systems::fracture) fn may_flip(mesh: &Mesh, triangle: u32, other: u32) -> bool {
    let normal_of = |t: u32| {
        let [a, b, c] = mesh.triangles.corners[t as usize].map(|v| mesh.vertices.rest_position[v as usize]);
        normal(a, b, c)
    };
    are_coplanar(normal_of(triangle), normal_of(other))
        && mesh.triangles.at(triangle).is_alike(&mesh.triangles.at(other))
}

fn are_coplanar(n: DVec3, m: DVec3) -> bool {
    n.dot(m) >= COPLANAR * n.length() * m.length()
}

/// Whether a vertex may be moved in the rest surface: it lies inside, where that is nearly flat. Moving a corner or a ridge
/// takes off the protruding part: an octahedron lost a quarter of its area.
pub(in crate::systems::fracture) fn may_slide(mesh: &Mesh, vertex: u32) -> bool {
    is_flat(mesh, vertex) && !mesh.topology.is_boundary_vertex(vertex)
}

/// Whether the rest surface is nearly flat around a vertex.
pub(in crate::systems::fracture) fn is_flat(mesh: &Mesh, vertex: u32) -> bool {
    let corners_of = |t: u32| mesh.triangles.corners[t as usize].map(|v| mesh.vertices.rest_position[v as usize]);
    let around = &mesh.topology.incident[vertex as usize];
    let normals: SmallVec<[DVec3; 12]> =
        around.iter().map(|&entry| corners_of(entry / 3)).map(|[a, b, c]| normal(a, b, c)).collect();
    let mean: DVec3 = normals.iter().sum();
    normals.iter().all(|n| are_coplanar(*n, mean))
}

fn normal(a: DVec3, b: DVec3, c: DVec3) -> DVec3 {
    (b - a).cross(c - a)
}

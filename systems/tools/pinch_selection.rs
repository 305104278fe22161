//! Vertices taken by jaws: the surface that hangs together with the place where they close, as far as their radius reaches.
//!
//! The lips of a cut lie beside each other in the rest shape and are no neighbours, so that distance alone would take both.

use crate::storage::{NONE, Topology, Triangles, Vertices};
use crate::systems::kernels::pick;
use glam::DVec3;
use smallvec::{SmallVec, smallvec};

/// The vertices that jaws take, rows ascending, the nearest of them apart. Jaws close in the middle of a course, where steps
/// allocate nothing: there is room for the vertices that small jaws take of a refined mesh.
pub struct PinchSelection {
    /// The vertex nearest to the place; of equally near ones the lowest row.
    pub nearest: u32,
    /// All of them.
    pub rows: SmallVec<[u32; 512]>,
}

impl PinchSelection {
    /// Walks from a triangle to all that hang together with it within a radius \[mm, rest shape\] about a place, and to the nearest vertex in
    /// any case. Without a triangle, from the one that is nearest to the place in the rest shape. `None` for a body without triangles.
    pub fn about(
        (vertices, triangles, topology): (&Vertices, &Triangles, &Topology),
        (place, from): (DVec3, Option<u32>),
        radius: f64,
    ) -> Option<Self> {
        let rest = &vertices.rest_position;
        let first = match from {
            Some(first) => first,
            None => pick::nearest(rest, &triangles.corners, place, f64::INFINITY)?.triangle,
        };
        let distance_sq = |v: u32| rest[v as usize].distance_squared(place);
        let nearest_sq = (0..vertices.len() as u32).map(distance_sq).fold(f64::INFINITY, f64::min);
        let radius_sq = radius * radius;
        let reach_sq = radius_sq.max(nearest_sq);
        let mut walked: SmallVec<[u32; 1024]> = smallvec![first];
        let mut open: SmallVec<[u32; 256]> = smallvec![first];
        let mut rows: SmallVec<[u32; 512]> = SmallVec::new();
        while let Some(t) = open.pop() {
            let corners = triangles.corners[t as usize];
            for e in 0..3 {
                let [a, b] = [corners[e], corners[(e + 1) % 3]];
                if let Err(at) = rows.binary_search(&a) {
                    rows.insert(at, a);
                }
                let across = topology.neighbours[t as usize][e];
                let meets = || to_segment_sq(place, rest[a as usize], rest[b as usize]) <= reach_sq;
                if across != NONE
                    && meets()
                    && let Err(at) = walked.binary_search(&across)
                {
                    walked.insert(at, across);
                    open.push(across);
                }
            }
        }
        let nearest = rows.iter().copied().min_by(|&a, &b| distance_sq(a).total_cmp(&distance_sq(b)))?;
        rows.retain(|v| *v == nearest || distance_sq(*v) <= radius_sq);
        Some(Self { nearest, rows })
    }
}

/// Squared distance of a point from a segment.
fn to_segment_sq(point: DVec3, a: DVec3, b: DVec3) -> f64 {
    let (along, from) = (b - a, point - a);
    let part = (from.dot(along) / along.length_squared()).clamp(0.0, 1.0);
    from.distance_squared(along * part)
}

//! How the rows of a level hang on the nodes of the next coarser one.
//!
//! A row takes the values of three nodes by the weights of its place in their triangle, in its own tangent plane of the rest shape.
//! Linear fields are reproduced there, so rigid motions are, and no chart of the surface is needed. Among the triangles of nodes
//! within two edges it is the one of least Σ w·d², which on a plane is that of Delaunay. Distances d are along edges: a node on the
//! far side of a tear is far, or out of reach.

use super::super::pattern::BlockPattern;
use super::coarsen::NO_NODE;
use crate::systems::parallel;
use glam::{DVec2, DVec3};
use smallvec::SmallVec;

/// A row's nodes and their weights, which sum to one; unused ones have weight zero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Parts {
    /// Nodes.
    pub node: [u32; 3],
    /// Weights.
    pub weight: [f32; 3],
}

impl Parts {
    /// The nodes that count.
    #[inline(always)]
    pub(super) fn iter(&self) -> impl Iterator<Item = (usize, f32)> {
        (0..3).filter(|&i| self.weight[i] != 0.0).map(|i| (self.node[i] as usize, self.weight[i]))
    }
}

/// A row on the rest surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Place {
    /// Rest position \[mm\].
    pub position: DVec3,
    /// Normal, of any length.
    pub normal: DVec3,
}

/// Nodes that are looked at, the nearest.
const MOST_NEAR: usize = 10;

/// A weight outside of its triangle counts so many times: only where no triangle of nodes has the row inside.
const OUTSIDE_WEIGHT: f64 = 20.0;

/// No weight is larger.
const MOST_WEIGHT: f64 = 1.6;

/// A node near a row.
#[derive(Clone, Copy, Debug)]
struct Near {
    node: u32,
    row: u32,
    /// Along edges \[mm\].
    distance: f64,
    /// In the row's tangent plane, from the row.
    place: DVec2,
}

/// Finds the weights anew. `node` says which rows are nodes.
pub(super) fn rebuild(parts: &mut Vec<Parts>, pattern: &BlockPattern, places: &[Place], node: &[u32]) {
    super::super::empty(parts, node.len());
    parts.resize(node.len(), Parts::default());
    refresh(parts, pattern, places, node, |_| true);
}

/// Finds those of some rows anew.
pub(super) fn refresh(
    parts: &mut [Parts],
    pattern: &BlockPattern,
    places: &[Place],
    node: &[u32],
    is_stale: impl Fn(usize) -> bool + Sync,
) {
    parallel::for_rows(parts, |row, parts| {
        if !is_stale(row) {
            return;
        }
        *parts = match node[row] {
            NO_NODE => of_row(pattern, places, node, row),
            own => Parts { node: [own; 3], weight: [1.0, 0.0, 0.0] },
        };
    });
}

fn of_row(pattern: &BlockPattern, places: &[Place], node: &[u32], row: usize) -> Parts {
    let mut near: SmallVec<[Near; 32]> = SmallVec::new();
    let own = places[row];
    let axis = own.normal.any_orthogonal_vector().normalize_or(DVec3::X);
    let other = own.normal.cross(axis).normalize_or(DVec3::Y);
    let mut meet = |row: u32, distance: f64| {
        let known = node[row as usize];
        if known == NO_NODE {
            return;
        }
        match near.iter_mut().find(|near| near.node == known) {
            Some(near) => near.distance = near.distance.min(distance),
            None => {
                let from = places[row as usize].position - own.position;
                near.push(Near { node: known, row, distance, place: DVec2::new(from.dot(axis), from.dot(other)) });
            }
        }
    };
    for middle in pattern.neighbours(row) {
        let at = places[middle as usize].position;
        let first = at.distance(own.position);
        meet(middle, first);
        // The way back to the row itself is left out.
        for far in pattern.neighbours(middle as usize).filter(|&far| far as usize != row) {
            meet(far, first + at.distance(places[far as usize].position));
        }
    }
    // By rows where nodes are as far: those of the nodes change as they are given theirs.
    near.sort_unstable_by(|a, b| a.distance.total_cmp(&b.distance).then(a.row.cmp(&b.row)));
    near.truncate(MOST_NEAR);
    best(&near)
}

/// The triangle of least cost; where there is none, the nearest node alone.
fn best(near: &[Near]) -> Parts {
    let Some(first) = near.first() else { return Parts::default() };
    let mut least = f64::INFINITY;
    let mut parts = Parts { node: [first.node; 3], weight: [1.0, 0.0, 0.0] };
    let cost = |i: usize, w: f64| near[i].distance * near[i].distance * if w < 0.0 { -OUTSIDE_WEIGHT * w } else { w };
    for k in 2..near.len() {
        for j in 1..k {
            let jk = near[j].place.perp_dot(near[k].place);
            for i in 0..j {
                let ki = near[k].place.perp_dot(near[i].place);
                let ij = near[i].place.perp_dot(near[j].place);
                let area = jk + ki + ij;
                let w = [jk / area, ki / area, ij / area];
                if !w.iter().all(|w| w.abs() <= MOST_WEIGHT) {
                    continue;
                }
                // A ten-thousandth of weight is rounding in a position; it is not worth a node.
                let w = w.map(|w| if w.abs() < 1e-4 { 0.0 } else { w });
                let total = cost(i, w[0]) + cost(j, w[1]) + cost(k, w[2]);
                if total < least {
                    least = total;
                    parts = Parts { node: [near[i].node, near[j].node, near[k].node], weight: w.map(|w| w as f32) };
                }
            }
        }
    }
    parts
}

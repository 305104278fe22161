//! Search for pairs that may touch: a tree over the triangles, along a curve through their centroids.
//!
//! A pair is left out where a vertex of one part lies within the band of one of the other in the rest shape: neighbours, and the lips of a
//! tear, which begin at distance zero. The tree finds more pairs than touch; the others do not act on the result, for pairs are sorted by rows before
//! anything is summed.

use super::closest::crosses;
use crate::components::{Layers, Pair};
use crate::storage::{NONE, Topology, Triangles, Vertices};
use glam::DVec3;

/// Triangles in a leaf.
const LEAF: usize = 4;

/// Maximum number of pairs per triangle, and in addition: crumpled tissue that moves by its own size in a step moves as one.
const MOST_PER_TRIANGLE: usize = 64;
const MOST_BESIDE: usize = 10_000;

/// Cells of the curve along an axis, as a power of two.
const CURVE_BITS: u32 = 10;

/// A box around points.
#[derive(Clone, Copy)]
struct Bounds {
    low: DVec3,
    high: DVec3,
}

impl Bounds {
    fn join(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    fn meets(&self, other: &Self) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }
}

/// A body as it moves from one state to another.
pub(super) struct Sweep<'a> {
    pub vertices: &'a Vertices,
    pub triangles: &'a Triangles,
    pub topology: &'a Topology,
    /// Positions at the start \[mm\]; those at the end are the vertices'.
    pub start: &'a [DVec3],
    /// Distance \[mm\] within which parts are paired.
    pub reach: f64,
    /// Rest distance \[mm\] within which they are not.
    pub band: f64,
}

impl Sweep<'_> {
    /// Finds the pairs whose ways come within reach, and counts the pairs of triangles that cross at the start, which are left out. Pairs of
    /// the search before serve where that was of these ways, or of ways to here that were all proved apart: then there are more than are asked for.
    pub(super) fn find(&self, layers: &mut Layers) {
        let Self { vertices, triangles, start, .. } = self;
        let (x, corners) = (&vertices.position, &triangles.corners);
        let within = [self.reach, self.band];
        let is_here = layers.found_to == *x && layers.found_of == *corners && layers.found_within == within;
        if is_here && (layers.found_from == *start || *start == x && layers.are_apart && layers.overlapping == 0) {
            return;
        }
        layers.are_apart = false;
        layers.found_from.clear();
        layers.found_from.extend_from_slice(start);
        layers.found_to.clone_from(x);
        layers.found_of.clone_from(corners);
        layers.found_within = within;
        self.search(layers);
    }

    fn search(&self, layers: &mut Layers) {
        let Self { vertices, triangles, start, reach, .. } = self;
        layers.pairs.clear();
        (layers.overlapping, layers.are_too_many) = (0, false);
        let count = triangles.len();
        if count < 2 {
            return;
        }
        if layers.order.len() != count {
            layers.order = along_curve(&vertices.position, &triangles.corners);
        }
        let inflated = DVec3::splat(0.5 * reach);
        let of_vertex: Vec<Bounds> = (start.iter().zip(&vertices.position))
            .map(|(a, b)| Bounds { low: a.min(*b) - inflated, high: a.max(*b) + inflated })
            .collect();
        let of_triangle = |t: &u32| {
            let [a, b, c] = triangles.corners[*t as usize].map(|v| of_vertex[v as usize]);
            a.join(b).join(c)
        };
        let rest = |t: &u32| triangles.corners[*t as usize].map(|v| vertices.rest_position[v as usize]);
        let search = Search {
            sweep: self,
            leaves: layers.order.iter().map(of_triangle).collect(),
            rest: layers.order.iter().map(rest).collect(),
            of_vertex,
        };
        let levels = levels(&search.leaves);
        let mut stack = vec![(levels.len() - 1, 0_usize, 0_usize)];
        let most = MOST_PER_TRIANGLE * count + MOST_BESIDE;
        while let Some((level, i, j)) = stack.pop() {
            if layers.pairs.len() > most {
                layers.are_too_many = true;
                layers.pairs.clear();
                return;
            }
            let nodes = &levels[level];
            if !nodes[i].meets(&nodes[j]) {
                continue;
            }
            if level == 0 {
                search.leaf_pairs([i, j], layers);
                continue;
            }
            let below = levels[level - 1].len();
            for a in 2 * i..(2 * i + 2).min(below) {
                for b in 2 * j..(2 * j + 2).min(below) {
                    if i != j || a <= b {
                        stack.push((level - 1, a, b));
                    }
                }
            }
        }
        layers.pairs.sort_unstable();
    }

    /// Whether a triangle is the one that speaks for a vertex, or an edge.
    fn owns_vertex(&self, t: u32, corner: usize) -> bool {
        let v = self.triangles.corners[t as usize][corner];
        self.topology.incident[v as usize].first().is_some_and(|first| first / 3 == t)
    }

    fn owns_edge(&self, t: u32, edge: usize) -> bool {
        let other = self.topology.neighbours[t as usize][edge];
        other == NONE || other > t
    }

    /// Whether two triangles cross at the start.
    fn cross(&self, [t, u]: [u32; 2]) -> bool {
        let [c, d] = [t, u].map(|t| self.triangles.corners[t as usize].map(|v| self.start[v as usize]));
        let edges = |[a, b, c]: [DVec3; 3]| [[a, b], [b, c], [c, a]];
        edges(c).iter().any(|edge| crosses(*edge, d)) || edges(d).iter().any(|edge| crosses(*edge, c))
    }
}

/// A search under way. Lists of triangles are in the order of the curve.
struct Search<'a> {
    sweep: &'a Sweep<'a>,
    of_vertex: Vec<Bounds>,
    leaves: Vec<Bounds>,
    /// Corners in the rest shape \[mm\].
    rest: Vec<[DVec3; 3]>,
}

impl Search<'_> {
    /// Pairs of the triangles in two leaves, or in one.
    fn leaf_pairs(&self, [i, j]: [usize; 2], layers: &mut Layers) {
        let range = |leaf: usize| leaf * LEAF..((leaf + 1) * LEAF).min(self.leaves.len());
        let band_sq = self.sweep.band * self.sweep.band;
        for a in range(i) {
            for b in range(j) {
                if i == j && a >= b || !self.leaves[a].meets(&self.leaves[b]) {
                    continue;
                }
                let [a, b] = if layers.order[a] < layers.order[b] { [a, b] } else { [b, a] };
                let near = self.rest[a].map(|p| self.rest[b].map(|q| p.distance_squared(q) <= band_sq));
                if near != [[true; 3]; 3] {
                    self.triangle_pairs([a, b], near, layers);
                }
            }
        }
    }

    /// Pairs of two triangles. `near` are those of their corners that may not touch.
    fn triangle_pairs(&self, [a, b]: [usize; 2], near: [[bool; 3]; 3], layers: &mut Layers) {
        let Self { sweep, of_vertex, leaves, .. } = self;
        let [t, u] = [layers.order[a], layers.order[b]];
        if near == [[false; 3]; 3] && sweep.cross([t, u]) {
            layers.overlapping += 1;
            return;
        }
        let [c, d] = [t, u].map(|t| sweep.triangles.corners[t as usize]);
        let is_in = |corner: u32, leaf: usize| of_vertex[corner as usize].meets(&leaves[leaf]);
        let pair = |vertex: u32, [a, b, c]: [u32; 3], triangle: u32| Pair {
            are_edges: false,
            rows: [vertex, a, b, c],
            triangle,
        };
        for k in 0..3 {
            if near[k] == [false; 3] && sweep.owns_vertex(t, k) && is_in(c[k], b) {
                layers.pairs.push(pair(c[k], d, u));
            }
            if !near.iter().any(|row| row[k]) && sweep.owns_vertex(u, k) && is_in(d[k], a) {
                layers.pairs.push(pair(d[k], c, t));
            }
        }
        for i in 0..3 {
            let i_next = (i + 1) % 3;
            let is_near = [0, 1, 2].map(|j| near[i][j] || near[i_next][j]);
            if is_near == [true; 3] || !sweep.owns_edge(t, i) {
                continue;
            }
            let of_first = of_vertex[c[i] as usize].join(of_vertex[c[i_next] as usize]);
            for j in 0..3 {
                let j_next = (j + 1) % 3;
                let meets = || of_first.meets(&of_vertex[d[j] as usize].join(of_vertex[d[j_next] as usize]));
                if !is_near[j] && !is_near[j_next] && sweep.owns_edge(u, j) && meets() {
                    let rows = [c[i], c[i_next], d[j], d[j_next]];
                    layers.pairs.push(Pair { are_edges: true, rows, triangle: u });
                }
            }
        }
    }
}

/// Boxes of the tree: of the leaves' triangles, then of two boxes each, up to the root.
fn levels(leaves: &[Bounds]) -> Vec<Vec<Bounds>> {
    let joined = |boxes: &[Bounds]| boxes[1..].iter().fold(boxes[0], |all, one| all.join(*one));
    let mut levels: Vec<Vec<Bounds>> = vec![leaves.chunks(LEAF).map(joined).collect()];
    while let Some(last) = levels.last().filter(|last| last.len() > 1) {
        let next = last.chunks(2).map(joined).collect();
        levels.push(next);
    }
    levels
}

/// Triangles by their centroids along a Morton curve.
fn along_curve(x: &[DVec3], corners: &[[u32; 3]]) -> Vec<u32> {
    let centroids = corners.iter().map(|corners| corners.map(|v| x[v as usize]).iter().sum::<DVec3>() / 3.0);
    let centroids: Vec<DVec3> = centroids.collect();
    let (low, high) =
        centroids.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
    let scale = f64::from((1_u32 << CURVE_BITS) - 1) / (high - low).max_element().max(f64::MIN_POSITIVE);
    let mut order: Vec<(u32, u32)> = (0..).zip(&centroids).map(|(t, p)| (morton((*p - low) * scale), t)).collect();
    order.sort_unstable();
    order.into_iter().map(|(_, t)| t).collect()
}

/// Place along the curve, whose bits are those of the axes in turns.
fn morton(p: DVec3) -> u32 {
    p.to_array().iter().enumerate().fold(0, |place, (axis, &part)| {
        let cell = part as u32;
        (0..CURVE_BITS).fold(place, |place, bit| place | (cell >> bit & 1) << (3 * bit + axis as u32))
    })
}

//! Search for pairs that may touch, among candidates.
//!
//! A pair is left out where a vertex of one part lies within the band of one of the other in the rest shape: neighbours, and the lips of a
//! tear, which begin at distance zero. The pairs of a sweep are the same whatever the candidates are, and sorted by rows before anything is summed.

use super::closest::crosses;
use crate::components::{Bounds, Candidate, Layers, Pair, PairStart};
use crate::storage::{NONE, Topology, Triangles, Vertices};
use glam::DVec3;

/// Maximum number of pairs, and of triangles that meet, per triangle, and in addition: crumpled tissue that moves by its own size in a step moves as one.
pub(super) const MOST_PER_TRIANGLE: usize = 64;
pub(super) const MOST_BESIDE: usize = 10_000;

/// Box tests that take as long as a pair's nearest points at the start.
const TESTS_PER_START: usize = 20;

/// Box tests of a search per triangle, beside those of triangles that meet.
const TESTS_PER_TRIANGLE: usize = 25;

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
        // Counted by the sweep alone, not by the memory of the search, which a restored world does not have.
        if *start == x {
            layers.tests += TESTS_PER_TRIANGLE * triangles.len();
        }
        let is_here = layers.found_to == *x && layers.found_of == *corners && layers.found_within == within;
        if is_here && layers.found_from == *start {
            return;
        }
        if is_here && *start == x && layers.are_apart && layers.overlapping == 0 {
            layers.found_from.clone_from(x);
            self.begin(layers);
            return;
        }
        layers.are_apart = false;
        layers.found_from.clear();
        layers.found_from.extend_from_slice(start);
        layers.found_to.clone_from(x);
        layers.found_of.clone_from(corners);
        layers.found_within = within;
        self.search(layers);
        if *start != x {
            let of_starts = TESTS_PER_START * layers.pairs.len();
            layers.tests += TESTS_PER_TRIANGLE * triangles.len() + layers.met + of_starts;
        }
    }

    /// Looks at the pairs as they are at the start.
    fn begin(&self, layers: &mut Layers) {
        let Layers { pairs, starts, .. } = layers;
        starts.clear();
        starts.extend(pairs.iter().map(|pair| {
            let way = pair.nearest(self.start).way;
            let distance = way.length();
            PairStart { normal: way / distance, distance }
        }));
    }

    fn search(&self, layers: &mut Layers) {
        let corners = &self.triangles.corners;
        layers.pairs.clear();
        layers.starts.clear();
        (layers.overlapping, layers.met, layers.are_too_many) = (0, 0, false);
        if corners.len() < 2 {
            return;
        }
        let inflated = DVec3::splat(0.5 * self.reach);
        let ways = self.start.iter().zip(&self.vertices.position);
        let of_vertex: Vec<Bounds> =
            ways.map(|(a, b)| Bounds { low: a.min(*b) - inflated, high: a.max(*b) + inflated }).collect();
        let Layers { candidates, order, .. } = layers;
        if !self.may_serve(candidates, &of_vertex) {
            self.renew(candidates, order, &of_vertex);
        }
        let of_triangle = corners.iter().map(|corners| Bounds::of_triangle(&of_vertex, *corners)).collect();
        let ways = Ways { sweep: self, of_vertex, of_triangle };
        let most = MOST_PER_TRIANGLE * corners.len() + MOST_BESIDE;
        let candidates = std::mem::take(&mut layers.candidates);
        for Candidate { rows, near } in &candidates.list {
            let [t, u] = rows.map(|t| t as usize);
            if !ways.of_triangle[t].meets(&ways.of_triangle[u]) {
                continue;
            }
            layers.met += 1;
            ways.triangle_pairs(*rows, near, layers);
            if layers.pairs.len().max(layers.met) > most {
                break;
            }
        }
        layers.are_too_many = candidates.are_too_many || layers.pairs.len().max(layers.met) > most;
        layers.candidates = candidates;
        if layers.are_too_many {
            layers.met = most;
            layers.pairs.clear();
        }
        layers.pairs.sort_unstable();
        self.begin(layers);
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

/// Boxes around the ways of a sweep.
struct Ways<'a> {
    sweep: &'a Sweep<'a>,
    of_vertex: Vec<Bounds>,
    of_triangle: Vec<Bounds>,
}

impl Ways<'_> {
    /// Pairs of two triangles. `near` are those of their corners that may not touch.
    fn triangle_pairs(&self, [t, u]: [u32; 2], near: &[[bool; 3]; 3], layers: &mut Layers) {
        let Self { sweep, of_vertex, of_triangle } = self;
        if *near == [[false; 3]; 3] && sweep.cross([t, u]) {
            layers.overlapping += 1;
            return;
        }
        let [c, d] = [t, u].map(|t| sweep.triangles.corners[t as usize]);
        let is_in = |corner: u32, t: u32| of_vertex[corner as usize].meets(&of_triangle[t as usize]);
        let pair = |vertex: u32, [a, b, c]: [u32; 3], triangle: u32| Pair {
            are_edges: false,
            rows: [vertex, a, b, c],
            triangle,
        };
        for k in 0..3 {
            if near[k] == [false; 3] && sweep.owns_vertex(t, k) && is_in(c[k], u) {
                layers.pairs.push(pair(c[k], d, u));
            }
            if !near.iter().any(|row| row[k]) && sweep.owns_vertex(u, k) && is_in(d[k], t) {
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

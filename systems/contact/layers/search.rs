//! Search for pairs that may touch, among candidates.
//!
//! A pair is left out where a vertex of one part is one of the other, or lies within the band of it in the rest shape, as on the lips of a tear, which
//! begin at distance zero. Pairs do not depend on the candidates, and are sorted by rows before anything is summed.

use super::candidates::near;
use super::closest::cross;
use crate::components::{Bounds, Candidate, Layers, Pair, PairStart};
use crate::storage::{NONE, Topology};
use glam::DVec3;

/// Maximum number of pairs, and of triangles that meet, per triangle, and in addition: crumpled tissue that moves by its own size in a step moves as one.
pub(super) const MOST_PER_TRIANGLE: usize = 64;
pub(super) const MOST_BESIDE: usize = 10_000;

/// Box tests that take as long as a pair's nearest points at the start.
const TESTS_PER_START: usize = 20;

/// Box tests of a search per triangle, beside those of triangles that meet.
const TESTS_PER_TRIANGLE: usize = 25;

/// A surface as it moves from one state to another.
pub(super) struct Sweep<'a> {
    /// Positions of the vertices at the end, at the start, and at rest \[mm\].
    pub x: &'a [DVec3],
    pub start: &'a [DVec3],
    pub rest: &'a [DVec3],
    pub corners: &'a [[u32; 3]],
    pub owners: Owners<'a>,
    /// Body of every vertex, where parts of different bodies alone are paired.
    pub between: Option<&'a [u32]>,
    /// Distance \[mm\] within which parts are paired.
    pub reach: f64,
    /// Rest distance \[mm\] within which they are not.
    pub band: f64,
}

/// Triangles that speak for the vertices and edges that they share with others.
#[derive(Clone, Copy)]
pub(super) enum Owners<'a> {
    /// The first triangle of each, by the topology of a body.
    Of(&'a Topology),
    /// By triangle, a bit for each of its vertices and then edges.
    Listed(&'a [u8]),
}

impl Owners<'_> {
    /// Ownership of a vertex, the row `v`, by one of its triangles.
    fn vertex(self, t: u32, (corner, v): (usize, u32)) -> bool {
        match self {
            Self::Of(topology) => topology.incident[v as usize].first().is_some_and(|first| first / 3 == t),
            Self::Listed(bits) => bits[t as usize] >> corner & 1 == 1,
        }
    }

    fn edge(self, t: u32, edge: usize) -> bool {
        match self {
            Self::Of(topology) => {
                let other = topology.neighbours[t as usize][edge];
                other == NONE || other > t
            }
            Self::Listed(bits) => bits[t as usize] >> (3 + edge) & 1 == 1,
        }
    }

    /// The bits of a triangle of a body.
    pub(super) fn bits(topology: &Topology, t: u32, corners: &[u32; 3]) -> u8 {
        let own = Owners::Of(topology);
        (0..3).fold(0, |bits, k| {
            bits | u8::from(own.vertex(t, (k, corners[k]))) << k | u8::from(own.edge(t, k)) << (3 + k)
        })
    }
}

impl Sweep<'_> {
    /// Finds the pairs whose ways come within reach, and counts the pairs of triangles that cross at the start, which are left out. Pairs of
    /// the search before serve where that was of these ways, or of ways to here that were all proved apart: then there are more than are asked for.
    pub(super) fn find(&self, layers: &mut Layers) {
        let Self { x, start, corners, .. } = *self;
        let (within, between) = ([self.reach, self.band], self.between.is_some());
        // Counted by the sweep alone, not by the memory of the search, which a restored world does not have.
        if start == x {
            layers.tests += TESTS_PER_TRIANGLE * corners.len();
        }
        let is_alike = layers.found_within == within && layers.found_between == between;
        let is_here = is_alike && layers.found_to == x && layers.found_of == corners;
        if is_here && layers.found_from == start {
            return;
        }
        if is_here && start == x && layers.are_apart && layers.crossed.is_empty() {
            layers.found_from.clear();
            layers.found_from.extend_from_slice(x);
            self.begin(layers);
            return;
        }
        layers.are_apart = false;
        layers.found_from.clear();
        layers.found_from.extend_from_slice(start);
        layers.found_to.clear();
        layers.found_to.extend_from_slice(x);
        layers.found_of.clear();
        layers.found_of.extend_from_slice(corners);
        (layers.found_within, layers.found_between) = (within, between);
        self.search(layers);
        if start != x {
            let of_starts = TESTS_PER_START * layers.pairs.len();
            layers.tests += TESTS_PER_TRIANGLE * corners.len() + layers.met + of_starts;
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
        let corners = self.corners;
        layers.pairs.clear();
        layers.starts.clear();
        layers.crossed.clear();
        (layers.met, layers.are_too_many) = (0, false);
        if corners.len() < 2 {
            return;
        }
        let inflated = DVec3::splat(0.5 * self.reach);
        let ways = self.start.iter().zip(self.x);
        let of_vertex: Vec<Bounds> =
            ways.map(|(a, b)| Bounds { low: a.min(*b) - inflated, high: a.max(*b) + inflated }).collect();
        let Layers { candidates, order, .. } = layers;
        if !self.may_serve(candidates, &of_vertex) {
            self.renew(candidates, order, &of_vertex);
        }
        let of_triangle = corners.iter().map(|corners| Bounds::of_triangle(&of_vertex, *corners)).collect();
        let faces = [self.start, self.x].map(|x| corners.iter().map(|corners| Face::new(*corners, x)).collect());
        let ways = Ways { sweep: self, of_vertex, of_triangle, faces };
        let most = MOST_PER_TRIANGLE * corners.len() + MOST_BESIDE;
        let candidates = std::mem::take(&mut layers.candidates);
        for Candidate { rows, near } in &candidates.list {
            let [t, u] = rows.map(|t| t as usize);
            let is_of_one = |bodies: &[u32]| bodies[corners[t][0] as usize] == bodies[corners[u][0] as usize];
            if !ways.of_triangle[t].meets(&ways.of_triangle[u]) || self.between.is_some_and(is_of_one) {
                continue;
            }
            layers.met += 1;
            ways.triangle_pairs(*rows, near, layers);
            if layers.pairs.len().max(layers.met) > most {
                break;
            }
        }
        if self.between.is_none() {
            ways.pairs_of_fans(layers);
        }
        layers.are_too_many = candidates.are_too_many || layers.pairs.len().max(layers.met) > most;
        layers.candidates = candidates;
        if layers.are_too_many {
            layers.met = most;
            layers.pairs.clear();
        }
        layers.crossed.sort_unstable();
        self.leave_out_crossed(layers);
        layers.pairs.sort_unstable();
        self.begin(layers);
    }

    /// Whether two triangles cross at the start.
    fn cross(&self, triangles: [u32; 2]) -> bool {
        cross(triangles.map(|t| self.corners[t as usize].map(|v| self.start[v as usize])))
    }

    /// Leaves out pairs at the vertices of triangles that cross: held on the sides where they are now, these could never part.
    fn leave_out_crossed(&self, layers: &mut Layers) {
        let Layers { pairs, crossed, .. } = layers;
        let of = |t: u32| self.corners[t as usize];
        let both = |&[t, u]: &[u32; 2]| of(t).into_iter().flat_map(move |v| of(u).map(|w| [v.min(w), v.max(w)]));
        let mut near: Vec<[u32; 2]> = crossed.iter().flat_map(both).collect();
        if near.is_empty() {
            return;
        }
        near.sort_unstable();
        near.dedup();
        pairs.retain(|pair| {
            let (first, second) = pair.rows.split_at(pair.first());
            let mut ends = first.iter().flat_map(|v| second.iter().map(|w| [*v.min(w), *v.max(w)]));
            !ends.any(|ends| near.binary_search(&ends).is_ok())
        });
    }
}

/// Boxes around the ways of a sweep, and its triangles at the start and at the end.
struct Ways<'a> {
    sweep: &'a Sweep<'a>,
    of_vertex: Vec<Bounds>,
    of_triangle: Vec<Bounds>,
    faces: [Vec<Face>; 2],
}

/// The triangles at every vertex, in their order.
struct Fans {
    first: Vec<u32>,
    triangles: Vec<u32>,
}

impl Fans {
    fn new(count: usize, corners: &[[u32; 3]]) -> Self {
        let mut first = vec![0; count + 1];
        corners.as_flattened().iter().for_each(|&v| first[v as usize + 1] += 1);
        (0..count).for_each(|v| first[v + 1] += first[v]);
        let (mut next, mut triangles) = (first.clone(), vec![0; 3 * corners.len()]);
        for (t, of_triangle) in (0..).zip(corners) {
            for &v in of_triangle {
                triangles[next[v as usize] as usize] = t;
                next[v as usize] += 1;
            }
        }
        Self { first, triangles }
    }

    fn at(&self, v: usize) -> &[u32] {
        &self.triangles[self.first[v] as usize..self.first[v + 1] as usize]
    }
}

/// Three times the middle of a triangle \[mm\], and twice its area along its normal \[mm²\].
struct Face {
    middle: DVec3,
    normal: DVec3,
}

impl Face {
    fn new([a, b, c]: [u32; 3], x: &[DVec3]) -> Self {
        let [a, b, c] = [x[a as usize], x[b as usize], x[c as usize]];
        Self { middle: a + b + c, normal: (b - a).cross(c - a) }
    }
}

impl Ways<'_> {
    /// Whether no pair of two triangles comes within reach: a direction tells them apart at the start and at the end, or they have an edge in
    /// common and are at the end not folded beyond a right angle.
    fn are_told_apart(&self, [t, u]: [u32; 2], near: &[[bool; 3]; 3]) -> bool {
        let Self { sweep: Sweep { x, start, corners, reach, .. }, faces, .. } = self;
        let [c, d] = [corners[t as usize], corners[u as usize]];
        let [t, u] = [t as usize, u as usize];
        let near_count: u32 = near.as_flattened().iter().map(|is_near| u32::from(*is_near)).sum();
        if near_count > 1 {
            let has_edge = c.iter().filter(|v| d.contains(v)).count() == 2;
            return has_edge && faces[1][t].normal.dot(faces[1][u].normal) > 0.0;
        }
        // The corner near one of the other triangle touches no part that has it; all others lie beyond the whole triangle.
        let first = (0..3).find(|&k| near[k] != [false; 3]);
        let second = first.and_then(|first| (0..3).find(|&k| near[first][k]));
        faces.iter().any(|faces| {
            let way = faces[t].middle - faces[u].middle;
            let gap = reach * way.length();
            [start, x].iter().all(|x| {
                let heights =
                    |[a, b, c]: [u32; 3]| [way.dot(x[a as usize]), way.dot(x[b as usize]), way.dot(x[c as usize])];
                let (above, below) = (heights(c), heights(d));
                let lowest = above[0].min(above[1]).min(above[2]) - gap;
                let highest = below[0].max(below[1]).max(below[2]) + gap;
                (0..3).all(|k| (first == Some(k) || above[k] >= highest) && (second == Some(k) || below[k] <= lowest))
            })
        })
    }

    /// Pairs of triangles with a common vertex whose triangles do not all face one way at the end: where they do, none can meet another.
    fn pairs_of_fans(&self, layers: &mut Layers) {
        let Self { sweep: Sweep { x, corners, band, .. }, faces, .. } = self;
        let fans = Fans::new(x.len(), corners);
        let faces_one_way = |fan: &[u32]| {
            let normals = || fan.iter().map(|&t| faces[1][t as usize].normal);
            let sum: DVec3 = normals().sum();
            normals().all(|normal| normal.dot(sum) > 0.0)
        };
        let is_folded: Vec<bool> = (0..x.len()).map(|v| !faces_one_way(fans.at(v))).collect();
        for v in (0..x.len()).filter(|&v| is_folded[v]) {
            for (place, &t) in fans.at(v).iter().enumerate() {
                for &u in &fans.at(v)[..place] {
                    // Two triangles come up with the first folded vertex that they have in common.
                    let [c, d] = [t, u].map(|t| corners[t as usize]);
                    let is_earlier = |w: &u32| (*w as usize) < v && is_folded[*w as usize] && d.contains(w);
                    if !c.iter().any(is_earlier) {
                        layers.met += 1;
                        let near = near(&self.sweep.at_rest(u), &self.sweep.at_rest(t), band * band);
                        self.triangle_pairs([u, t], &near, layers);
                    }
                }
            }
        }
    }

    /// Pairs of two triangles. `near` are those of their corners that may not touch.
    fn triangle_pairs(&self, [t, u]: [u32; 2], near: &[[bool; 3]; 3], layers: &mut Layers) {
        let Self { sweep, of_vertex, of_triangle, .. } = self;
        if self.are_told_apart([t, u], near) {
            return;
        }
        if *near == [[false; 3]; 3] && sweep.cross([t, u]) {
            layers.crossed.push([t, u]);
            return;
        }
        let [c, d] = [t, u].map(|t| sweep.corners[t as usize]);
        let is_in = |corner: u32, t: u32| of_vertex[corner as usize].meets(&of_triangle[t as usize]);
        let pair = |vertex: u32, [a, b, c]: [u32; 3], triangle: u32| Pair {
            are_edges: false,
            rows: [vertex, a, b, c],
            triangle,
        };
        for k in 0..3 {
            if near[k] == [false; 3] && sweep.owners.vertex(t, (k, c[k])) && is_in(c[k], u) {
                layers.pairs.push(pair(c[k], d, u));
            }
            if !near.iter().any(|row| row[k]) && sweep.owners.vertex(u, (k, d[k])) && is_in(d[k], t) {
                layers.pairs.push(pair(d[k], c, t));
            }
        }
        for i in 0..3 {
            let i_next = (i + 1) % 3;
            let is_near = [0, 1, 2].map(|j| near[i][j] || near[i_next][j]);
            if is_near == [true; 3] || !sweep.owners.edge(t, i) {
                continue;
            }
            let of_first = of_vertex[c[i] as usize].join(of_vertex[c[i_next] as usize]);
            for j in 0..3 {
                let j_next = (j + 1) % 3;
                let meets = || of_first.meets(&of_vertex[d[j] as usize].join(of_vertex[d[j_next] as usize]));
                if !is_near[j] && !is_near[j_next] && sweep.owners.edge(u, j) && meets() {
                    let rows = [c[i], c[i_next], d[j], d[j_next]];
                    layers.pairs.push(Pair { are_edges: true, rows, triangle: u });
                }
            }
        }
    }
}

//! Candidates: pairs of triangles that may meet while their vertices stay in boxes somewhat larger than their ways, from a tree over the triangles along a
//! curve through their centroids.

use super::search::{MOST_BESIDE, MOST_PER_TRIANGLE, Sweep};
use crate::components::{Bounds, Candidate, Candidates};
use glam::DVec3;
use smallvec::SmallVec;

/// Relative rounding of a ball's radius.
const BALL_ROUNDING: f64 = 1e-12;

/// Triangles in a leaf.
const LEAF: usize = 4;

/// Further motion for which candidates are listed, over the reach, beside as much motion as there was.
const SLACK: f64 = 0.5;

/// Part of the triangles, as its inverse, above which all candidates are looked for again.
const NEW_PART: usize = 3;

/// Maximum number of candidates, over that of pairs.
const CANDIDATES: usize = 4;

/// Cells of the curve along an axis, as a power of two.
const CURVE_BITS: u32 = 10;

impl Bounds {
    pub(super) fn join(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    pub(super) fn meets(&self, other: &Self) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }

    pub(super) fn has(&self, point: DVec3) -> bool {
        self.low.cmple(point).all() && point.cmple(self.high).all()
    }

    fn holds(&self, other: &Self) -> bool {
        self.low.cmple(other.low).all() && other.high.cmple(self.high).all()
    }

    pub(super) fn of_triangle(of_vertex: &[Self], corners: [u32; 3]) -> Self {
        let [a, b, c] = corners.map(|v| of_vertex[v as usize]);
        a.join(b).join(c)
    }
}

/// A ball around points of the rest shape.
#[derive(Clone, Copy)]
struct Ball {
    centre: DVec3,
    radius: f64,
}

impl Ball {
    /// A ball around the corners of a triangle.
    fn around(corners: &[DVec3; 3]) -> Self {
        let centre = (corners[0] + corners[1] + corners[2]) / 3.0;
        let [a, b, c] = corners;
        let radius_sq = centre.distance_squared(*a).max(centre.distance_squared(*b)).max(centre.distance_squared(*c));
        Self { centre, radius: radius_sq.sqrt() * (1.0 + BALL_ROUNDING) }
    }

    /// A ball around two.
    fn join(self, other: Self) -> Self {
        let centre = 0.5 * (self.centre + other.centre);
        let half = 0.5 * self.centre.distance(other.centre);
        Self { centre, radius: (half + self.radius.max(other.radius)) * (1.0 + BALL_ROUNDING) }
    }

    /// Whether all points of one are within a distance of all points of the other.
    fn is_within(&self, other: &Self, distance: f64) -> bool {
        let reach = distance - self.radius - other.radius;
        reach >= 0.0 && self.centre.distance_squared(other.centre) <= reach * reach
    }

    /// Whether no point of one is within a distance of a point of the other.
    fn is_beyond(&self, other: &Self, distance: f64) -> bool {
        let reach = distance + self.radius + other.radius;
        self.centre.distance_squared(other.centre) > reach * reach
    }
}

/// Vertices of two triangles that are within a distance of each other in the rest shape.
pub(super) fn near(a: &[DVec3; 3], b: &[DVec3; 3], distance_sq: f64) -> [[bool; 3]; 3] {
    let mut near = [[false; 3]; 3];
    for (row, p) in near.iter_mut().zip(a) {
        for (is_near, q) in row.iter_mut().zip(b) {
            *is_near = p.distance_squared(*q) <= distance_sq;
        }
    }
    near
}

/// Whether two triangles have a vertex and a triangle, or two edges, that are wholly beyond the band.
fn may_touch(near: &[[bool; 3]; 3]) -> bool {
    let is_free = |i: usize, j: usize| !near[i % 3][j % 3];
    (0..3).any(|k| (0..3).all(|j| is_free(k, j)) || (0..3).all(|i| is_free(i, k)))
        || (0..3)
            .any(|i| (0..3).any(|j| is_free(i, j) && is_free(i + 1, j) && is_free(i, j + 1) && is_free(i + 1, j + 1)))
}

impl Sweep<'_> {
    /// Whether the candidates are of this mesh, and all ways lie in their boxes.
    pub(super) fn may_serve(&self, candidates: &Candidates, of_vertex: &[Bounds]) -> bool {
        candidates.corners == self.corners
            && candidates.rest == self.rest
            && candidates.band == self.band
            && !candidates.are_too_many
            && candidates.boxes.len() == of_vertex.len()
            && candidates.boxes.iter().zip(of_vertex).all(|(fat, ways)| fat.holds(ways))
    }

    /// Brings the candidates up to date with the mesh, for these ways and for as much motion again of vertices that have left their boxes; where they
    /// are too many, for these ways alone.
    pub(super) fn renew(&self, candidates: &mut Candidates, order: &mut Vec<u32>, of_vertex: &[Bounds]) {
        let Self { x, rest, corners, .. } = *self;
        let slack = DVec3::splat(SLACK * self.reach);
        let further = |v: usize| {
            let next = x[v] + (x[v] - self.start[v]);
            let Bounds { low, high } = of_vertex[v];
            Bounds { low: low.min(next) - slack, high: high.max(next) + slack }
        };
        let are_of_others = candidates.band != self.band || candidates.are_too_many;
        let has_left = |v: usize| {
            are_of_others
                || candidates.boxes.get(v).is_none_or(|fat| !fat.holds(&of_vertex[v]))
                || candidates.rest.get(v) != Some(&rest[v])
        };
        let have_left: Vec<bool> = (0..of_vertex.len()).map(has_left).collect();
        let is_new = |t: usize| {
            candidates.corners.get(t) != Some(&corners[t]) || corners[t].iter().any(|&v| have_left[v as usize])
        };
        let are_new: Vec<bool> = (0..corners.len()).map(is_new).collect();
        candidates.boxes.resize(of_vertex.len(), Bounds { low: DVec3::ZERO, high: DVec3::ZERO });
        for v in (0..of_vertex.len()).filter(|&v| have_left[v]) {
            candidates.boxes[v] = further(v);
        }
        candidates.band = self.band;
        candidates.corners.clear();
        candidates.corners.extend_from_slice(corners);
        candidates.rest.clear();
        candidates.rest.extend_from_slice(rest);
        if NEW_PART * are_new.iter().filter(|is_new| **is_new).count() > corners.len() || order.is_empty() {
            *order = along_curve(x, corners);
            self.list_candidates(candidates, order, None);
        } else {
            order.retain(|t| (*t as usize) < corners.len());
            order.extend(order.len() as u32..corners.len() as u32);
            self.list_candidates(candidates, order, Some(&are_new));
        }
        if candidates.are_too_many {
            candidates.boxes.clone_from_slice(of_vertex);
            self.list_candidates(candidates, order, None);
        }
    }

    /// Lists the pairs of triangles without a common vertex whose boxes meet and that have parts which may touch; where only some of the
    /// triangles are new, all others stay.
    fn list_candidates(&self, candidates: &mut Candidates, order: &[u32], are_new: Option<&[bool]>) {
        let Candidates { list, boxes, are_too_many, .. } = candidates;
        let most = CANDIDATES * (MOST_PER_TRIANGLE * order.len() + MOST_BESIDE);
        let tree = Tree::new(self, boxes, order);
        *are_too_many = false;
        let is_new = |t: u32| are_new.is_none_or(|are_new| are_new[t as usize]);
        let count = order.len() as u32;
        list.retain(|candidate| candidate.rows.iter().all(|&t| t < count && !is_new(t)));
        for (place, &t) in order.iter().enumerate().filter(|(_, t)| is_new(**t)) {
            // Of two new ones the first looks for both.
            tree.around(place, |other, near| {
                let u = order[other];
                let are_neighbours = || self.corners[t as usize].iter().any(|v| self.corners[u as usize].contains(v));
                if u != t && !(is_new(u) && other < place) && !(near != [[false; 3]; 3] && are_neighbours()) {
                    let (rows, near) = if t < u { ([t, u], near) } else { ([u, t], transposed(near)) };
                    list.push(Candidate { rows, near });
                }
            });
            if list.len() > most {
                list.clear();
                *are_too_many = true;
                return;
            }
        }
    }

    /// Corners of a triangle in the rest shape \[mm\].
    pub(super) fn at_rest(&self, t: u32) -> [DVec3; 3] {
        self.corners[t as usize].map(|v| self.rest[v as usize])
    }
}

/// Tree over triangles in an order.
struct Tree<'a> {
    sweep: &'a Sweep<'a>,
    boxes: Vec<Bounds>,
    balls: Vec<Ball>,
    nodes: Vec<Vec<(Bounds, Ball)>>,
    order: &'a [u32],
}

impl<'a> Tree<'a> {
    fn new(sweep: &'a Sweep<'a>, of_vertex: &[Bounds], order: &'a [u32]) -> Self {
        let corners = |t: &u32| sweep.corners[*t as usize];
        let boxes: Vec<Bounds> = order.iter().map(|t| Bounds::of_triangle(of_vertex, corners(t))).collect();
        let balls: Vec<Ball> = order.iter().map(|t| Ball::around(&sweep.at_rest(*t))).collect();
        let leaves: Vec<(Bounds, Ball)> = boxes.iter().copied().zip(balls.iter().copied()).collect();
        Self { sweep, boxes, balls, nodes: levels(&leaves), order }
    }

    /// Calls `found` for every triangle that meets the one at a place and has parts which may touch it, with its place.
    fn around(&self, place: usize, mut found: impl FnMut(usize, [[bool; 3]; 3])) {
        let (own, ball, band) = (&self.boxes[place], &self.balls[place], self.sweep.band);
        let at_rest = self.sweep.at_rest(self.order[place]);
        let mut stack: SmallVec<[(usize, usize); 64]> = SmallVec::new();
        stack.push((self.nodes.len() - 1, 0));
        while let Some((level, i)) = stack.pop() {
            let (node, of_rest) = &self.nodes[level][i];
            if !node.meets(own) || of_rest.is_within(ball, band) {
                continue;
            }
            if level > 0 {
                let below = self.nodes[level - 1].len();
                stack.extend((2 * i..(2 * i + 2).min(below)).map(|i| (level - 1, i)));
                continue;
            }
            for other in i * LEAF..((i + 1) * LEAF).min(self.order.len()) {
                if !self.boxes[other].meets(own) {
                    continue;
                }
                let near = match ball.is_beyond(&self.balls[other], band) {
                    true => [[false; 3]; 3],
                    false => near(&at_rest, &self.sweep.at_rest(self.order[other]), band * band),
                };
                if may_touch(&near) {
                    found(other, near);
                }
            }
        }
    }
}

/// Nearness of two triangles in the other order.
fn transposed(near: [[bool; 3]; 3]) -> [[bool; 3]; 3] {
    std::array::from_fn(|i| std::array::from_fn(|j| near[j][i]))
}

/// Nodes of the tree: of the triangles in a leaf, then of two nodes each, up to the root.
fn levels(leaves: &[(Bounds, Ball)]) -> Vec<Vec<(Bounds, Ball)>> {
    let joined = |nodes: &[(Bounds, Ball)]| {
        nodes[1..].iter().fold(nodes[0], |(bounds, ball), other| (bounds.join(other.0), ball.join(other.1)))
    };
    let mut levels: Vec<Vec<(Bounds, Ball)>> = vec![leaves.chunks(LEAF).map(joined).collect()];
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

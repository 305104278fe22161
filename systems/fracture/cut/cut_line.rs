//! The line of a cut: which parts of it lie on the body, and in which strokes they are cut.
//!
//! The line is broken where it crosses the boundary (a rim, a hole, a slit) and where it comes back to itself: by then its
//! first part is a boundary too. Parts outside the body or along its boundary are left out.

use crate::storage::NONE;
use crate::storage::measure::rest_corners;
use crate::systems::fracture::Cutter;
use crate::systems::fracture::cut::locate::SurfacePoint;
use crate::systems::fracture::cut::place::ON_BOUNDARY;
use glam::DVec3;

/// Lengths below this part of the line's length are rounding.
const LENGTH_ROUNDING: f64 = 1e-9;

/// Chords that cross over a curved surface are no farther apart than this part of the shorter one, along its normal within 30°.
const ABOVE: f64 = 0.1;
const ALONG_NORMAL: f64 = 0.866;

/// A break of a segment: its place from 0 to 1, and whether a stroke ends there.
#[derive(Clone, Copy, Debug)]
struct Break {
    at: f64,
    ends: bool,
}

/// Length of a polyline \[mm\].
pub(in crate::systems::fracture) fn length(line: &[DVec3]) -> f64 {
    line.windows(2).map(|pair| pair[0].distance(pair[1])).sum()
}

/// A polyline without the points that lie within `tolerance` \[mm\] of the rest (Ramer 1972; Douglas, Peucker 1973).
pub(in crate::systems::fracture) fn thinned(line: &[DVec3], tolerance: f64) -> Vec<DVec3> {
    let mut kept = vec![false; line.len()];
    if let [first, .., last] = kept.as_mut_slice() {
        (*first, *last) = (true, true);
    }
    let mut ranges = vec![(0, line.len().saturating_sub(1))];
    while let Some((from, to)) = ranges.pop() {
        let inner = (from + 1..to).map(|i| (i, distance_to_segment(line[i], line[from], line[to])));
        let Some((farthest, distance)) = inner.max_by(|a, b| a.1.total_cmp(&b.1)) else { continue };
        if distance > tolerance {
            kept[farthest] = true;
            ranges.extend([(from, farthest), (farthest, to)]);
        }
    }
    let mut thin: Vec<DVec3> = line.iter().zip(kept).filter(|(_, kept)| *kept).map(|(point, _)| *point).collect();
    thin.dedup_by(|a, b| a.distance(*b) <= tolerance.min(LENGTH_ROUNDING));
    thin
}

/// Distance \[mm\] of a point from a segment.
pub(in crate::systems::fracture) fn distance_to_segment(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let squared = (b - a).length_squared();
    let along = if squared > 0.0 { ((p - a).dot(b - a) / squared).clamp(0.0, 1.0) } else { 0.0 };
    p.distance(a + (b - a) * along)
}

impl Cutter<'_, '_> {
    /// The strokes of a polyline, in order. Points that are neither breaks nor too near to the boundary stay exactly where they
    /// are.
    pub(in crate::systems::fracture) fn strokes(&self, line: &[DVec3]) -> Vec<Vec<DVec3>> {
        let reach = LENGTH_ROUNDING * length(line);
        let line: &[DVec3] = &line.iter().map(|&point| self.settled(point, reach)).collect::<Vec<_>>();
        let rim = self.rim();
        let mut strokes: Vec<Vec<DVec3>> = Vec::new();
        let mut stroke: Vec<DVec3> = Vec::new();
        for (i, pair) in line.windows(2).enumerate() {
            let (from, to) = (pair[0], pair[1]);
            let mut breaks = self.rim_breaks(&rim, from, to, reach);
            breaks.extend(self.own_breaks(line, i, reach));
            breaks.sort_by(|a, b| a.at.total_cmp(&b.at));
            let span = from.distance(to);
            let mut start = (from, breaks.iter().any(|b| b.ends && b.at * span <= reach));
            let inner = breaks.iter().filter(|b| b.at * span > reach && (1.0 - b.at) * span > reach);
            let ends_at_last = breaks.iter().any(|b| b.ends && (1.0 - b.at) * span <= reach);
            let ends = inner.map(|b| (from + (to - from) * b.at, b.ends)).chain([(to, ends_at_last)]);
            for end in ends {
                if start.0.distance(end.0) <= reach {
                    // Two lips at one place.
                    start.1 |= end.1;
                    continue;
                }
                if start.1 {
                    finish(&mut stroke, &mut strokes);
                }
                if self.is_tissue(start.0.midpoint(end.0)) {
                    if stroke.is_empty() {
                        stroke.push(start.0);
                    }
                    stroke.push(end.0);
                } else {
                    finish(&mut stroke, &mut strokes);
                }
                start = end;
            }
            if start.1 {
                finish(&mut stroke, &mut strokes);
            }
        }
        finish(&mut stroke, &mut strokes);
        strokes
    }

    /// A point inside the body that is nearer to its boundary than could be meshed is put onto it: straight across, and at the end of an
    /// edge where that is as near.
    fn settled(&self, point: DVec3, reach: f64) -> DVec3 {
        let Some(at) = self.nearest(point) else { return point };
        let neighbours = self.mesh.topology.neighbours[at.triangle as usize];
        let opposite = |edge: usize| at.weights[(edge + 2) % 3];
        let rim = (0..3).filter(|&edge| neighbours[edge] == NONE && opposite(edge) < ON_BOUNDARY);
        let Some(edge) = rim.min_by(|&e, &f| opposite(e).total_cmp(&opposite(f))) else { return point };
        let x = rest_corners(self.mesh.vertices, self.mesh.triangles.corners[at.triangle as usize]);
        let (a, b, place) = (x[edge], x[(edge + 1) % 3], self.position(&at));
        let along = ((place - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        let foot = a + (b - a) * along;
        if place.distance(foot) <= reach {
            return point;
        }
        match along {
            _ if along < ON_BOUNDARY => a,
            _ if along > 1.0 - ON_BOUNDARY => b,
            _ => foot,
        }
    }

    /// Boundary edges, each with the normal of its triangle.
    fn rim(&self) -> Vec<([DVec3; 2], DVec3)> {
        let mut rim = Vec::new();
        for (row, neighbours) in self.mesh.topology.neighbours.iter().enumerate() {
            for edge in (0..3).filter(|&edge| neighbours[edge] == NONE) {
                let x = rest_corners(self.mesh.vertices, self.mesh.triangles.corners[row]);
                let normal = (x[1] - x[0]).cross(x[2] - x[0]).normalize_or_zero();
                rim.push(([x[edge], x[(edge + 1) % 3]], normal));
            }
        }
        rim
    }

    /// Crossings of a segment, seen along the normals of the surface, with boundary edges.
    fn rim_breaks(&self, rim: &[([DVec3; 2], DVec3)], from: DVec3, to: DVec3, reach: f64) -> Vec<Break> {
        let mut breaks = Vec::new();
        for &([a, b], normal) in rim {
            let across = (b - a).cross(normal).normalize_or_zero();
            let (s, t) = ((from - a).dot(across), (to - a).dot(across));
            let edge = (b - a).length();
            let along = |p: DVec3| (p - a).dot(b - a) / edge;
            let mut note = |at: f64| {
                let p = from + (to - from) * at;
                let place = along(p);
                if place < -reach || place > edge + reach {
                    return;
                }
                let foot = a + (b - a) * (place / edge).clamp(0.0, 1.0);
                let is_nearest = self
                    .nearest(p)
                    .is_some_and(|near| self.position(&near).distance(p) >= foot.distance(p) - 10.0 * reach);
                if is_nearest {
                    breaks.push(Break { at, ends: true });
                }
            };
            if s.abs() <= reach && t.abs() <= reach {
                // Along the edge: it begins and ends there.
                for corner in [a, b] {
                    let at = (corner - from).dot(to - from) / (to - from).length_squared();
                    if (0.0..=1.0).contains(&at) {
                        note(at);
                    }
                }
            } else if s.abs() <= reach {
                note(0.0);
            } else if t.abs() <= reach {
                note(1.0);
            } else if (s < 0.0) != (t < 0.0) {
                note(s / (s - t));
            }
        }
        breaks
    }

    /// Crossings of a segment with other segments of its own line. The stroke ends where the other one comes first.
    fn own_breaks(&self, line: &[DVec3], segment: usize, reach: f64) -> Vec<Break> {
        let (from, to) = (line[segment], line[segment + 1]);
        let is_closed = line.first().zip(line.last()).is_some_and(|(a, b)| a.distance(*b) <= reach);
        let mut breaks = Vec::new();
        for (other, pair) in line.windows(2).enumerate() {
            if other.abs_diff(segment) < 2 || (is_closed && other.abs_diff(segment) == line.len() - 2) {
                continue;
            }
            let Some((at, place)) = meeting(from, to, pair[0], pair[1]) else { continue };
            let points = (from + (to - from) * at, pair[0] + (pair[1] - pair[0]) * place);
            let near = ABOVE * from.distance(to).min(pair[0].distance(pair[1]));
            if points.0.distance(points.1) <= reach || self.is_above(points, near) {
                breaks.push(Break { at, ends: other < segment });
            }
        }
        breaks
    }

    /// Whether one point lies over the other as seen along the normal there, no farther than `near` \[mm\]: chords of a curved surface
    /// that cross on it pass each other in space.
    fn is_above(&self, (p, q): (DVec3, DVec3), near: f64) -> bool {
        let Some(at) = self.nearest(p.midpoint(q)).filter(|_| p.distance(q) <= near) else { return false };
        let x = rest_corners(self.mesh.vertices, self.mesh.triangles.corners[at.triangle as usize]);
        let normal = (x[1] - x[0]).cross(x[2] - x[0]).normalize_or_zero();
        (p - q).normalize_or_zero().dot(normal).abs() > ALONG_NORMAL
    }

    /// Whether the surface nearest to a point is inside the body, not on its boundary.
    pub(in crate::systems::fracture) fn is_tissue(&self, point: DVec3) -> bool {
        self.nearest(point).is_some_and(|at| !self.is_on_rim(&at))
    }

    /// Whether a point of the surface lies on the boundary.
    pub(in crate::systems::fracture) fn is_on_rim(&self, at: &SurfacePoint) -> bool {
        let triangle = at.triangle as usize;
        let is_on_edge = |edge: usize| at.weights[(edge + 2) % 3] < LENGTH_ROUNDING;
        let corners = self.mesh.triangles.corners[triangle];
        let at_corner = (0..3).find(|&i| at.weights[i] >= 1.0 - LENGTH_ROUNDING);
        at_corner.is_some_and(|i| self.mesh.topology.is_boundary_vertex(corners[i]))
            || (0..3).any(|edge| is_on_edge(edge) && self.mesh.topology.neighbours[triangle][edge] == NONE)
    }

    /// Position of a point of the surface in the rest shape \[mm\].
    pub(in crate::systems::fracture) fn position(&self, at: &SurfacePoint) -> DVec3 {
        let x = rest_corners(self.mesh.vertices, self.mesh.triangles.corners[at.triangle as usize]);
        x[0] * at.weights[0] + x[1] * at.weights[1] + x[2] * at.weights[2]
    }
}

fn finish(stroke: &mut Vec<DVec3>, strokes: &mut Vec<Vec<DVec3>>) {
    if stroke.len() > 1 {
        strokes.push(std::mem::take(stroke));
    }
    stroke.clear();
}

/// Parameters of the nearest points of two segments that are not parallel.
fn meeting(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> Option<(f64, f64)> {
    let (u, v, w) = (b - a, d - c, a - c);
    let (uu, uv, vv) = (u.length_squared(), u.dot(v), v.length_squared());
    let det = uu * vv - uv * uv;
    if det <= LENGTH_ROUNDING * uu * vv {
        return None;
    }
    let (uw, vw) = (u.dot(w), v.dot(w));
    let (at, place) = ((uv * vw - vv * uw) / det, (uu * vw - uv * uw) / det);
    let is_inside = |t: f64| (-LENGTH_ROUNDING..=1.0 + LENGTH_ROUNDING).contains(&t);
    (is_inside(at) && is_inside(place)).then(|| (at.clamp(0.0, 1.0), place.clamp(0.0, 1.0)))
}

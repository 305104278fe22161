//! Contact of triangles: where an obstacle is so small, or a triangle so large or stretched so far, that it could pass between
//! the vertices.
//!
//! The point of a triangle that is deepest in the obstacle is held like a vertex, and its corners bear the force by its weights.
//! The force couples them. The stiffness in the solve is the sum of each corner's row, which is no less. So a step stays stable and
//! only comes to rest a little later.

use super::{DEEP, Held, Moved, SAME_SIDE, STIFFNESS, held, shift};
use crate::components::{Contact, Increment, Push, Shape, SolverScratch};
use crate::math::{Sym3, elementary, nearest_in_triangle};
use crate::storage::{Triangles, Vertices};
use crate::systems::StepContext;
use crate::systems::kernels::formulas::{dot, less};
use crate::systems::kernels::gather::at_corners;
use crate::systems::kernels::lanes::{DOUBLES, Doubles, Lanes};
use crate::systems::kernels::simd::{Pass, pass};
use glam::DVec3;

/// A triangle whose longest edge is no longer than this part of the obstacle's least radius of curvature is left to its vertices.
/// Beyond, the stiffness grows with the edge, for one place then bears the load of many vertices. Three vertices that are 1.7 radii
/// apart let a ball through.
const SMALL_FACE: f64 = 0.5;

/// Least weight of a place inside a triangle.
const INSIDE: f64 = 0.05;

/// Steps to the moment of contact at the most, and how near it is \[of the way\].
const MOST_IMPACT_STEPS: u32 = 40;
const IMPACT_TOLERANCE: f64 = 1e-6;

/// Rounds in which triangles are put outside.
const MOST_DEPENETRATIONS: u32 = 40;

/// Maximum shift of a corner in a round, in multiples of the depth. Where all corners are free none has to go farther than
/// 1.4 times. But beside corners that are held, or in a plane that the normal stands off, the few free axes would have to go
/// any distance.
const LONGEST: f64 = 2.0;

/// A triangle that a contact holds.
pub(super) struct HeldFace {
    /// Barycentric weights of the place of contact.
    pub weights: [f64; 3],
    pub held: Held,
    /// The shorter of its longest edge and the obstacle's least radius of curvature \[mm\].
    pub size: f64,
    /// Stiffness of the contact as a multiple of that of a vertex.
    pub part: f64,
}

impl HeldFace {
    /// Whether the triangle is further inside than a solve may leave it.
    pub(super) fn is_deep(&self) -> bool {
        self.part.min(1.0) * self.held.depth > DEEP * self.size
    }
}

/// The least radius of curvature \[mm\]; infinite for a plane.
fn least_radius(shape: &Shape) -> f64 {
    match *shape {
        Shape::Plane { .. } | Shape::Mesh { .. } => f64::INFINITY,
        Shape::Sphere { radius, .. } | Shape::Capsule { radius, .. } => radius,
        Shape::Ellipsoid { half_axes, .. } => elementary::powi(half_axes.min_element(), 2) / half_axes.max_element(),
        // Edges have none: triangles are held where they are long against the whole.
        Shape::Box { .. } | Shape::Cylinder { .. } => shape.least_half_width(),
    }
}

/// The place of a triangle that is deepest in a shape: of a ball and a capsule in length, of an ellipsoid on the smallest of those
/// similar to it. `None` for a plane, whose deepest place is a vertex, and for a
/// mesh, which vertices alone feel.
pub(super) fn deepest(shape: &Shape, x: [DVec3; 3]) -> Option<[f64; 3]> {
    let weights = match *shape {
        Shape::Plane { .. } | Shape::Mesh { .. } => return None,
        Shape::Sphere { centre, .. } => nearest_in_triangle(x, centre),
        Shape::Ellipsoid { centre, half_axes, axes } => {
            let local = axes.transpose();
            nearest_in_triangle(x.map(|x| local * (x - centre) / half_axes), DVec3::ZERO)
        }
        Shape::Capsule { ends, .. } => nearest_to_segment(x, ends),
        Shape::Box { .. } | Shape::Cylinder { .. } => innermost(shape, x),
    };
    weights.iter().all(|w| w.is_finite()).then_some(weights)
}

/// The place of a triangle on the smallest similar shape: the gauge is convex, so that a search on ever finer parts finds it.
fn innermost(shape: &Shape, x: [DVec3; 3]) -> [f64; 3] {
    const STEPS: i32 = 4;
    const ROUNDS: i32 = 5;
    let gauge = |weights: [f64; 3]| shape.gauge(at(x, weights)).unwrap_or(f64::INFINITY);
    let mut best = [1.0 / 3.0; 3];
    let mut least = gauge(best);
    let mut reach = 1.0;
    for _ in 0..ROUNDS {
        let middle = best;
        for i in -STEPS..=STEPS {
            for j in -STEPS..=STEPS {
                let part = |k: i32| reach * f64::from(k) / f64::from(STEPS);
                let u = (middle[0] + part(i)).clamp(0.0, 1.0);
                let v = (middle[1] + part(j)).clamp(0.0, 1.0 - u);
                let weights = [u, v, 1.0 - u - v];
                let value = gauge(weights);
                if value < least {
                    (best, least) = (weights, value);
                }
            }
        }
        reach /= f64::from(STEPS);
    }
    best
}

pub(super) fn at(x: [DVec3; 3], weights: [f64; 3]) -> DVec3 {
    x[0] * weights[0] + x[1] * weights[1] + x[2] * weights[2]
}

/// The place of a triangle nearest to a segment: at one of its ends, on an edge, or where it passes through.
fn nearest_to_segment(x: [DVec3; 3], [a, b]: [DVec3; 2]) -> [f64; 3] {
    let along = b - a;
    let to_segment = |p: DVec3| {
        let t = ((p - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
        p.distance_squared(if t.is_finite() { a + along * t } else { a })
    };
    let normal = (x[1] - x[0]).cross(x[2] - x[0]);
    let through = a + along * ((x[0] - a).dot(normal) / along.dot(normal)).clamp(0.0, 1.0);
    let ends = [a, b, if through.is_finite() { through } else { a }].map(|p| nearest_in_triangle(x, p));
    let edge = |i: usize| {
        let j = (i + 1) % 3;
        let s = nearest_of_segments([x[i], x[j]], [a, b]);
        let mut weights = [0.0; 3];
        weights[i] = 1.0 - s;
        weights[j] = s;
        weights
    };
    let all = ends.into_iter().chain((0..3).map(edge)).map(|weights| (to_segment(at(x, weights)), weights));
    all.min_by(|p, q| p.0.total_cmp(&q.0)).map_or([1.0, 0.0, 0.0], |(_, weights)| weights)
}

/// Parameter along the first segment of its point nearest to the second (Ericson 2005, Real-Time Collision Detection, 5.1.9).
fn nearest_of_segments([p, q]: [DVec3; 2], [a, b]: [DVec3; 2]) -> f64 {
    let (u, v, w) = (q - p, b - a, p - a);
    let (uu, vv, uv, uw, vw) = (u.dot(u), v.dot(v), u.dot(v), u.dot(w), v.dot(w));
    let clamped = |value: f64| if value.is_finite() { value.clamp(0.0, 1.0) } else { 0.0 };
    let s = clamped((uv * vw - uw * vv) / (uu * vv - uv * uv));
    let t = clamped((uv * s + vw) / vv);
    clamped((uv * t - uw) / uu)
}

/// The square of a triangle's longest edge \[mm²\].
#[inline]
fn longest_sq(x: [DVec3; 3]) -> f64 {
    let squares = [x[0].distance_squared(x[1]), x[0].distance_squared(x[2]), x[1].distance_squared(x[2])];
    squares[0].max(squares[1]).max(squares[2])
}

/// The plane that holds a triangle back that was at `start` and is at `x`, unless it is left to its vertices.
fn held_face(moved: &Moved, start: [DVec3; 3], x: [DVec3; 3]) -> Option<HeldFace> {
    let radius = SMALL_FACE * least_radius(&moved.0.shape);
    let longest = longest_sq(x);
    if longest > radius * radius { held_at(moved, start, x, (longest.sqrt(), radius)) } else { None }
}

/// The plane that holds a triangle back whose longest edge exceeds the `radius` up to which triangles are left to their
/// vertices, both \[mm\].
fn held_at(moved: &Moved, start: [DVec3; 3], x: [DVec3; 3], (edge, radius): (f64, f64)) -> Option<HeldFace> {
    let (obstacle, travel) = moved;
    let shape = &obstacle.shape;
    let from = start.map(|start| travel.carry(start));
    let all = || from.iter().chain(&x);
    let middle = all().sum::<DVec3>() / 6.0;
    if !shape.reaches(middle, all().map(|p| p.distance(middle)).fold(0.0, f64::max)) {
        return None;
    }
    let first = deepest(shape, from)?;
    let (mut distance, mut normal) = shape.distance(at(from, first))?;
    let (weights, held) = if distance < 0.0 {
        // The place that was in touch, which a fast obstacle carries along, or the one that is deepest now, where it slides.
        let hold = |weights| {
            let held = held(moved, at(start, weights), at(x, weights))?;
            Some((weights, along_own_normal(shape, x, weights, &held).unwrap_or(held)))
        };
        let (touching, now) = (hold(first), deepest(shape, x).and_then(hold));
        let is_deeper = |a: &([f64; 3], Held), b: &([f64; 3], Held)| a.1.depth > b.1.depth;
        match (touching, now) {
            (Some(touching), Some(now)) => {
                if is_deeper(&touching, &now) {
                    touching
                } else {
                    now
                }
            }
            (touching, now) => touching.or(now)?,
        }
    } else {
        // To the moment of contact in steps that no corner outruns.
        let way = (0..3).map(|i| from[i].distance(x[i])).fold(0.0, f64::max);
        let (mut done, mut weights, mut then) = (0.0, first, from);
        for _ in 0..MOST_IMPACT_STEPS {
            if distance <= IMPACT_TOLERANCE * way {
                break;
            }
            done += distance / way;
            if !(done < 1.0) {
                return None;
            }
            then = [0, 1, 2].map(|i| from[i].lerp(x[i], done));
            weights = deepest(shape, then)?;
            (distance, normal) = shape.distance(at(then, weights))?;
        }
        let point = at(then, weights) - normal * distance;
        let depth = (point - at(x, weights)).dot(normal);
        if !(depth > 0.0) {
            return None;
        }
        (weights, Held { depth, normal, point })
    };
    Some(HeldFace { weights, held, size: edge.min(radius / SMALL_FACE), part: edge / radius - 1.0 })
}

/// The plane of a triangle that the end of an obstacle pierces inside: across its own normal, for the way out at the side of the obstacle is closed to it. `None` for
/// one that lies along the obstacle, is touched at its rim, or has let the obstacle through by more than that is wide.
fn along_own_normal(shape: &Shape, x: [DVec3; 3], weights: [f64; 3], held: &Held) -> Option<Held> {
    let own = (x[1] - x[0]).cross(x[2] - x[0]).try_normalize()?;
    if own.dot(held.normal).abs() > SAME_SIDE || weights.iter().any(|weight| *weight < INSIDE) {
        return None;
    }
    let point = at(x, weights);
    let normal = if own.dot(point - shape.anchor()) < 0.0 { -own } else { own };
    let depth = shape.farthest(normal)? - normal.dot(point);
    (depth > 0.0 && depth < 2.0 * shape.least_half_width()).then_some(Held {
        depth,
        normal,
        point: point + normal * depth,
    })
}

/// Calls `f` for every triangle that an obstacle holds back, in the order of rows.
pub(super) fn for_held(
    moved: &Moved,
    start: &[DVec3],
    (vertices, triangles): (&[DVec3], &Triangles),
    mut f: impl FnMut(usize, HeldFace),
) {
    let radius = SMALL_FACE * least_radius(&moved.0.shape);
    if radius.is_infinite() {
        return;
    }
    let corners = &triangles.corners[..];
    let mut first = 0;
    // Most bodies have none.
    while let Some(found) = pass(NextLong { corners, first, x: vertices, length_sq: radius * radius }) {
        first = (found + DOUBLES).min(corners.len());
        for (t, corners) in corners[..first].iter().enumerate().skip(found) {
            let of = |points: &[DVec3]| corners.map(|v| points[v as usize]);
            let x = of(vertices);
            let longest = longest_sq(x);
            if longest > radius * radius
                && let Some(face) = held_at(moved, of(start), x, (longest.sqrt(), radius))
            {
                f(t, face);
            }
        }
    }
}

/// The next group of four triangles from `first` on in which one may have an edge longer than is left to the vertices.
struct NextLong<'a> {
    corners: &'a [[u32; 3]],
    first: usize,
    x: &'a [DVec3],
    length_sq: f64,
}

impl Pass for NextLong<'_> {
    /// First triangle of the group found.
    type Output = Option<usize>;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Option<usize> {
        let Self { corners, first, x, length_sq } = self;
        let most = Doubles::splat(lanes, length_sq);
        for four in (first..corners.len()).step_by(DOUBLES) {
            let [a, b, c] = at_corners(lanes, (corners, four), &|v| x[v]);
            let (ab, bc, ca) = (less(b, a), less(c, b), less(a, c));
            // Nor is a length that is no number less.
            let are_short = most.is_larger(dot(ab, ab)) && most.is_larger(dot(bc, bc)) && most.is_larger(dot(ca, ca));
            if !are_short {
                return Some(four);
            }
        }
        None
    }
}

/// Pushes triangles out of an obstacle: `add` takes the push at each of their corners.
pub(super) fn push(
    moved: &Moved,
    contact: &Contact,
    (vertices, triangles, start): (&Vertices, &Triangles, &[DVec3]),
    mut add: impl FnMut(usize, Push),
) {
    for_held(moved, start, (&vertices.position[..], triangles), |t, HeldFace { weights, held, part, .. }| {
        let stiffness = part * stiffness(contact, triangles, t);
        let normal = held.normal;
        for (&v, weight) in triangles.corners[t].iter().zip(weights) {
            let k = stiffness * weight;
            let block = Sym3::outer(normal) * k;
            add(v as usize, Push { force: normal * (held.depth * k), block, point: held.point, normal });
        }
    });
}

/// Puts triangles that are still deep in an obstacle, or through it, back onto the planes that should have held them, each by the least
/// motion of its corners. Neighbours share corners, hence some rounds. Returns the force \[N\] with this impulse over the step.
pub(super) fn depenetrate(
    moved: &Moved,
    (vertices, increment): (&mut Vertices, &mut Increment),
    (triangles, SolverScratch { free, sweeps, .. }): (&Triangles, &mut SolverScratch),
    step: &StepContext,
) -> DVec3 {
    let mut force = DVec3::ZERO;
    if least_radius(&moved.0.shape).is_infinite() {
        return force;
    }
    let counts = (vertices.len(), triangles.len());
    sweeps.begin();
    for round in 0..MOST_DEPENETRATIONS {
        let mut is_any = false;
        for (t, corners) in triangles.corners.iter().map(|corners| corners.map(|v| v as usize)).enumerate() {
            if !(sweeps.is_due(t, corners) || round == 0) {
                continue;
            }
            let (start, x) = (corners.map(|v| increment.start[v]), corners.map(|v| vertices.position[v]));
            let Some(face) = held_face(moved, start, x).filter(HeldFace::is_deep) else { continue };
            is_any = true;
            let normal = face.held.normal;
            let shares = [0, 1, 2].map(|i| normal * free[corners[i]] * face.weights[i]);
            let gain: f64 = (0..3).map(|i| face.weights[i] * shares[i].dot(normal)).sum();
            if gain > 0.0 {
                let longest = shares.iter().map(|share| share.length()).fold(0.0, f64::max);
                let way = face.held.depth * (1.0 / gain).min(LONGEST / longest);
                for (v, share) in corners.into_iter().zip(shares) {
                    sweeps.note(v, counts);
                    force += shift(vertices, increment, v, share * way, step);
                }
            }
        }
        if !is_any {
            break;
        }
    }
    force
}

/// Penalty stiffness of a triangle \[N/mm\].
fn stiffness(contact: &Contact, triangles: &Triangles, t: usize) -> f64 {
    contact.stiffness.map_or_else(
        || STIFFNESS * triangles.stiffness[t].q11.max(triangles.stiffness[t].q22) * triangles.thickness[t],
        |per_area| per_area * triangles.rest[t].area,
    )
}

#[cfg(test)]
mod tests {
    use super::super::Travel;
    use super::*;

    const TRIANGLE: [DVec3; 3] = [DVec3::ZERO, DVec3::new(2.0, 0.0, 0.0), DVec3::new(0.0, 2.0, 0.0)];

    #[test]
    fn no_place_of_the_triangle_is_nearer_to_the_segment() {
        for i in 1..300 {
            let at_random = |k: f64| (f64::from(i) * k).sin() * 3.0;
            let [a, b] = [
                DVec3::new(at_random(1.1), at_random(2.3), at_random(3.7)),
                DVec3::new(at_random(1.7), at_random(2.9), at_random(0.7)),
            ];
            let distance =
                |p: DVec3| p.distance(a + (b - a) * ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0));
            let found = distance(at(TRIANGLE, nearest_to_segment(TRIANGLE, [a, b])));
            for j in 0..200 {
                let (u, v) = ((f64::from(j) * 0.618).fract(), (f64::from(j) * 0.327).fract());
                let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
                assert!(found <= distance(at(TRIANGLE, [1.0 - u - v, u, v])) + 1e-9);
            }
        }
    }

    #[test]
    fn a_ball_is_caught_between_the_vertices_wherever_it_ends() {
        let ball = |z: f64| Shape::Sphere { centre: DVec3::new(0.5, 0.5, z), radius: 0.3 };
        let pushed = |from: f64, to: f64| {
            let moved = (
                crate::components::Obstacle { shape: ball(to) },
                Travel { offset: DVec3::Z * (to - from), ..Travel::default() },
            );
            held_face(&moved, TRIANGLE, TRIANGLE).map(|face| (face.held.depth, face.held.normal))
        };
        assert!(pushed(-1.0, -0.31).is_none());
        for to in [-0.2, 0.0, 0.2, 5.0] {
            let (depth, normal) = pushed(-1.0, to).unwrap();
            assert!((depth - (to + 0.3)).abs() < 1e-5 && normal.z > 1.0 - 1e-9, "{to}: {depth} along {normal}");
        }
        // Already in it by a little, as at rest.
        let (depth, normal) = pushed(-0.29, -0.25).unwrap();
        assert!((depth - 0.05).abs() < 1e-9 && normal.z > 1.0 - 1e-9);
    }
}

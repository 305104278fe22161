//! Contact of triangles: where an obstacle is so small, or a triangle so large or stretched so far, that it could pass between
//! the vertices.
//!
//! The point of a triangle that is deepest in the obstacle is held like a vertex, and its corners bear the force by its weights.
//! The force couples them. The stiffness in the solve is the sum of each corner's row, which is no less. So a step stays stable and
//! only comes to rest a little later.

use super::deepest::{Place, at, deepest};
use super::{DEEP, Held, Moved, SAME_SIDE, STIFFNESS, held, shift};
use crate::components::{Contact, Increment, Push, Shape, SolverScratch};
use crate::math::{Sym3, elementary};
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

/// Depth in a box up to which the nearest way out counts, of the box's least half width.
const SHALLOW: f64 = 0.25;

/// Normals of a box with a smaller cosine between them are of opposite faces.
const OTHER_SIDE: f64 = -0.5;

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
    let Place { weights: first, mut distance, mut normal, .. } = Place::of(shape, from)?;
    let beneath = |weights, normal: DVec3| {
        let x = at(x, weights);
        let depth = shape.farthest(normal)? - normal.dot(x);
        Some((weights, Held { depth, normal, point: x + normal * depth }))
    };
    let is_box = matches!(shape, Shape::Box { .. });
    // A box that has not gone far into the triangle, nor through it, holds it by the least way out of now, whatever way it came.
    let shallow = -SHALLOW * shape.least_half_width();
    let is_near =
        |now: &Place| now.distance < 0.0 && distance.min(now.distance) > shallow && now.normal.dot(normal) > OTHER_SIDE;
    let now = if is_box { Place::of(shape, x).filter(is_near) } else { None };
    let (weights, held) = if let Some(now) = now {
        beneath(now.weights, now.normal).filter(|_| !now.is_by_corners)?
    } else if distance < 0.0 && is_box {
        beneath(first, normal)?
    } else if distance < 0.0 {
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
            Place { weights, distance, normal, .. } = Place::of(shape, then)?;
        }
        let point = at(then, weights) - normal * distance;
        (weights, Held { depth: (point - at(x, weights)).dot(normal), normal, point })
    };
    let face = HeldFace { weights, held, size: edge.min(radius / SMALL_FACE), part: edge / radius - 1.0 };
    (face.held.depth > 0.0).then_some(face)
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

//! Clamp against tunnelling: no triangle passes through an obstacle within a step, whatever solves and corrections have made of
//! it.
//!
//! The core of an obstacle is nine tenths of it: of a ball and a capsule the points so near to centre or axis, of an ellipsoid
//! the similar one. A triangle comes from one side of the obstacle to the other through the core or round it. So the way of
//! each is followed, in the frame of the obstacle, to where it would enter the core. From there on its corners go along with
//! the obstacle, and so do those of neighbours that would enter because of that. Triangles that do not move against the
//! obstacle enter nothing, so the procedure ends.

use super::deepest::{at, deepest};
use super::{Moved, shift};
use crate::components::{Increment, Shape, SolverScratch};
use crate::storage::{Triangles, Vertices};
use crate::systems::StepContext;
use glam::DVec3;

/// The core's size over the obstacle's.
const CORE_OF_OBSTACLE: f64 = 0.9;

/// A triangle that touches the core may go on half-way to this size in a step, so that it is free to slide and to leave.
const INNERMOST: f64 = 0.87;

/// A triangle that is further inside, as it may have begun, may come nearer to the middle by this factor: never to it.
const NEARER: f64 = 0.99;

/// Remaining part of the initial distance at which the search along a way ends, and the most steps to there.
const SEARCH_TOLERANCE: f64 = 1e-3;
const MOST_SEARCH_STEPS: u32 = 60;

/// Rounds in which corners are held back to where the first of their triangles would enter; after them they do not move against the
/// obstacle at all, in so many rounds.
const SHORTENED: u32 = 8;
const STOPPED: u32 = 200;

/// Distance of a triangle from the middle of a shape, over the shape's own size. `None` for a plane and a mesh.
fn nearness(shape: &Shape, x: [DVec3; 3]) -> Option<f64> {
    let point = at(x, deepest(shape, x)?);
    match *shape {
        Shape::Plane { .. } | Shape::Mesh { .. } => None,
        Shape::Box { .. } | Shape::Cylinder { .. } => shape.gauge(point),
        Shape::Ellipsoid { centre, half_axes, axes } => {
            Some((axes.transpose() * (point - centre) / half_axes).length())
        }
        Shape::Sphere { radius, .. } | Shape::Capsule { radius, .. } => {
            Some(shape.distance(point).map_or(0.0, |(distance, _)| (distance + radius) / radius))
        }
    }
}

/// The part of its way that a triangle goes before it enters the core.
fn part_outside(shape: &Shape, from: [DVec3; 3], to: [DVec3; 3]) -> f64 {
    let way = (0..3).map(|i| from[i].distance(to[i])).fold(0.0, f64::max) / shape.least_half_width();
    if !(way > 0.0) {
        return 1.0;
    }
    let all = || from.iter().chain(&to);
    let middle = all().sum::<DVec3>() / 6.0;
    if !shape.reaches(middle, all().map(|p| p.distance(middle)).fold(0.0, f64::max)) {
        return 1.0;
    }
    let Some(mut distance) = nearness(shape, from) else { return 1.0 };
    let limit =
        if distance > INNERMOST { CORE_OF_OBSTACLE.min(0.5 * (INNERMOST + distance)) } else { NEARER * distance };
    let near = SEARCH_TOLERANCE * (distance - limit);
    let mut done = 0.0;
    for _ in 0..MOST_SEARCH_STEPS {
        // No point of the triangle comes nearer than its fastest corner goes.
        done += (distance - limit) / way;
        if !(done < 1.0) {
            return 1.0;
        }
        let then = [0, 1, 2].map(|i| from[i].lerp(to[i], done));
        match nearness(shape, then) {
            Some(now) if now - limit > near => distance = now,
            _ => break,
        }
    }
    done
}

/// Holds corners back of triangles that would pass through an obstacle in the step. Returns the force \[N\] with this impulse over the step.
pub(super) fn keep(
    (obstacle, travel): &Moved,
    (vertices, increment): (&mut Vertices, &mut Increment),
    (triangles, SolverScratch { free, sweeps, .. }): (&Triangles, &mut SolverScratch),
    step: &StepContext,
) -> DVec3 {
    let (shape, mut force) = (&obstacle.shape, DVec3::ZERO);
    if shape.least_half_width().is_infinite() {
        return force;
    }
    let counts = (vertices.len(), triangles.len());
    sweeps.begin();
    for round in 0..SHORTENED + STOPPED {
        let mut is_any = false;
        for (t, corners) in triangles.corners.iter().map(|corners| corners.map(|v| v as usize)).enumerate() {
            if !(sweeps.is_due(t, corners) || round == 0 || round == SHORTENED) {
                continue;
            }
            let from = corners.map(|v| travel.carry(increment.start[v]));
            let part = part_outside(shape, from, corners.map(|v| vertices.position[v]));
            if !(part < 1.0) {
                continue;
            }
            for (v, from) in corners.into_iter().zip(from) {
                let part = if round < SHORTENED { part } else { 0.0 };
                let way = (from - vertices.position[v]) * free[v] * (1.0 - part);
                if way != DVec3::ZERO {
                    is_any = true;
                    sweeps.note(v, counts);
                    force += shift(vertices, increment, v, way, step);
                }
            }
        }
        if !is_any {
            break;
        }
    }
    force
}

#[cfg(test)]
mod tests {
    use super::*;

    const BALL: Shape = Shape::Sphere { centre: DVec3::ZERO, radius: 0.2 };
    const OVER: [DVec3; 3] = [DVec3::new(-1.0, -1.0, 1.0), DVec3::new(1.0, -1.0, 1.0), DVec3::new(0.0, 2.0, 1.0)];

    #[test]
    fn a_triangle_goes_as_far_as_the_core() {
        let along = |way: DVec3| part_outside(&BALL, OVER, OVER.map(|x| x + way));
        // To 0.18 mm over the middle, within a thousandth of the way to there, and never beyond.
        for way in [0.9, 2.0, 20.0] {
            let part = along(DVec3::NEG_Z * way);
            assert!(part * way <= 0.82 && part * way > 0.82 - 1e-3, "{part} of {way}");
        }
        assert_eq!(along(DVec3::NEG_Z * 0.81), 1.0);
        assert_eq!(along(DVec3::Z * 5.0), 1.0);
        // Beside it.
        assert_eq!(
            part_outside(&BALL, OVER.map(|x| x + DVec3::X * 9.0), OVER.map(|x| x - DVec3::new(-9.0, 0.0, 2.0))),
            1.0
        );
    }

    #[test]
    fn one_that_turns_over_is_held_though_it_begins_and_ends_outside() {
        // About an edge beside the ball, from one side of it to the other: no corner is ever near, nor is the triangle at either end.
        let at = |z: f64| [DVec3::new(-0.5, -1.0, 0.0), DVec3::new(-0.5, 1.0, 0.0), DVec3::new(2.0, 0.0, z)];
        let part = part_outside(&BALL, at(2.0), at(-2.0));
        assert!(part > 0.1 && part < 0.5, "{part}");
    }

    #[test]
    fn what_is_in_the_core_may_leave_it_and_does_not_come_to_its_other_side() {
        let inside = OVER.map(|x| x - DVec3::Z * 0.9);
        assert_eq!(part_outside(&BALL, inside, inside.map(|x| x + DVec3::Z)), 1.0);
        let part = part_outside(&BALL, inside, inside.map(|x| x - DVec3::Z));
        assert!(part < 1.001e-3 && part > 0.98e-3, "{part}");
    }

    #[test]
    fn what_touches_the_core_is_free_to_leave_and_to_slide_and_never_gets_through_bit_by_bit() {
        let touching = OVER.map(|x| x - DVec3::Z * 0.82);
        let part = |way: DVec3| part_outside(&BALL, touching, touching.map(|x| x + way));
        assert_eq!([part(DVec3::Z), part(DVec3::X * 0.1)], [1.0; 2]);
        let mut at = touching;
        for step in 0..1000 {
            let to = at.map(|x| x - DVec3::Z);
            let part = part_outside(&BALL, at, to);
            at = [0, 1, 2].map(|i| at[i].lerp(to[i], part));
            // Half-way by half-way to 0.174 mm, as far as rounding tells them apart; then by hundredths.
            assert!(at[0].z > if step < 30 { 0.174 } else { 0.0 }, "{} after {step}", at[0].z);
        }
    }

    #[test]
    fn rods_and_ellipsoids_have_cores_as_long_as_they_are() {
        let rod = Shape::Capsule { ends: [DVec3::NEG_X, DVec3::X], radius: 0.2 };
        let ellipsoid =
            Shape::Ellipsoid { centre: DVec3::ZERO, half_axes: DVec3::new(1.0, 0.2, 0.2), axes: glam::DMat3::IDENTITY };
        for shape in [rod, ellipsoid] {
            for x in [-0.85, 0.0, 0.85] {
                let from = OVER.map(|p| p * DVec3::new(0.01, 0.01, 1.0) + DVec3::X * x);
                let part = part_outside(&shape, from, from.map(|p| p - DVec3::Z * 20.0));
                assert!(part < 0.05 && part > 0.04 - 1e-3, "{shape:?} at {x}: {part}");
            }
        }
    }
}

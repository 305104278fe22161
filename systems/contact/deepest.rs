//! The place of a triangle that is deepest in an obstacle.

use super::box_touch::{BoxTouch, box_touch};
use crate::components::Shape;
use crate::math::nearest_in_triangle;
use glam::{DMat3, DVec3};

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

/// A triangle in the frame of a box.
fn in_frame(centre: DVec3, axes: DMat3, x: [DVec3; 3]) -> [DVec3; 3] {
    x.map(|x| axes.transpose() * (x - centre))
}

/// Where a triangle is deepest in a shape, or nearest to it.
pub(super) struct Place {
    pub weights: [f64; 3],
    /// Distance along the normal \[mm\], negative inside.
    pub distance: f64,
    pub normal: DVec3,
    /// Whether the corners, which are held themselves, bear all.
    pub is_by_corners: bool,
}

impl Place {
    pub(super) fn of(shape: &Shape, x: [DVec3; 3]) -> Option<Self> {
        if let Shape::Box { centre, half, axes } = *shape {
            let local = in_frame(centre, axes, x);
            let BoxTouch { weights, normal, distance, is_by_corners } = box_touch(half, local);
            return distance.is_finite().then_some(Self { weights, distance, normal: axes * normal, is_by_corners });
        }
        let weights = deepest(shape, x)?;
        let (distance, normal) = shape.distance(at(x, weights))?;
        Some(Self { weights, distance, normal, is_by_corners: false })
    }
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
pub(super) fn nearest_of_segments([p, q]: [DVec3; 2], [a, b]: [DVec3; 2]) -> f64 {
    let (u, v, w) = (q - p, b - a, p - a);
    let (uu, vv, uv, uw, vw) = (u.dot(u), v.dot(v), u.dot(v), u.dot(w), v.dot(w));
    let clamped = |value: f64| if value.is_finite() { value.clamp(0.0, 1.0) } else { 0.0 };
    let s = clamped((uv * vw - uw * vv) / (uu * vv - uv * uv));
    let t = clamped((uv * s + vw) / vv);
    clamped((uv * t - uw) / uu)
}

#[cfg(test)]
mod tests {
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
}

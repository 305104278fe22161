//! Contact of a triangle with a box.
//!
//! The triangle touches along the axis on which it is farthest out of the box, or least inside: across a face of the box, across the
//! triangle, or across an edge of both. A mesh bends round an edge of a box only at its own edges, so that triangles across it are
//! pierced by a little; the axis across such a triangle does not change with the least turn, as the nearest face of a place inside does.
//!
//! Where an edge or a face of the box lies along the triangle, the least turn would move the nearest place from one end to the other. The
//! force then acts at the middle of all that is as near.

use super::deepest::nearest_of_segments;
use glam::DVec3;
use smallvec::SmallVec;

/// Place and normal of a contact, in the frame of the box.
#[derive(Clone, Copy, Debug)]
pub(super) struct BoxTouch {
    /// Barycentric weights of the place in the triangle.
    pub weights: [f64; 3],
    /// Unit normal out of the box.
    pub normal: DVec3,
    /// Distance of the triangle along the normal \[mm\], negative inside.
    pub distance: f64,
    /// Whether it bears on a face by its corners alone, which are held themselves.
    pub is_by_corners: bool,
}

/// Difference of lengths that count as equal, over the size: the triangle's longest edge or the box's least half width.
const TIE: f64 = 1e-3;

/// Depth of the zone of places that bear, from the nearest one on, over the size: several times the depth of tissue at rest.
const BEARING: f64 = 0.02;

/// Cosine between the normal of a triangle and that of the contact below which the triangle stands on its rim.
const LIES_ALONG: f64 = 0.5;

/// The sign of a number, 1 of zero.
fn sign(value: f64) -> f64 {
    if value < 0.0 { -1.0 } else { 1.0 }
}

/// Contact of a triangle `x` with a box of half widths `half` \[mm\], both in the box's frame (separating axes, Gottschalk, Lin and
/// Manocha 1996).
pub(super) fn box_touch(half: DVec3, x: [DVec3; 3]) -> BoxTouch {
    let edges = [x[1] - x[0], x[2] - x[1], x[0] - x[2]];
    let size = edges.iter().map(|edge| edge.length()).fold(0.0, f64::max).min(half.min_element());
    let mut best = BoxTouch { weights: [0.0; 3], normal: DVec3::Z, distance: f64::NEG_INFINITY, is_by_corners: false };
    let mut crossing = None;
    let mut consider = |axis: DVec3, edge: Option<(usize, usize)>| {
        let Some(axis) = axis.try_normalize() else { return };
        let extent = half.dot(axis.abs());
        for normal in [axis, -axis] {
            let distance = x.map(|x| normal.dot(x)).into_iter().fold(f64::INFINITY, f64::min) - extent;
            if distance > best.distance + if edge.is_some() { TIE * size } else { 0.0 } {
                (best.normal, best.distance, crossing) = (normal, distance, edge);
            }
        }
    };
    consider(edges[0].cross(edges[1]), None);
    DVec3::AXES.into_iter().for_each(|axis| consider(axis, None));
    for (i, edge) in edges.iter().enumerate() {
        for (j, axis) in DVec3::AXES.iter().enumerate() {
            consider(edge.cross(*axis), Some((i, j)));
        }
    }
    best.weights = match crossing {
        Some((i, axis)) => {
            let corner = DVec3::select(best.normal.cmplt(DVec3::ZERO), -half, half);
            let along = DVec3::AXES[axis];
            let ends = [1.0, -1.0].map(|side| corner * (DVec3::ONE - along) + along * (half * side));
            let j = (i + 1) % 3;
            let part = nearest_of_segments([x[i], x[j]], ends);
            let mut weights = [0.0; 3];
            (weights[i], weights[j]) = (1.0 - part, part);
            weights
        }
        None => {
            let heights = x.map(|x| best.normal.dot(x));
            let limit = heights.into_iter().fold(f64::INFINITY, f64::min) + TIE * size;
            let shares = heights.map(|height| (limit - height).max(0.0));
            let axis = best.normal.abs().max_position();
            let is_over_face = |x: DVec3| (1..3).all(|i| x[(axis + i) % 3].abs() <= half[(axis + i) % 3]);
            best.is_by_corners = x.iter().zip(shares).all(|(x, share)| share == 0.0 || is_over_face(*x));
            shares.map(|share| share / shares.iter().sum::<f64>())
        }
    };
    best.weights = bearing(half, x, &best, size);
    best
}

/// The middle of the places of a triangle that bear on the box along the normal of a contact: its weights.
fn bearing(half: DVec3, x: [DVec3; 3], touch: &BoxTouch, size: f64) -> [f64; 3] {
    let BoxTouch { weights, normal, .. } = *touch;
    let own = (x[1] - x[0]).cross(x[2] - x[0]);
    let area = own.length();
    let lies_along = own.dot(normal);
    if !(lies_along.abs() > LIES_ALONG * area) {
        return weights;
    }
    // The face that looks most along the normal, seen along the normal: places as two weights and the distance.
    let axis = normal.abs().max_position();
    let (p, q) = ((axis + 1) % 3, (axis + 2) % 3);
    let middle = DVec3::AXES[axis] * (half[axis] * sign(normal[axis]));
    let corners = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
    let mut places: Polygon = corners
        .iter()
        .map(|(a, b)| {
            let corner = middle + DVec3::AXES[p] * (half[p] * a) + DVec3::AXES[q] * (half[q] * b);
            let distance = own.dot(x[0] - corner) / lies_along;
            let place = corner + normal * distance;
            let part = |a: DVec3, b: DVec3| (a - place).cross(b - place).dot(own) / (area * area);
            DVec3::new(part(x[1], x[2]), part(x[2], x[0]), distance)
        })
        .collect();
    places = clipped(&places, |place| place.x);
    places = clipped(&places, |place| place.y);
    places = clipped(&places, |place| 1.0 - place.x - place.y);
    let limit = places.iter().map(|place| place.z).fold(f64::INFINITY, f64::min) + BEARING * size;
    places = clipped(&places, |place| limit - place.z);
    // Sums over the triangles of a fan, of a weight that falls to zero at the limit.
    let (mut sum, mut moment) = (0.0, DVec3::ZERO);
    for pair in places.get(1..).unwrap_or_default().windows(2) {
        let fan = [places[0], pair[0], pair[1]];
        let part = (fan[1] - fan[0]).truncate().perp_dot((fan[2] - fan[0]).truncate()).abs();
        let shares = fan.map(|place| limit - place.z);
        let all = shares.iter().sum::<f64>();
        sum += part * all * 4.0;
        moment += part * (0..3).map(|i| fan[i] * (all + shares[i])).sum::<DVec3>();
    }
    let mean = moment / sum;
    if mean.is_finite() { [mean.x, mean.y, 1.0 - mean.x - mean.y] } else { weights }
}

/// A convex polygon.
type Polygon = SmallVec<[DVec3; 8]>;

/// The part of a polygon where a linear function is not negative (Sutherland, Hodgman 1974).
fn clipped(polygon: &Polygon, inside: impl Fn(DVec3) -> f64) -> Polygon {
    let mut part = Polygon::new();
    for (i, &to) in polygon.iter().enumerate() {
        let from = polygon[(i + polygon.len() - 1) % polygon.len()];
        let (of_from, of_to) = (inside(from), inside(to));
        if (of_from < 0.0) != (of_to < 0.0) {
            part.push(from.lerp(to, of_from / (of_from - of_to)));
        }
        if !(of_to < 0.0) {
            part.push(to);
        }
    }
    part
}

#[cfg(test)]
mod tests {
    use super::*;

    const HALF: DVec3 = DVec3::new(4.0, 3.0, 1.5);

    fn at(x: [DVec3; 3], weights: [f64; 3]) -> DVec3 {
        x[0] * weights[0] + x[1] * weights[1] + x[2] * weights[2]
    }

    /// Triangles all about the box, some through it.
    fn triangles() -> impl Iterator<Item = [DVec3; 3]> {
        (1..2000).map(|i| {
            let at_random = |k: f64| (f64::from(i) * k).sin();
            let middle = HALF * DVec3::new(at_random(1.1), at_random(2.3), at_random(3.7)) * 1.6;
            [0.7, 1.9, 2.7].map(|k| middle + DVec3::new(at_random(k), at_random(k + 0.31), at_random(k + 0.57)))
        })
    }

    #[test]
    fn a_triangle_that_goes_out_along_the_normal_is_free_of_the_box() {
        let (mut inside, mut outside) = (0, 0);
        for x in triangles() {
            let touch = box_touch(HALF, x);
            let moved = x.map(|x| x - touch.normal * (touch.distance - 1e-9));
            // Then none of its points is in the box.
            for i in 0..=12 {
                for j in 0..=12 - i {
                    let weights = [f64::from(i) / 12.0, f64::from(j) / 12.0, f64::from(12 - i - j) / 12.0];
                    assert!((at(moved, weights).abs() - HALF).max_element() > -1e-9, "{x:?} along {}", touch.normal);
                }
            }
            // No face is a shorter way out, and weights are those of a point of the triangle.
            let of_face = |axis: DVec3| x.map(|x| axis.dot(x)).into_iter().fold(f64::INFINITY, f64::min);
            let by_face = DVec3::AXES.map(|axis| of_face(axis).max(of_face(-axis)) - axis.dot(HALF));
            assert!(by_face.iter().all(|distance| *distance <= touch.distance));
            assert!(touch.weights.iter().all(|weight| *weight > -1e-9));
            assert!((touch.weights.iter().sum::<f64>() - 1.0).abs() < 1e-9);
            if touch.distance < 0.0 { inside += 1 } else { outside += 1 }
        }
        assert!(inside > 200 && outside > 200, "{inside} inside, {outside} outside");
    }

    #[test]
    fn an_edge_that_lies_across_a_triangle_bears_at_its_middle_whatever_the_turn() {
        // Over the upper edge along y at x = 4, that the triangle slopes down beyond.
        let sloping = |turn: f64| {
            [DVec3::new(3.0, -0.5, 1.7 + turn), DVec3::new(5.0, -0.5, 1.2 + turn), DVec3::new(4.0, 0.5, 1.45 - turn)]
        };
        let place = |turn: f64| {
            let touch = box_touch(HALF, sloping(turn));
            assert!(!touch.is_by_corners && touch.normal.dot(DVec3::new(0.25, 0.0, 1.0).normalize()) > 0.999);
            at(sloping(turn), touch.weights)
        };
        for turn in [-1e-3, -1e-6, 1e-6, 1e-3] {
            assert!((place(turn) - place(0.0)).length() < 50.0 * turn.abs(), "{} {}", place(turn), place(0.0));
        }
    }

    #[test]
    fn a_triangle_over_a_face_is_left_to_its_corners_and_one_across_its_rim_is_not() {
        let flat = [DVec3::new(0.0, 0.0, 1.49), DVec3::new(1.0, 0.0, 1.49), DVec3::new(0.0, 1.0, 1.49)];
        assert!(box_touch(HALF, flat).is_by_corners);
        assert!(!box_touch(HALF, flat.map(|x| x + DVec3::X * 3.5)).is_by_corners);
    }
}

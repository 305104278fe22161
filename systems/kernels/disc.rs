//! Exact area of the overlap of a disc and a triangle: the weight of a triangle in an average over a disc.
//!
//! By Green's theorem the overlap is the sum over the triangle's directed edges of the signed area that the disc shares with the
//! triangle (centre, a, b). Where the edge runs inside the disc that is a triangle, where it runs outside a circular sector.

use crate::math::elementary;
use glam::DVec2;
use smallvec::SmallVec;
use std::f64::consts::PI;

/// Area \[mm²\] that the disc and the triangle share, whatever the triangle's orientation; zero for a degenerate triangle, a
/// radius that is not positive, or anything not finite.
///
/// Exact to rounding of the larger of the two figures' coordinates relative to the centre, so long as their sizes differ by
/// less than 1e150.
pub fn disc_triangle_overlap(centre: DVec2, radius: f64, triangle: [DVec2; 3]) -> f64 {
    let [a, b, c] = triangle.map(|x| x - centre);
    let r_sq = radius * radius;
    let is_inside = |x: DVec2| x.length_squared() <= r_sq;
    // Most triangles of a disc lie inside; sizes far from one are scaled first.
    if PLAIN.contains(&r_sq) && is_inside(a) && is_inside(b) && is_inside(c) && radius > 0.0 {
        return 0.5 * (b - a).perp_dot(c - a).abs();
    }
    let corners = [a, b, c];
    let scale = corners.iter().fold(radius, |m, x| m.max(x.abs().max_element()));
    if !(radius > 0.0 && scale.is_finite() && corners.iter().all(|x| x.is_finite())) {
        return 0.0;
    }
    let overlap = scaled_overlap(radius / scale, corners.map(|x| x / scale));
    (overlap * scale * scale).min(f64::MAX)
}

/// Squared radii for which no square or product of a triangle of tolerable size over- or underflows.
const PLAIN: std::ops::RangeInclusive<f64> = 1e-100..=1e100;

/// The overlap with the disc of radius `r` about the origin, where the larger of the two figures has the size one.
fn scaled_overlap(r: f64, [a, b, c]: [DVec2; 3]) -> f64 {
    // From edges, not from corners: far from the centre the products of corners cancel.
    let triangle_area = 0.5 * (b - a).perp_dot(c - a).abs();
    let r_sq = r * r;
    let is_inside = [a, b, c].map(|x| x.length_squared() <= r_sq);
    if is_inside == [true; 3] {
        return triangle_area;
    }
    let mut parts = Parts::default();
    let mut misses = 0;
    for i in 0..3 {
        let j = (i + 1) % 3;
        misses += u32::from(!parts.add_edge([a, b, c][i], [a, b, c][j], r, is_inside[i] && is_inside[j]));
    }
    let crosses = [a.perp_dot(b), b.perp_dot(c), c.perp_dot(a)];
    let surrounds = crosses.iter().all(|x| *x > 0.0) || crosses.iter().all(|x| *x < 0.0);
    if misses == 3 {
        return if surrounds { triangle_area.min(PI * r_sq) } else { 0.0 };
    }
    (parts.straight + 0.5 * r_sq * parts.arc(surrounds)).abs().min(triangle_area).min(PI * r_sq)
}

/// The overlap's parts: signed area over the pieces of edges inside the disc, and the arcs over those outside.
#[derive(Default)]
struct Parts {
    straight: f64,
    /// Cosine and sine of each arc's angle, to one factor.
    arcs: SmallVec<[DVec2; 6]>,
}

impl Parts {
    /// Adds the contribution of the edge from `a` to `b`. Whether any of it lies inside the disc.
    fn add_edge(&mut self, a: DVec2, b: DVec2, r: f64, is_inside: bool) -> bool {
        let edge = b - a;
        let cross = a.perp_dot(edge);
        if is_inside {
            self.straight += 0.5 * cross;
            return true;
        }
        let length_sq = edge.length_squared();
        if length_sq == 0.0 {
            return false;
        }
        let distance = cross.abs() / length_sq.sqrt();
        // r² − distance² as a product: at a tangency the difference of the squares has no digits left.
        let half_chord = ((r - distance).max(0.0) * (r + distance) / length_sq).sqrt();
        let foot = -a.dot(edge) / length_sq;
        let (enter, leave) = ((foot - half_chord).max(0.0), (foot + half_chord).min(1.0));
        if enter >= leave {
            self.add_arc(a.dot(b), cross);
            return false;
        }
        if enter > 0.0 {
            self.add_arc(a.dot(a + edge * enter), cross * enter);
        }
        if leave < 1.0 {
            self.add_arc((a + edge * leave).dot(b), cross * (1.0 - leave));
        }
        self.straight += 0.5 * cross * (leave - enter);
        true
    }

    fn add_arc(&mut self, dot: f64, cross: f64) {
        self.arcs.push(DVec2::new(dot, cross));
    }

    /// The sum of the arcs' angles \[rad\]. Seen from outside the triangle it is less than half a turn: then one arctangent
    /// of the product will do.
    fn arc(&self, surrounds: bool) -> f64 {
        if surrounds {
            return self.arcs.iter().map(|arc| elementary::angle_of(*arc)).sum();
        }
        let unit = |arc: &DVec2| *arc / arc.abs().max_element();
        self.arcs.iter().map(unit).reduce(|product, arc| arc.rotate(product)).map_or(0.0, elementary::angle_of)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::{FRAC_PI_2, TAU};

    const fn v(x: f64, y: f64) -> DVec2 {
        DVec2::new(x, y)
    }

    /// Closed forms are met to a few roundings of sums of order one.
    const ROUNDING: f64 = 4e-15;

    #[test]
    fn closed_forms() {
        let big = [v(-10.0, -10.0), v(20.0, -10.0), v(-10.0, 20.0)];
        let cases = [
            ("disc inside", v(0.0, 0.0), 2.0, big, 4.0 * PI),
            ("triangle inside", v(0.2, 0.1), 3.0, [v(0.0, 0.0), v(1.0, 0.0), v(0.0, 1.0)], 0.5),
            ("half disc", v(0.0, 0.0), 1.0, [v(-9.0, 0.0), v(9.0, 0.0), v(0.0, 9.0)], FRAC_PI_2),
            ("quadrant", v(0.0, 0.0), 1.0, [v(0.0, 0.0), v(9.0, 0.0), v(0.0, 9.0)], 0.25 * PI),
            ("apart", v(5.0, 5.0), 1.0, [v(0.0, 0.0), v(1.0, 0.0), v(0.0, 1.0)], 0.0),
            ("tangent from outside", v(0.0, -1.0), 1.0, [v(-9.0, 0.0), v(9.0, 0.0), v(0.0, 9.0)], 0.0),
            ("tangent from inside", v(0.0, 1.0), 1.0, [v(-90.0, 0.0), v(90.0, 0.0), v(0.0, 90.0)], PI),
            // Segment of height 1/2 of the unit disc: acos(1/2) − √3/4.
            ("segment", v(0.0, -0.5), 1.0, [v(-9.0, 0.0), v(9.0, 0.0), v(0.0, 9.0)], PI / 3.0 - 0.75f64.sqrt() / 2.0),
            // Incircle of the equilateral triangle with side 2√3, and a triangle with its corners on the circle.
            ("incircle", v(0.0, 1.0), 1.0, [v(-(3f64.sqrt()), 0.0), v(3f64.sqrt(), 0.0), v(0.0, 3.0)], PI),
            ("inscribed", v(0.0, 0.0), 1.0, [v(1.0, 0.0), v(0.0, 1.0), v(-1.0, 0.0)], 1.0),
        ];
        for (name, centre, radius, [a, b, c], expected) in cases {
            for triangle in [[a, b, c], [b, c, a], [c, b, a]] {
                let area = disc_triangle_overlap(centre, radius, triangle);
                assert!((area - expected).abs() <= ROUNDING * expected.max(1.0), "{name}: {area} against {expected}");
            }
        }
    }

    #[test]
    fn extreme_ratios_keep_their_digits() {
        for scale in [1e-100, 1e-8, 1.0, 1e8, 1e100] {
            for ratio in [1e-8, 1e-4, 1.0, 1e4, 1e8] {
                // A triangle of size `scale`, its long edge through the centre of a disc `ratio` times as large.
                let (r, t) = (scale * ratio, [v(-1.0, 0.0) * scale, v(1.0, 0.0) * scale, v(0.0, 1.0) * scale]);
                let area = disc_triangle_overlap(DVec2::ZERO, r, t);
                let expected = if ratio < 0.5 { FRAC_PI_2 * r * r } else { scale * scale };
                assert!((area / expected - 1.0).abs() < ROUNDING, "{scale} {ratio}: {area} against {expected}");
            }
        }
    }

    #[test]
    fn degenerate_and_hostile_input_is_zero() {
        let (good, line) = ([v(0.0, 0.0), v(1.0, 0.0), v(0.0, 1.0)], [v(-1.0, -1.0), v(0.5, 0.5), v(2.0, 2.0)]);
        assert_eq!(disc_triangle_overlap(v(0.1, 0.1), 1.0, line), 0.0);
        assert_eq!(disc_triangle_overlap(v(0.1, 0.1), 1.0, [v(0.3, 0.2); 3]), 0.0);
        for radius in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(disc_triangle_overlap(DVec2::ZERO, radius, good), 0.0);
        }
        let odd = [f64::NAN, f64::INFINITY, 1e308, -1e308, 5e-324, 0.0, 1.0];
        for i in 0..odd.len().pow(4) {
            let x = |place: u32| odd[i / odd.len().pow(place) % odd.len()];
            let area = disc_triangle_overlap(v(x(0), 0.0), x(1), [v(x(2), 1.0), v(0.0, x(3)), v(1.0, 0.0)]);
            assert!(area.is_finite() && area >= 0.0);
        }
    }

    /// The disc as a polygon of many corners, clipped by the triangle's half-planes (Sutherland and Hodgman 1974).
    fn polygon_overlap(centre: DVec2, radius: f64, [a, b, c]: [DVec2; 3]) -> f64 {
        const COUNT: i32 = 4000;
        let corner = |i| centre + radius * DVec2::from_angle(TAU * f64::from(i) / f64::from(COUNT));
        let mut polygon: Vec<DVec2> = (0..COUNT).map(corner).collect();
        let sense = (b - a).perp_dot(c - a).signum();
        for (p, q) in [(a, b), (b, c), (c, a)] {
            let height = |x: DVec2| sense * (q - p).perp_dot(x - p);
            let mut clipped = Vec::new();
            for (i, &x) in polygon.iter().enumerate() {
                let next = polygon[(i + 1) % polygon.len()];
                let (h, k) = (height(x), height(next));
                if h >= 0.0 {
                    clipped.push(x);
                }
                if (h >= 0.0) != (k >= 0.0) {
                    clipped.push(x + (next - x) * (h / (h - k)));
                }
            }
            polygon = clipped;
        }
        let twice = polygon.iter().enumerate().map(|(i, x)| x.perp_dot(polygon[(i + 1) % polygon.len()])).sum::<f64>();
        0.5 * twice.abs()
    }

    fn point() -> impl Strategy<Value = DVec2> {
        (-2.0..2.0f64, -2.0..2.0f64).prop_map(|(x, y)| v(x, y))
    }

    proptest! {
        #![proptest_config(ProptestConfig { rng_seed: proptest::test_runner::RngSeed::Fixed(7), failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn agrees_with_a_fine_polygon(centre in point(), radius in 0.01..3.0f64, t in [point(), point(), point()]) {
            let (exact, polygon) = (disc_triangle_overlap(centre, radius, t), polygon_overlap(centre, radius, t));
            // The inscribed polygon with n corners lacks πr²·(2π/n)²/6 = 1.3e-6·r² at n = 4000, wherever the triangle lies.
            prop_assert!(exact - polygon > -1e-13 && exact - polygon < 1.3e-6 * radius * radius, "{exact} {polygon}");
        }

        #[test]
        fn is_additive(centre in point(), radius in 0.01..3.0f64, t in [point(), point(), point()], s in 0.0..1.0f64) {
            let [a, b, c] = t;
            let m = a.lerp(b, s);
            let parts = disc_triangle_overlap(centre, radius, [a, m, c]) + disc_triangle_overlap(centre, radius, [m, b, c]);
            // Rounding of m moves the edge by 1e-15 along a length below 6.
            prop_assert!((parts - disc_triangle_overlap(centre, radius, t)).abs() < 1e-13);
        }

        #[test]
        fn grows_with_the_radius(centre in point(), radius in 0.01..3.0f64, more in 0.0..0.5f64, t in [point(), point(), point()]) {
            let (small, large) = (disc_triangle_overlap(centre, radius, t), disc_triangle_overlap(centre, radius + more, t));
            // Rounding of sums of order r² = 10.
            prop_assert!(large - small > -1e-14 && large - small < PI * (2.0 * radius + more) * more + 1e-14);
        }

        #[test]
        fn a_triangulated_square_holds_the_whole_disc(centre in point(), radius in 0.1..1.0f64, n in 1u32..12) {
            let corner = |i: u32, j: u32| v(f64::from(i), f64::from(j)) * (8.0 / f64::from(n)) - v(4.0, 4.0);
            let mut sum = 0.0;
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let (a, b, c, d) = (corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1));
                sum += disc_triangle_overlap(centre, radius, [a, b, c]) + disc_triangle_overlap(centre, radius, [a, c, d]);
            }
            prop_assert!((sum / (PI * radius * radius) - 1.0).abs() < 1e-13, "{sum}");
        }
    }
}

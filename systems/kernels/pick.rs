//! The triangle that a ray meets first, and the one nearest to a point: the targets of pointing tools.

use crate::math::nearest_in_triangle;
use glam::{DVec2, DVec3};

/// A point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Picked {
    /// Row of the triangle.
    pub triangle: u32,
    /// Weights of its three corners there, with sum 1.
    pub weights: [f64; 3],
    /// The point \[mm\].
    pub position: DVec3,
    /// From the ray's origin along the ray, or from the point \[mm\].
    pub distance: f64,
}

/// The first triangle within `most` \[mm\] that a ray meets, from either side; of several at one distance that in the lowest row.
/// `None` also for an origin or a direction that is not finite, and for a direction without length.
///
/// Vertices are sheared so that the ray becomes an axis, and the signs of the areas that it spans with the edges decide (Woop,
/// Benthin, Wald 2013, Watertight ray/triangle intersection). The area of an edge has the same bits, but for its sign, in both
/// triangles at it, so that no ray slips through between them.
pub fn meet(positions: &[DVec3], corners: &[[u32; 3]], origin: DVec3, direction: DVec3, most: f64) -> Option<Picked> {
    // Scaled before it is made a unit vector: the square of a large or small one may not exist.
    let way = (direction / direction.abs().max_element()).try_normalize().filter(|_| origin.is_finite())?;
    let ahead = way.abs().max_position();
    let (left, right) = ((ahead + 1) % 3, (ahead + 2) % 3);
    let sheared = |p: DVec3| {
        let depth = p[ahead] / way[ahead];
        DVec2::new(p[left] - way[left] * depth, p[right] - way[right] * depth)
    };
    let mut first: Option<Picked> = None;
    for (row, corners) in (0..).zip(corners) {
        let [a, b, c] = corners.map(|v| positions[v as usize] - origin);
        let [p, q, r] = [a, b, c].map(sheared);
        let areas = [q.perp_dot(r), r.perp_dot(p), p.perp_dot(q)];
        let is_through = areas.iter().all(|&v| v >= 0.0) || areas.iter().all(|&v| v <= 0.0);
        let sum: f64 = areas.iter().sum();
        if !(is_through && sum != 0.0 && sum.is_finite()) {
            continue;
        }
        let weights = areas.map(|area| area / sum);
        let at = a * weights[0] + b * weights[1] + c * weights[2];
        let distance = at.dot(way);
        let limit = first.map_or(most, |first| first.distance);
        let is_nearer = if first.is_some() { distance < limit } else { distance <= limit };
        if distance >= 0.0 && is_nearer {
            first = Some(Picked { triangle: row, weights, position: origin + at, distance });
        }
    }
    first
}

/// The triangle with the point nearest to a point in space, no farther than `within` \[mm\]; of several equally near ones that
/// in the lowest row.
pub fn nearest(positions: &[DVec3], corners: &[[u32; 3]], point: DVec3, within: f64) -> Option<Picked> {
    let mut best: Option<Picked> = None;
    let mut least = f64::INFINITY;
    for (row, corners) in (0..).zip(corners) {
        let [a, b, c] = corners.map(|v| positions[v as usize]);
        let weights = nearest_in_triangle([a, b, c], point);
        let position = a * weights[0] + b * weights[1] + c * weights[2];
        let squared = position.distance_squared(point);
        if squared < least {
            least = squared;
            best = Some(Picked { triangle: row, weights, position, distance: squared.sqrt() });
        }
    }
    best.filter(|best| best.distance <= within)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sheet of 8 × 8 cells in the plane z = 1.
    fn sheet() -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let positions = (0..81).map(|i| DVec3::new(f64::from(i % 9) / 3.0, f64::from(i / 9) / 7.0, 1.0)).collect();
        let cell = |i: u32| [[i, i + 1, i + 10], [i, i + 10, i + 9]];
        (positions, (0..64).flat_map(|i| cell(i / 8 * 9 + i % 8)).collect())
    }

    #[test]
    fn no_ray_slips_through_between_triangles() {
        let (positions, corners) = sheet();
        // Through every vertex and middle of an edge inside the sheet, from a slanting side, both ways.
        let origin = DVec3::new(0.71, 0.13, -3.7);
        let inner = |p: &DVec3| p.x > 0.1 && p.x < 2.5 && p.y > 0.1 && p.y < 1.1;
        let edges = corners.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a], [a, a]]);
        let aims = edges.map(|[a, b]| positions[a as usize].midpoint(positions[b as usize])).filter(inner);
        let mut count = 0;
        for aim in aims {
            for (from, way) in [(origin, aim - origin), (2.0 * aim - origin, origin - aim)] {
                let met = meet(&positions, &corners, from, way, f64::INFINITY).unwrap();
                // Roundings at lengths of some millimetres.
                assert!(met.position.distance(aim) < 1e-14 * 10.0 && (met.distance - way.length()).abs() < 1e-13);
                count += 1;
            }
        }
        assert!(count > 300, "{count}");
    }

    #[test]
    fn a_ray_ends_and_does_not_look_back() {
        let (positions, corners) = sheet();
        let at = DVec3::new(1.4, 0.6, 0.0);
        let meet = |origin, way, most| meet(&positions, &corners, origin, way, most);
        assert_eq!(meet(at, DVec3::Z, 0.999), None);
        assert_eq!(meet(at, DVec3::NEG_Z, 9.0), None);
        assert_eq!(meet(at, DVec3::X, 9.0), None);
        for way in [DVec3::Z * 1e-200, DVec3::Z * 1e200] {
            let met = meet(at, way, 1.001).unwrap();
            assert!((met.distance - 1.0).abs() < 1e-15 && (met.weights.iter().sum::<f64>() - 1.0).abs() < 1e-15);
        }
        for bad in [DVec3::ZERO, DVec3::NAN, DVec3::X * f64::INFINITY] {
            assert_eq!(meet(at, bad, 9.0), None);
            assert_eq!(meet(DVec3::NAN, DVec3::Z, 9.0), None);
        }
    }

    #[test]
    fn the_nearest_triangle_is_found() {
        let (positions, corners) = sheet();
        let found = nearest(&positions, &corners, DVec3::new(-3.0, 0.0, 5.0), f64::INFINITY).unwrap();
        assert_eq!((found.position, found.distance), (DVec3::Z, 5.0));
        assert_eq!(nearest(&positions, &corners, DVec3::new(-3.0, 0.0, 5.0), 4.9), None);
        assert_eq!(nearest(&positions, &corners, DVec3::NAN, f64::INFINITY), None);
    }
}

//! The point of a triangle nearest to another.

use glam::DVec3;

/// Barycentric weights of the point of a triangle nearest to `p` (Ericson 2005, Real-Time Collision Detection, 5.1.5).
pub fn nearest_in_triangle([a, b, c]: [DVec3; 3], p: DVec3) -> [f64; 3] {
    let (ab, ac) = (b - a, c - a);
    let (d1, d2) = (ab.dot(p - a), ac.dot(p - a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let (d3, d4) = (ab.dot(p - b), ac.dot(p - b));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let w = d1 / (d1 - d3);
        return [1.0 - w, w, 0.0];
    }
    let (d5, d6) = (ab.dot(p - c), ac.dot(p - c));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let w = d2 / (d2 - d6);
        return [1.0 - w, 0.0, w];
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - w, w];
    }
    let sum = va + vb + vc;
    let (v, w) = (vb / sum, vc / sum);
    [1.0 - v - w, v, w]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_point_is_found_in_every_region() {
        let triangle = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let at = |p: DVec3| nearest_in_triangle(triangle, p);
        assert_eq!(at(DVec3::new(-1.0, -1.0, 3.0)), [1.0, 0.0, 0.0]);
        assert_eq!(at(DVec3::new(2.0, -0.5, 0.0)), [0.0, 1.0, 0.0]);
        assert_eq!(at(DVec3::new(-0.5, 2.0, 0.0)), [0.0, 0.0, 1.0]);
        assert_eq!(at(DVec3::new(0.25, -1.0, 1.0)), [0.75, 0.25, 0.0]);
        assert_eq!(at(DVec3::new(-1.0, 0.25, 1.0)), [0.75, 0.0, 0.25]);
        assert_eq!(at(DVec3::new(1.0, 1.0, 0.0)), [0.0, 0.5, 0.5]);
        assert_eq!(at(DVec3::new(0.25, 0.5, 7.0)), [0.25, 0.25, 0.5]);
    }
}

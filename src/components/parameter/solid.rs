//! Distances of solids: a box, a cylinder with flat ends, an ellipsoid.

use glam::DVec3;

/// Signed distance \[mm\] and outward normal of a box about the origin, its edges along x, y, z.
pub(in crate::components) fn of_box(x: DVec3, half: DVec3) -> (f64, DVec3) {
    let sign = DVec3::select(x.cmplt(DVec3::ZERO), DVec3::NEG_ONE, DVec3::ONE);
    let beyond = x.abs() - half;
    let outside = beyond.max(DVec3::ZERO);
    let distance = outside.length();
    if distance > 0.0 {
        return (distance, outside * sign / distance);
    }
    let axis = (0..3).max_by(|&i, &j| beyond[i].total_cmp(&beyond[j]).then(j.cmp(&i))).unwrap_or(0);
    (beyond[axis], DVec3::AXES[axis] * sign)
}

/// Signed distance and normal of a cylinder between its end centres; `None` on the axis unless an end is nearer.
pub(in crate::components) fn of_cylinder(x: DVec3, [a, b]: [DVec3; 2], radius: f64) -> Option<(f64, DVec3)> {
    let axis = (b - a).try_normalize()?;
    let from_middle = x - a.midpoint(b);
    let along = from_middle.dot(axis);
    let out = from_middle - axis * along;
    let end = axis * if along < 0.0 { -1.0 } else { 1.0 };
    let (beyond_side, beyond_end) = (out.length() - radius, along.abs() - 0.5 * a.distance(b));
    let side = out.try_normalize();
    match (beyond_side > 0.0, beyond_end > 0.0) {
        (true, true) => {
            let way = side? * beyond_side + end * beyond_end;
            let distance = way.length();
            Some((distance, way / distance))
        }
        (false, true) => Some((beyond_end, end)),
        (true, false) => Some((beyond_side, side?)),
        (false, false) if beyond_end > beyond_side => Some((beyond_end, end)),
        (false, false) => Some((beyond_side, side?)),
    }
}

/// The point of an ellipsoid about the origin that is closest to `x`, and the normal there: x = c + t·∇ with one unknown t (Eberly
/// 2013). The function of t falls and is convex above its pole, so that Newton's method from the left never overshoots. On a plane
/// of symmetry several points may be closest inside: there x is taken to be a little off it.
pub(in crate::components) fn closest_on_ellipsoid(x: DVec3, half_axes: DVec3) -> (DVec3, DVec3) {
    const OFF: f64 = 1e-12;
    const MOST_NEWTON_STEPS: u32 = 100;
    let squares = half_axes * half_axes;
    let y = x.abs().max(half_axes * OFF);
    let sign = DVec3::select(x.cmplt(DVec3::ZERO), DVec3::NEG_ONE, DVec3::ONE);
    let z = half_axes * y;
    // t counts from the pole of the shortest axis, where the sums would cancel.
    let above = squares - DVec3::splat(squares.min_element());
    let newton = |t: f64| {
        let ratio = z / (above + DVec3::splat(t));
        let value = ratio.length_squared() - 1.0;
        let slope = -2.0 * (ratio * ratio / (above + DVec3::splat(t))).element_sum();
        t - value / slope
    };
    // Where one term alone is one: left of the root. A step from where it is for x on the surface leads left of it as well, and is
    // all but there for a near x.
    let mut t = (z - above).max_element().max(newton(squares.min_element()));
    for _ in 0..MOST_NEWTON_STEPS {
        let next = newton(t);
        // To rounding, or no further.
        if !(next > t) {
            break;
        }
        t = next;
    }
    let closest = squares * y / (above + DVec3::splat(t)) * sign;
    (closest, (closest / squares).normalize_or(DVec3::Z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_edges_and_corners_are_right() {
        let half = DVec3::new(1.0, 2.0, 3.0);
        assert_eq!(of_box(DVec3::new(0.5, 0.0, 0.0), half), (-0.5, DVec3::X));
        assert_eq!(of_box(DVec3::new(0.0, -4.0, 1.0), half), (2.0, DVec3::NEG_Y));
        let (distance, normal) = of_box(DVec3::new(4.0, 6.0, 0.0), half);
        assert_eq!((distance, normal), (5.0, DVec3::new(0.6, 0.8, 0.0)));
        let ends = [DVec3::ZERO, DVec3::X * 4.0];
        assert_eq!(of_cylinder(DVec3::new(2.0, 3.0, 0.0), ends, 1.0), Some((2.0, DVec3::Y)));
        assert_eq!(of_cylinder(DVec3::new(-1.0, 0.0, 0.0), ends, 1.0), Some((1.0, DVec3::NEG_X)));
        assert_eq!(of_cylinder(DVec3::new(3.9, 0.0, 0.5), ends, 1.0).map(|at| at.1), Some(DVec3::X));
        let (distance, _) = of_cylinder(DVec3::new(7.0, 5.0, 0.0), ends, 1.0).unwrap();
        assert!((distance - 5.0).abs() < 1e-15, "3 and 4 from the edge: {distance}");
        assert_eq!(of_cylinder(DVec3::new(2.0, 0.0, 0.0), ends, 1.0), None);
    }

    #[test]
    fn the_closest_point_of_an_ellipsoid_lies_on_it_along_the_normal() {
        let half_axes = DVec3::new(4.9, 4.9, 2.4);
        for i in 0..400 {
            let at = |k: f64| (f64::from(i) * k).sin();
            let x = DVec3::new(7.0 * at(1.1), 7.0 * at(2.3), 5.0 * at(3.7));
            let (closest, normal) = closest_on_ellipsoid(x, half_axes);
            assert!(((closest / half_axes).length_squared() - 1.0).abs() < 1e-11, "{x}: {closest}");
            let off = (x - closest) - normal * (x - closest).dot(normal);
            assert!(off.length() < 1e-9, "{x}: {closest} {normal}");
            // None of many other points is closer.
            let distance = x.distance(closest);
            for j in 0..200 {
                let (s, c) = (f64::from(j) * 0.7).sin_cos();
                let z = (f64::from(j) * 1.3).sin();
                let other = DVec3::new(c * (1.0 - z * z).sqrt(), s * (1.0 - z * z).sqrt(), z) * half_axes;
                assert!(x.distance(other) > distance - 1e-9);
            }
        }
        // The middle, where a point of the shortest axis is closest.
        let (closest, _) = closest_on_ellipsoid(DVec3::ZERO, half_axes);
        assert!((closest.length() - 2.4).abs() < 1e-9, "{closest}");
    }
}

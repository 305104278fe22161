//! Distances of the obstacles with edges: a box and a cylinder with flat ends.

use glam::DVec3;

/// Signed distance \[mm\] and outward normal of a box about the origin, its edges along x, y, z.
pub(super) fn of_box(x: DVec3, half: DVec3) -> (f64, DVec3) {
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

/// The same of a cylinder between the middles of its ends; `None` on the axis where that is no nearer to an end.
pub(super) fn of_cylinder(x: DVec3, [a, b]: [DVec3; 2], radius: f64) -> Option<(f64, DVec3)> {
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
}

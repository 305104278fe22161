//! The target of a rhexis: a circle about the axis of the body's outer rim, on the body's surface at rest.

use glam::DVec3;
use rhexis::frame::BodyFrame;
use rhexis_scene::measures::Axis;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Points of the circle.
const POINTS: u32 = 180;

/// The axis through the middle of the body's outer rim at rest; `None` for a body without a rim.
pub(super) fn axis(body: &BodyFrame) -> Option<Axis> {
    let outlines = outlines(body).into_iter();
    let points = |rows: Vec<u32>| -> Vec<DVec3> { rows.iter().map(|&v| body.rest_positions[v as usize]).collect() };
    let length = |points: &[DVec3]| -> f64 {
        points.iter().zip(points.iter().cycle().skip(1)).map(|(a, b)| a.distance(*b)).sum()
    };
    let longest = outlines.map(points).max_by(|a, b| length(a).total_cmp(&length(b)))?;
    Axis::from_outline(&longest)
}

/// Closed loops of edges that one triangle has; at a vertex that two loops share, they are joined.
fn outlines(body: &BodyFrame) -> Vec<Vec<u32>> {
    let mut count: BTreeMap<[u32; 2], i32> = BTreeMap::new();
    for &[a, b, c] in &body.triangles {
        for [from, to] in [[a, b], [b, c], [c, a]] {
            *count.entry([from, to]).or_default() += 1;
            *count.entry([to, from]).or_default() -= 1;
        }
    }
    let mut next: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for ([from, to], _) in count.into_iter().filter(|(_, count)| *count > 0) {
        next.entry(from).or_default().push(to);
    }
    let mut loops = Vec::new();
    while let Some((&first, _)) = next.first_key_value() {
        let mut rows = Vec::new();
        let mut at = first;
        while let Some(to) = next.get_mut(&at).and_then(Vec::pop) {
            rows.push(at);
            if next.get(&at).is_some_and(Vec::is_empty) {
                next.remove(&at);
            }
            at = to;
        }
        next.remove(&at);
        loops.push(rows);
    }
    loops
}

/// The circle with this diameter \[mm\].
///
/// # Errors
/// Where it does not lie on the body.
pub(super) fn target(body: &BodyFrame, axis: &Axis, diameter: f64) -> Result<Vec<DVec3>, String> {
    let side = axis.direction.any_orthonormal_vector();
    let other = axis.direction.cross(side);
    let at = |k: u32| {
        let angle = f64::from(k) * TAU / f64::from(POINTS);
        axis.point + 0.5 * diameter * (side * angle.cos() + other * angle.sin())
    };
    let points: Vec<Option<DVec3>> = (0..POINTS).map(|k| on_surface(body, axis.direction, at(k))).collect();
    let found: Vec<DVec3> = points.into_iter().flatten().collect();
    // A few may fall between the lips of a cut.
    if found.len() < POINTS as usize * 9 / 10 {
        return Err(format!("a circle of {diameter} mm does not lie on the body; give a smaller --circle"));
    }
    Ok(found)
}

/// The point of the surface at rest that lies over another along a direction, the foremost of several.
fn on_surface(body: &BodyFrame, direction: DVec3, point: DVec3) -> Option<DVec3> {
    let heights = body.triangles.iter().filter_map(|corners| {
        let [a, b, c] = corners.map(|v| body.rest_positions[v as usize] - point);
        let area = |p: DVec3, q: DVec3| p.cross(q).dot(direction);
        let weights = [area(b, c), area(c, a), area(a, b)];
        let sum: f64 = weights.iter().sum();
        let is_over = sum != 0.0 && weights.iter().all(|weight| weight / sum >= 0.0);
        is_over.then(|| (weights[0] * a + weights[1] * b + weights[2] * c).dot(direction) / sum)
    });
    heights.reduce(f64::max).map(|height| point + height * direction)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_circle_lies_on_the_cap_about_its_pole() {
        let mesh = rhexis::generate::cap(10.0, 9.8, 400).unwrap();
        let body = BodyFrame { rest_positions: mesh.positions, triangles: mesh.triangles, ..BodyFrame::default() };
        let axis = axis(&body).unwrap();
        assert!(axis.direction.z > 0.999 && axis.point.truncate().length() < 1e-3, "{axis:?}");
        let circle = target(&body, &axis, 5.0).unwrap();
        for point in circle {
            assert!((axis.offset(point).length() - 2.5).abs() < 1e-9);
            // On a ball of radius 10 about (0, 0, -10): chords of 0.5 mm edges lie up to 0.5²/8/10 mm beneath it, twice that at corners.
            assert!((point.distance(DVec3::new(0.0, 0.0, -10.0)) - 10.0).abs() < 0.02, "{point}");
        }
        assert!(target(&body, &axis, 12.0).is_err_and(|error| error.contains("--circle")));
    }
}

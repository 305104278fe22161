//! How far two tear paths are apart: the Hausdorff distance of polylines as sets of points, not of their vertices only.

use glam::DVec2;

/// Distances are found to this \[mm\].
const EXACT: f64 = 1e-9;

/// The largest distance \[mm\] from a point of either polyline to the other. Infinite where one has no point.
pub fn hausdorff(a: &[DVec2], b: &[DVec2]) -> f64 {
    farthest(a, b).max(farthest(b, a))
}

/// The largest distance \[mm\] from a point of `path` to the polyline `other`.
pub fn farthest(path: &[DVec2], other: &[DVec2]) -> f64 {
    if path.is_empty() || other.is_empty() {
        return f64::INFINITY;
    }
    let mut worst = path.iter().map(|&p| distance(p, other)).fold(0.0, f64::max);
    let mut pieces: Vec<[DVec2; 2]> = path.windows(2).map(|w| [w[0], w[1]]).collect();
    // Halving, without the pieces that cannot hold a farther point: no point of a piece is farther from a segment than the
    // farther of its ends, because the distance to a convex set is convex.
    while let Some([p, q]) = pieces.pop() {
        let bound = segments(other).map(|s| to_segment(p, s).max(to_segment(q, s))).fold(f64::INFINITY, f64::min);
        if bound > worst + EXACT {
            let middle = p.midpoint(q);
            worst = worst.max(distance(middle, other));
            pieces.extend([[p, middle], [middle, q]]);
        }
    }
    worst
}

/// Distance \[mm\] of a point from a polyline of at least one point.
pub fn distance(p: DVec2, path: &[DVec2]) -> f64 {
    segments(path).map(|s| to_segment(p, s)).fold(f64::INFINITY, f64::min)
}

fn segments(path: &[DVec2]) -> impl Iterator<Item = [DVec2; 2]> {
    // A single point is a segment without length.
    let ends = path.iter().skip(1).chain(path.last().filter(|_| path.len() == 1));
    path.iter().zip(ends).map(|(&a, &b)| [a, b])
}

fn to_segment(p: DVec2, [a, b]: [DVec2; 2]) -> f64 {
    let (along, from) = (b - a, p - a);
    let length_sq = along.length_squared();
    let part = if length_sq > 0.0 { (from.dot(along) / length_sq).clamp(0.0, 1.0) } else { 0.0 };
    (from - along * part).length()
}

#[cfg(test)]
mod tests {
    use super::super::super::reference::{Json, file};
    use super::*;

    #[test]
    fn listed_pairs_have_their_exact_distance() {
        let (name, text) = file!("path_properties.json");
        let file = Json::new(name, text).unwrap();
        for i in 0..file.len("/hausdorff_self_test/cases").unwrap() {
            let at = |key: &str| format!("/hausdorff_self_test/cases/{i}/{key}");
            let [a, b] =
                ["A", "B"].map(|key| file.vectors(&at(key)).unwrap().iter().map(|p| p.truncate()).collect::<Vec<_>>());
            let exact = file.number(&at("exact")).unwrap();
            assert!((hausdorff(&a, &b) - exact).abs() < 2.0 * EXACT, "{i}");
            assert_eq!(hausdorff(&a, &b), hausdorff(&b, &a));
            assert_eq!(hausdorff(&a, &a), 0.0);
        }
    }

    #[test]
    fn points_count_as_polylines_and_nothing_is_infinitely_far() {
        let [origin, far] = [[DVec2::ZERO], [DVec2::new(3.0, 4.0)]];
        assert_eq!((hausdorff(&origin, &far), hausdorff(&origin, &[])), (5.0, f64::INFINITY));
    }
}

//! Pieces of a body, of which the small ones set no frame: a chip that flies off would leave the rest a dot.

use glam::DVec3;
use rhexis::frame::BodyFrame;

/// A piece counts that has this part of the body's area at rest.
const LEAST_PART: f64 = 0.05;

/// Where the vertices lie of the pieces that set the frame; of all where every one is small.
pub(super) fn framing(body: &BodyFrame) -> Vec<DVec3> {
    let piece = pieces(body);
    let mut areas = vec![0.0; body.positions.len()];
    for corners in &body.triangles {
        let [a, b, c] = corners.map(|v| body.rest_positions[v as usize]);
        areas[piece[corners[0] as usize] as usize] += 0.5 * (b - a).cross(c - a).length();
    }
    let least = LEAST_PART * areas.iter().sum::<f64>();
    let points = |least: f64| -> Vec<DVec3> {
        let large = body.triangles.iter().filter(|corners| areas[piece[corners[0] as usize] as usize] >= least);
        large.flatten().map(|&v| body.positions[v as usize]).collect()
    };
    let large = points(least);
    if large.is_empty() { points(f64::NEG_INFINITY) } else { large }
}

/// The lowest vertex of each vertex's piece.
fn pieces(body: &BodyFrame) -> Vec<u32> {
    let mut root: Vec<u32> = (0..body.positions.len() as u32).collect();
    for &[a, b, c] in &body.triangles {
        for other in [b, c] {
            let (a, b) = (find(&mut root, a), find(&mut root, other));
            root[a.max(b) as usize] = a.min(b);
        }
    }
    (0..root.len() as u32).map(|v| find(&mut root, v)).collect()
}

fn find(root: &mut [u32], mut v: u32) -> u32 {
    while root[v as usize] != v {
        root[v as usize] = root[root[v as usize] as usize];
        v = root[v as usize];
    }
    v
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chip_that_flies_off_sets_no_frame() {
        let square = |at: DVec3, size: f64| {
            [(0., 0.), (1., 0.), (1., 1.), (0., 1.)].map(|(x, y)| at + size * DVec3::new(x, y, 0.))
        };
        let mut body = BodyFrame::default();
        for (at, rest, size) in [(DVec3::ZERO, DVec3::ZERO, 10.0), (DVec3::splat(500.0), DVec3::splat(10.0), 1.0)] {
            let first = body.positions.len() as u32;
            body.positions.extend(square(at, size));
            body.rest_positions.extend(square(rest, size));
            body.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|corners: [u32; 3]| corners.map(|v| v + first)));
        }
        assert_eq!(pieces(&body), [0, 0, 0, 0, 4, 4, 4, 4]);
        let seen = framing(&body);
        assert!(seen.len() == 6 && seen.iter().all(|p| p.max_element() <= 10.0));
        // Two halves are two pieces, and both are seen.
        for p in &mut body.rest_positions[4..] {
            *p *= 10.0;
        }
        assert_eq!(framing(&body).len(), 12);
    }
}

//! Nearest points of the two parts of a pair.

use crate::components::Pair;
use crate::math::nearest_in_triangle;
use glam::DVec3;

/// The nearest points of a pair, at one state.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nearest {
    /// Weights of the rows in the distance of the first part from the second.
    pub weights: [f64; 4],
    /// That distance \[mm\].
    pub way: DVec3,
}

/// Parts at their vertices along a normal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Heights {
    /// Lowest vertex of the first part \[mm\].
    pub low: f64,
    /// Highest vertex of the second part \[mm\].
    pub high: f64,
}

impl Pair {
    /// Number of rows of the first part.
    pub(super) fn first(&self) -> usize {
        if self.are_edges { 2 } else { 1 }
    }

    /// Positions of the rows.
    pub(super) fn at(&self, x: &[DVec3]) -> [DVec3; 4] {
        self.rows.map(|row| x[row as usize])
    }

    /// The nearest points.
    pub(super) fn nearest(&self, x: &[DVec3]) -> Nearest {
        let p = self.at(x);
        let weights = if self.are_edges {
            let [s, t] = between_edges(p);
            [1.0 - s, s, t - 1.0, -t]
        } else {
            let [a, b, c] = nearest_in_triangle([p[1], p[2], p[3]], p[0]);
            [1.0, -a, -b, -c]
        };
        Nearest { weights, way: (0..4).map(|i| p[i] * weights[i]).sum() }
    }

    /// A normal across both parts; of edges their cross product.
    pub(super) fn across(&self, x: &[DVec3]) -> DVec3 {
        let [a, b, c, d] = self.at(x);
        if self.are_edges { (b - a).cross(d - c) } else { (c - b).cross(d - b) }
    }

    /// Heights of the parts along a normal.
    pub(super) fn heights(&self, normal: DVec3, x: &[DVec3]) -> Heights {
        let heights = self.at(x).map(|p| normal.dot(p));
        let (first, second) = heights.split_at(self.first());
        Heights {
            low: first.iter().copied().fold(f64::INFINITY, f64::min),
            high: second.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        }
    }
}

impl Heights {
    /// Gap between the parts \[mm\], negative where they are on each other's side.
    pub(super) fn gap(self) -> f64 {
        self.low - self.high
    }
}

/// Places of the nearest points along two edges, from 0 to 1; of parallel ones those about the middle of the first.
fn between_edges([p, q, a, b]: [DVec3; 4]) -> [f64; 2] {
    let (u, v, w) = (q - p, b - a, p - a);
    let (uu, vv, uv, uw, vw) = (u.dot(u), v.dot(v), u.dot(v), u.dot(w), v.dot(w));
    let determinant = uu * vv - uv * uv;
    let is_skew = determinant > 1e-12 * uu * vv;
    let s = if is_skew { ((uv * vw - uw * vv) / determinant).clamp(0.0, 1.0) } else { 0.5 };
    let t = ((uv * s + vw) / vv).clamp(0.0, 1.0);
    let s = ((uv * t - uw) / uu).clamp(0.0, 1.0);
    [s, ((uv * s + vw) / vv).clamp(0.0, 1.0)]
}

/// Whether an edge passes through a triangle.
fn crosses([p, q]: [DVec3; 2], [a, b, c]: [DVec3; 3]) -> bool {
    let normal = (b - a).cross(c - a);
    let (above, below) = (normal.dot(p - a), normal.dot(q - a));
    if !(above * below < 0.0) {
        return false;
    }
    let at = p.lerp(q, above / (above - below));
    [(a, b), (b, c), (c, a)].iter().all(|(from, to)| normal.dot((*to - *from).cross(at - *from)) > 0.0)
}

/// Whether two triangles pass through each other.
pub(super) fn cross([c, d]: [[DVec3; 3]; 2]) -> bool {
    let edges = |[a, b, c]: [DVec3; 3]| [[a, b], [b, c], [c, a]];
    let passes = |c: [DVec3; 3], d: [DVec3; 3]| edges(c).iter().any(|edge| crosses(*edge, d));
    passes(c, d) || passes(d, c)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The nearest points of random pairs by a search over a grid of places, refined three times.
    #[test]
    fn nearest_points_are_those_of_a_search() {
        let mut state = 7_u64;
        let mut random = move || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) as f64 / f64::from(1_u32 << 31) * 2.0 - 1.0
        };
        for case in 0..300 {
            let x: Vec<DVec3> = (0..4).map(|_| DVec3::new(random(), random(), random())).collect();
            let pair = Pair { are_edges: case % 2 == 0, rows: [0, 1, 2, 3], triangle: 0 };
            let place = |s: f64, t: f64| match pair.are_edges {
                true => x[0].lerp(x[1], s) - x[2].lerp(x[3], t),
                // Both halves of the square are the triangle.
                false => {
                    let (s, t) = if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) };
                    x[0] - (x[1] + (x[2] - x[1]) * s + (x[3] - x[1]) * t)
                }
            };
            let (mut middle, mut size, mut least) = ((0.5, 0.5), 0.5, f64::INFINITY);
            for _ in 0..12 {
                let mut best = middle;
                for i in -10..=10 {
                    for j in -10..=10 {
                        let s = (middle.0 + size * f64::from(i) / 10.0).clamp(0.0, 1.0);
                        let t = (middle.1 + size * f64::from(j) / 10.0).clamp(0.0, 1.0);
                        let length = place(s, t).length();
                        if length < least {
                            (least, best) = (length, (s, t));
                        }
                    }
                }
                (middle, size) = (best, 0.4 * size);
            }
            let nearest = pair.nearest(&x);
            let sum: f64 = nearest.weights.iter().sum();
            // The search ends at a grid of 1e-6 of the parts.
            assert!(nearest.way.length() < least + 1e-12 && nearest.way.length() > least - 1e-5, "{case}");
            assert!(sum.abs() < 1e-12);
        }
    }

    #[test]
    fn an_edge_crosses_a_triangle_from_one_side_to_the_other_inside_it() {
        let triangle = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
        assert!(crosses([at(0.2, 0.2, 1.0), at(0.2, 0.2, -1.0)], triangle));
        assert!(!crosses([at(0.8, 0.8, 1.0), at(0.8, 0.8, -1.0)], triangle));
        assert!(!crosses([at(0.2, 0.2, 1.0), at(0.2, 0.2, 0.1)], triangle));
    }
}

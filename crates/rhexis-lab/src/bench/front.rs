//! The Pareto front: what no other setting beats in both time and error.

/// How much faster another setting must be, at no larger error, to count as better: less is noise.
pub(super) const NOISE: f64 = 0.05;

/// Rounding of a sum of squares.
const LEAST_ERROR: f64 = 1e-15;

/// A setting's time \[ms\] and error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Point {
    /// \[ms\]
    pub ms: f64,
    /// Relative, or in mm.
    pub error: f64,
}

impl Point {
    /// A point; no error counts as smaller than rounding, so that one without any has its place on a logarithmic axis.
    pub(super) fn new(ms: f64, error: f64) -> Self {
        Self { ms, error: if error < LEAST_ERROR { LEAST_ERROR } else { error } }
    }

    /// Whether it has a time and an error that can be drawn.
    pub(super) fn is_known(self) -> bool {
        self.ms.is_finite() && self.error.is_finite() && self.ms > 0.0 && self.error > 0.0
    }

    fn is_beaten_by(self, other: Self, noise: f64) -> bool {
        other.is_known() && other.error <= self.error && other.ms < self.ms / (1.0 + noise)
    }
}

/// The fastest of those that beat the point at `place` by more than noise: where it is none, the point is on the front.
pub(super) fn better(points: &[Point], place: usize) -> Option<usize> {
    let beats = |i: &usize| points[place].is_beaten_by(points[*i], NOISE);
    (0..points.len()).filter(beats).min_by(|a, b| points[*a].ms.total_cmp(&points[*b].ms))
}

/// The points that none beats, from the fastest to the most exact.
pub(super) fn front(points: &[Point]) -> Vec<Point> {
    let mut known: Vec<Point> = points.iter().copied().filter(|point| point.is_known()).collect();
    known.sort_by(|a, b| a.ms.total_cmp(&b.ms).then(a.error.total_cmp(&b.error)));
    let mut front: Vec<Point> = Vec::new();
    for point in known {
        if front.last().is_none_or(|last| point.error < last.error) {
            front.push(point);
        }
    }
    front
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_is_what_nothing_beats() {
        let point = |(ms, error): (f64, f64)| Point { ms, error };
        let points = [(1.0, 1e-1), (2.0, 1e-2), (3.0, 2e-2), (2.04, 1e-2), (4.0, 1e-4), (f64::NAN, 1e-9)].map(point);
        assert_eq!(front(&points), [points[0], points[1], points[4]]);
        assert_eq!(better(&points, 2), Some(1));
        // Two per cent slower is as good.
        assert_eq!([0, 1, 3, 4].map(|i| better(&points, i)), [None; 4]);
    }
}

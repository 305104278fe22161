//! A quantity prescribed over time.

use crate::components::BodyError;
use crate::components::check::finite;

/// A piecewise linear function of time, constant before its first and after its last point.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Curve {
    points: Vec<(f64, f64)>,
}

/// Why points are no curve.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BadCurve {
    /// No points at all.
    #[error("a curve needs at least one point [time, value]")]
    Empty,
    /// Times must ascend strictly.
    #[error("point {0}: the time must be larger than that of the point before")]
    NotAscending(usize),
    /// A number is NaN or infinite.
    #[error("point {0}: time and value must be finite numbers")]
    NotFinite(usize),
}

impl Curve {
    /// A curve through (time \[ms\], value) points.
    ///
    /// # Errors
    /// Without points, with a non-finite number, or where the times do not ascend.
    ///
    /// # Examples
    /// ```
    /// use rhexis::components::{BadCurve, Curve};
    ///
    /// assert_eq!(Curve::new(Vec::new()), Err(BadCurve::Empty));
    /// ```
    pub fn new(points: Vec<(f64, f64)>) -> Result<Self, BadCurve> {
        if points.is_empty() {
            return Err(BadCurve::Empty);
        }
        if let Some(i) = points.iter().position(|(t, v)| !(t.is_finite() && v.is_finite())) {
            return Err(BadCurve::NotFinite(i));
        }
        if let Some(i) = points.windows(2).position(|w| w[1].0 <= w[0].0) {
            return Err(BadCurve::NotAscending(i + 1));
        }
        Ok(Self { points })
    }

    /// Curve with one value at all times.
    pub fn constant(value: f64) -> Self {
        Self { points: vec![(0.0, value)] }
    }

    /// From zero at time zero linearly to `value` at `duration` \[ms\], then held.
    ///
    /// # Errors
    /// If the duration is not positive or a number is not finite.
    pub fn ramp(duration: f64, value: f64) -> Result<Self, BadCurve> {
        Self::new(vec![(0.0, 0.0), (duration, value)])
    }

    /// The value at a time \[ms\].
    pub fn at(&self, time: f64) -> f64 {
        let after = self.points.partition_point(|p| p.0 <= time);
        match (after.checked_sub(1).map(|i| self.points[i]), self.points.get(after)) {
            (Some((t0, v0)), Some(&(t1, v1))) => v0 + (v1 - v0) * ((time - t0) / (t1 - t0)),
            (Some((_, v)), None) | (None, Some(&(_, v))) => v,
            (None, None) => 0.0,
        }
    }

    /// The points (time \[ms\], value).
    pub fn points(&self) -> &[(f64, f64)] {
        &self.points
    }
}

impl Curve {
    /// Judges it as a part of a component: a constant, or one that was read, may be anything.
    pub(crate) fn check(&self, component: &'static str) -> Result<(), BodyError> {
        for &(time, value) in &self.points {
            finite(component, "a time or value of the curve", [time, value])?;
        }
        let ascends = self.points.windows(2).all(|pair| pair[0].0 < pair[1].0) && !self.points.is_empty();
        let what = "a curve needs points, with times that ascend";
        ascends.then_some(()).ok_or(BodyError::Contradiction { component, what })
    }
}

impl TryFrom<Vec<(f64, f64)>> for Curve {
    type Error = BadCurve;

    fn try_from(points: Vec<(f64, f64)>) -> Result<Self, BadCurve> {
        Self::new(points)
    }
}

impl From<Curve> for Vec<(f64, f64)> {
    fn from(curve: Curve) -> Self {
        curve.points
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_linear_between_points_and_constant_outside() {
        let c = Curve::new(vec![(0.0, 1.0), (10.0, 3.0), (20.0, 0.0)]).unwrap();
        assert_eq!([-5.0, 0.0, 5.0, 10.0, 15.0, 20.0, 99.0].map(|t| c.at(t)), [1.0, 1.0, 2.0, 3.0, 1.5, 0.0, 0.0]);
    }

    #[test]
    fn refuses_what_is_no_function_of_time() {
        assert_eq!(Curve::new(vec![]), Err(BadCurve::Empty));
        assert_eq!(Curve::new(vec![(1.0, 0.0), (1.0, 1.0)]), Err(BadCurve::NotAscending(1)));
        assert_eq!(Curve::new(vec![(1.0, f64::NAN)]), Err(BadCurve::NotFinite(0)));
    }
}

//! Axis of the cone of half angle θ_P (`Tearing::cone`): the direction of a tear over a material length.

use crate::components::Tearing;
use crate::math::elementary;
use glam::DVec3;
use std::f64::consts::PI;

/// Length over which the axis may turn by θ_P, in averaging radii: within one disc the criterion sees one notch.
const TURNING_LENGTH: f64 = 1.0;

/// The cone's axis after an advance of this length \[mm\] in the unit direction `advanced`; `axis` is zero before the first.
///
/// The axis turns towards the tear by at most θ_P per R. Advances in the same direction add up, so that it does not matter into
/// how many a way is divided; a tear that turns less keeps its own direction as the axis.
pub fn turned_axis(axis: DVec3, advanced: DVec3, length: f64, tearing: &Tearing) -> DVec3 {
    let most = tearing.cone * length / (TURNING_LENGTH * tearing.radius);
    let across = advanced - axis * axis.dot(advanced);
    let turn = elementary::atan2(across.length(), axis.dot(advanced));
    if axis == DVec3::ZERO || tearing.cone >= PI || turn <= most {
        return advanced;
    }
    let Some(side) = across.try_normalize() else { return advanced };
    let (sine, cosine) = elementary::sin_cos(most);
    (axis * cosine + side * sine).normalize_or(advanced)
}

//! How holds turn, and which axes they hold.

use super::error::Fault;
use super::schema::HoldSpec;
use glam::DVec3;
use rhexis::components::{Path, Turning};

/// How a hold turns, with its place.
pub(super) fn turn(hold: &HoldSpec, place: usize, is_planar: bool, key: &str) -> Result<Option<(u32, Turning)>, Fault> {
    let Some(rotate) = &hold.rotate else {
        let what = "a pivot is given, and no turn about it";
        let fault = || Fault::new(format!("{key}.pivot"), what, "add `rotate`, or remove it");
        return if hold.pivot.is_some() { Err(fault()) } else { Ok(None) };
    };
    let points: Vec<(f64, DVec3)> =
        rotate.0.points.iter().map(|&(t, degrees)| (t, degrees.map(f64::to_radians))).collect();
    if is_planar && points.iter().any(|(_, vector)| vector.truncate() != glam::DVec2::ZERO) {
        let what = "a planar body turns about z only";
        return Err(Fault::new(format!("{key}.rotate"), what, "give [0, 0, angle], or remove `planar`"));
    }
    let pivot = hold.pivot.map_or(DVec3::ZERO, |pivot| pivot.0);
    Ok(Some((place as u32, Turning { pivot, vectors: Path { points } })))
}

pub(super) fn axes(text: &str, key: &str) -> Result<[bool; 3], Fault> {
    if text.is_empty() || text.chars().any(|c| !"xyz".contains(c)) {
        return Err(Fault::new(key, format!("`{text}` names no axes"), "write some of the letters xyz, as in \"xy\""));
    }
    Ok(['x', 'y', 'z'].map(|axis| text.contains(axis)))
}

//! Rotations over time: of obstacles, and of the motion that holds prescribe.

use crate::components::check::{Check, Host, number, place};
use crate::components::{BodyError, Holds, Path};
use crate::math::elementary;
use glam::{DMat3, DVec2, DVec3};

/// A turn about a point, over time.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Turning {
    /// The point \[mm\], before any displacement.
    pub pivot: DVec3,
    /// Rotation vectors \[rad\]: along the axis, as long as the angle; straight between the points.
    pub vectors: Path,
}

/// Rotation of prescribed holds: a point of one stands at its rotated rest position, displaced from there. *Parameter.*
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct HoldTurns {
    /// Places of holds among those of the body, each with its turn.
    pub list: Vec<(u32, Turning)>,
}

impl Turning {
    /// The rotation at a time \[ms\].
    pub fn at(&self, time: f64) -> DMat3 {
        let vector = self.vectors.at(time);
        let Some(n) = vector.try_normalize() else { return DMat3::IDENTITY };
        // Rodrigues 1840.
        let (sin, cos) = elementary::sin_cos(vector.length());
        let turn = |e: DVec3| e * cos + n.cross(e) * sin + n * (n.dot(e) * (1.0 - cos));
        DMat3::from_cols(turn(DVec3::X), turn(DVec3::Y), turn(DVec3::Z))
    }

    pub(in crate::components) fn check(&self, component: &'static str) -> Result<(), BodyError> {
        place(component, "pivot", self.pivot.to_array())?;
        self.vectors.check(component)
    }
}

impl HoldTurns {
    /// How the hold at a place turns, if it does.
    pub fn of(&self, hold: usize) -> Option<&Turning> {
        self.list.iter().find(|(place, _)| *place as usize == hold).map(|(_, turning)| turning)
    }

    /// Judges the turns beside the holds that they turn, and whether the body stays in its plane.
    pub(crate) fn check_beside(&self, holds: &Holds, is_planar: bool) -> Result<(), BodyError> {
        for (place, turning) in &self.list {
            holds.at("HoldTurns", *place)?;
            if is_planar && turning.vectors.points.iter().any(|(_, vector)| vector.truncate() != DVec2::ZERO) {
                let what = "a planar body turns about z alone: give rotation vectors along z";
                return Err(BodyError::Contradiction { component: "HoldTurns", what });
            }
        }
        Ok(())
    }
}

impl Check for HoldTurns {
    fn check(&self, _: &Host<'_>) -> Result<(), BodyError> {
        for (second, (hold, turning)) in self.list.iter().enumerate() {
            turning.check("HoldTurns")?;
            let is_first = self.list[..second].iter().all(|(first, _)| first != hold);
            number("HoldTurns", "the place of a hold", f64::from(*hold), (is_first, "give each hold one turn"))?;
        }
        Ok(())
    }
}

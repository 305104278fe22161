//! Holds that leave their vertices some motion: across a direction, along a line, or all alike under a force.

use crate::components::check::{Check, Host, finite, number};
use crate::components::{BodyError, Curve, HoldTurns, Holds};
use glam::DVec3;

/// The motion that a hold leaves its vertices.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub enum Guide {
    /// Held along this unit direction, free across it.
    Across(DVec3),
    /// Free along this unit direction, held across it.
    Along(DVec3),
    /// All vertices are displaced alike from their rest positions, without turning, by as much as the force on them makes: a clamp that
    /// is drawn by a dead weight. Offsets and curve of the hold have no part in it.
    Together {
        /// Force on all of them together \[N\] at curve value 1; parts along axes that the hold leaves free do nothing.
        force: DVec3,
        /// Factor of the force over time.
        curve: Curve,
    },
}

/// Guides of holds: exact constraints, met by every iterate of a solve. *Parameter.* A body without it spends nothing on it. Haptic models
/// ([`Haptics`](crate::simulation::Haptics)) and bodies that fall asleep take guided vertices for held ones.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct HoldGuides {
    /// Places of holds among those of the body, each with its guide.
    pub list: Vec<(u32, Guide)>,
}

impl HoldGuides {
    /// The guide of the hold at a place, if it has one.
    pub fn of(&self, hold: usize) -> Option<&Guide> {
        self.list.iter().find(|(place, _)| *place as usize == hold).map(|(_, guide)| guide)
    }

    /// Judges the guides beside the holds that they guide, the turns of these, and whether the body stays in its plane.
    pub(crate) fn check_beside(
        &self,
        holds: &Holds,
        turns: Option<&HoldTurns>,
        is_planar: bool,
    ) -> Result<(), BodyError> {
        let contradiction = |what| Err(BodyError::Contradiction { component: "HoldGuides", what });
        for (place, guide) in &self.list {
            let hold = holds.at("HoldGuides", *place)?;
            match guide {
                Guide::Across(_) | Guide::Along(_) if hold.axes != [true; 3] => {
                    return contradiction("a hold across or along a direction has all axes: mark all three");
                }
                Guide::Across(n) | Guide::Along(n) if is_planar && n.z != 0.0 => {
                    return contradiction("a planar body has its guides in its plane: give a direction in x and y");
                }
                Guide::Together { .. } if turns.is_some_and(|turns| turns.of(*place as usize).is_some()) => {
                    return contradiction("a hold that moves all together does not turn: remove its turn or its guide");
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// The curves of the forces.
    pub(crate) fn curves(&self) -> impl Iterator<Item = &Curve> {
        self.list.iter().filter_map(|(_, guide)| match guide {
            Guide::Together { curve, .. } => Some(curve),
            Guide::Across(_) | Guide::Along(_) => None,
        })
    }
}

impl Check for HoldGuides {
    fn check(&self, _: &Host<'_>) -> Result<(), BodyError> {
        for (second, (hold, guide)) in self.list.iter().enumerate() {
            match guide {
                Guide::Across(direction) | Guide::Along(direction) => {
                    let length = direction.length();
                    // Unit vectors are so to a few roundings.
                    let is_unit = (length - 1.0).abs() < 1e-9;
                    number("HoldGuides", "the length of a direction", length, (is_unit, "it must be 1"))?;
                }
                Guide::Together { force, curve } => {
                    finite("HoldGuides", "force", force.to_array())?;
                    curve.check("HoldGuides")?;
                }
            }
            let is_first = self.list[..second].iter().all(|(first, _)| first != hold);
            number("HoldGuides", "the place of a hold", f64::from(*hold), (is_first, "give each hold one guide"))?;
        }
        Ok(())
    }
}

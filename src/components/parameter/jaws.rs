//! How forceps or a grip hold tissue between their jaws.

use crate::components::BodyError;

/// Behaviour of jaws beyond their force limit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub enum Slip {
    /// They let go of all they hold.
    #[default]
    LetGo,
    /// The tissue slides between them until they pull with no more than the limit. Only of jaws with a stiffness: a constraint gives no
    /// way by which to measure how far.
    Slide,
}

/// How jaws hold. *Parameter.*
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Jaws {
    /// Pinch radius \[mm\] in the rest shape, about the point that is taken; the nearest vertex is always taken. Only tissue connected
    /// with that point within the radius is taken, none across a cut.
    pub radius: f64,
    /// Stiffness of the whole pinch \[N/mm\], shared by rest area (a third of a vertex's triangles'): a finer mesh, or a tear
    /// between the jaws, does not make it stiffer. `None` is a constraint.
    pub stiffness: Option<f64>,
    /// Most force \[N\] that they can hold; `None` for no limit. Judged after every step, so that one step may exceed it. In a step that is limited,
    /// and after a jump that a budget cuts short, it is judged on the part of the hand's way that springy jaws have gone with the tissue.
    pub force_limit: Option<f64>,
    /// Behaviour beyond the force limit.
    pub slip: Slip,
}

impl Jaws {
    /// Checks the numbers: the name of a wrong one, its value and its requirement.
    ///
    /// # Errors
    /// For a radius below zero, a stiffness or limit that is not positive, and for a number that is not finite; and for a constraint
    /// that is to slide.
    pub fn check(&self) -> Result<(), (&'static str, f64, &'static str)> {
        if !(self.radius >= 0.0 && self.radius.is_finite()) {
            return Err(("grip radius", self.radius, "it must be zero or more, and finite"));
        }
        for (what, value) in [("grip stiffness", self.stiffness), ("grip force limit", self.force_limit)] {
            if let Some(value) = value.filter(|value| !(*value > 0.0 && value.is_finite())) {
                return Err((what, value, "it must be positive and finite, or left out"));
            }
        }
        match (self.slip, self.stiffness, self.force_limit) {
            (Slip::Slide, None, Some(limit)) => Err((
                "grip force limit",
                limit,
                "jaws between which tissue slides need a stiffness; without one they can only let go",
            )),
            _ => Ok(()),
        }
    }
}

impl Jaws {
    /// Judges the numbers as a part of a component.
    pub(crate) fn validate(&self, component: &'static str) -> Result<(), BodyError> {
        let wrong = |(what, value, must)| BodyError::OutOfRange { component, what, row: None, value, must };
        self.check().map_err(wrong)
    }
}

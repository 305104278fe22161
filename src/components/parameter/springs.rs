//! Springs to ground: zonules, a soft foundation.

use crate::components::BodyError;
use crate::components::check::{Check, Host, at_row, not_negative, place};
use crate::storage::{Attached, Attachment};
use glam::DVec3;

/// Where a spring is fixed, and how stiff it is.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Anchor {
    /// Fixed point of space \[mm\].
    pub point: DVec3,
    /// Stiffness per rest area of the vertex (a third of its triangles') \[N/mm³\], ≥ 0: a torn vertex shares it out.
    pub stiffness: f64,
}

impl Attachment for Anchor {
    fn between(a: Self, b: Self, weight: f64) -> Self {
        Self { point: a.point.lerp(b.point, weight), stiffness: f64::between(a.stiffness, b.stiffness, weight) }
    }
}

/// Linear springs of zero rest length between vertices and fixed points of space. *Parameter.*
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Springs {
    /// The vertices and their anchors.
    pub anchors: Attached<Anchor>,
}

impl Check for Springs {
    fn check(&self, host: &Host<'_>) -> Result<(), BodyError> {
        host.rows("Springs", || "springs".to_owned(), self.anchors.rows())?;
        for (&row, anchor) in self.anchors.rows().iter().zip(self.anchors.values()) {
            not_negative("Springs", "spring stiffness", anchor.stiffness).map_err(at_row(row))?;
            place("Springs", "fixed point", anchor.point.to_array()).map_err(at_row(row))?;
        }
        Ok(())
    }
}

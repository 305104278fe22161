//! Springs to ground: zonules, a soft foundation.

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

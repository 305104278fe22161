//! Prescribed vertices: clamped edges, grips of a testing machine.

use super::Curve;
use crate::storage::Attached;
use glam::DVec3;

/// A group of vertices whose position is prescribed: rest position + curve(t) · offset. *Parameter.*
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Hold {
    /// Name in reports.
    pub name: String,
    /// The vertices, each with its displacement \[mm\] at curve value 1. Both copies of a duplicated vertex stay held.
    pub members: Attached<DVec3>,
    /// Which axes are prescribed; the others stay free.
    pub axes: [bool; 3],
    /// Factor of the offsets over time.
    pub curve: Curve,
}

/// All groups of prescribed vertices of a body. *Parameter.*
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Holds {
    /// The groups. No two prescribe the same axis of the same vertex.
    pub groups: Vec<Hold>,
}

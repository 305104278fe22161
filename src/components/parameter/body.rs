//! Which thing this is.

/// A deformable membrane. *Parameter.*
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Body {
    /// Name used in reports and files.
    pub name: String,
    /// Place in the order of spawning: the order of reports and events.
    pub order: u32,
}

/// Marks a body that stays in the plane of its mesh, z = const: the area is signed, nothing moves along z. *Parameter.*
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Planar;

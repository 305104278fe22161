//! Which thing this is.

/// A deformable membrane. *Parameter.*
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Name used in reports and files.
    pub name: String,
    /// Place in the order of spawning: the order of reports and events.
    pub order: u32,
}

/// Marks a body that stays in the plane of its mesh, z = const: the area is signed, nothing moves along z. *Parameter.*
#[derive(Clone, Copy, Debug, Default)]
pub struct Planar;

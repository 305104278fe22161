//! Where tissue fails without a tip.

use glam::DVec3;

/// A place where tissue is stretched beyond [`ultimate_stretch`](super::Tearing::ultimate_stretch) and is to part without a tip.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Parting {
    /// Row of the triangle.
    pub triangle: u32,
    /// Unit fibre direction in the rest shape.
    pub fibre: DVec3,
    /// Unit direction of the opening in the rest shape, across the greatest stretch.
    pub direction: DVec3,
    /// Stretch over the ultimate stretch; above 1.
    pub value: f64,
    /// The triangle's centroid \[mm, rest shape\].
    pub at: DVec3,
}

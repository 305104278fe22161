//! Where tissue fails without a tip.

use crate::components::{PartedBy, TearSite};
use glam::DVec3;

/// A place where tissue is to part without a tip.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct LigamentFailure {
    /// Rim vertex of a ligament, triangle stretched too far, or vertex of the tip that goes on into one.
    pub site: TearSite,
    /// Unit fibre direction there, in the rest shape.
    pub fibre: DVec3,
    /// Unit direction of the opening in the rest shape, across the greatest tension or stretch.
    pub direction: DVec3,
    /// Smallest criterion across the ligament, or stretch over the ultimate stretch; above 1.
    pub value: f64,
    /// Ends \[mm, rest shape\] of the way across a ligament; both at the triangle's centroid for a stretch.
    pub ends: [DVec3; 2],
    /// Why it parts.
    pub by: PartedBy,
}

//! Where tissue fails without a tip.

use super::TearSite;
use glam::DVec3;
use std::fmt;

/// Why tissue parts where no tip leads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub enum PartedBy {
    /// A strand narrower than R carries more than its strength over its whole width.
    Strand,
    /// The tissue is stretched beyond [`ultimate_stretch`](super::Tearing::ultimate_stretch).
    Stretch,
}

impl fmt::Display for PartedBy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Strand => "strand",
            Self::Stretch => "stretch",
        })
    }
}

/// A place where tissue is to part without a tip.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Parting {
    /// The vertex of the rim from which a strand parts, or the triangle that is stretched.
    pub site: TearSite,
    /// Unit fibre direction there, in the rest shape.
    pub fibre: DVec3,
    /// Unit direction of the opening in the rest shape, across the greatest tension or stretch.
    pub direction: DVec3,
    /// Smallest criterion across the strand, or stretch over the ultimate stretch; above 1.
    pub value: f64,
    /// Ends \[mm, rest shape\] of the way across a strand; both at the triangle's centroid for a stretch.
    pub ends: [DVec3; 2],
    /// Why it parts.
    pub by: PartedBy,
}

//! What the criterion finds for the split.

use crate::math::Sym2;
use glam::DVec3;

/// Where a tear starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TearSite {
    /// At the centroid of the triangle in this row.
    Triangle(u32),
    /// At the vertex in this row.
    Vertex(u32),
}

/// The criterion's answer at a tip, a vertex of the boundary or inside a triangle. Directions are unit vectors of the rest shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TearDecision {
    /// The row of the vertex or triangle.
    pub row: u32,
    /// The direction of the largest criterion.
    pub direction: DVec3,
    /// The criterion there; the tear advances where it exceeds 1.
    pub value: f64,
    /// 1 − (best other direction's criterion)/value; infinite without another.
    pub margin: f64,
    /// Whether the margin is under 5 %.
    pub is_ambiguous: bool,
    /// Mean Biot stress over the averaging disc \[MPa\], in `axes`.
    pub stress: Sym2,
    /// Mean fibre over the disc.
    pub fibre: DVec3,
    /// Axes of the tangent plane.
    pub axes: [DVec3; 2],
    /// Averaging radius over mean edge length; under 3 the mesh is too coarse for R.
    pub edges_per_radius: f64,
}

/// *Derived.* One decision per tip, in the order of the tips' rows, and one for the place where a tear may start.
#[derive(Clone, Debug, Default)]
pub struct TearDecisions {
    /// Per tip; `None` where no direction is admissible.
    pub tips: Vec<Option<TearDecision>>,
    /// The place with the largest criterion above 1, if the body may tear where there is no tip.
    pub start: Option<(TearSite, TearDecision)>,
    /// Where the last start was refused, if it was.
    pub refused_start: Option<TearSite>,
    /// Vertices of the boundary at which a tear may start: scratch of the search.
    pub rim: Vec<u32>,
    /// Whether a tip has advanced by less than it may in this step: the step is then taken up again for this body.
    pub may_advance_further: bool,
}

impl TearDecisions {
    /// Whether the criterion asks for an advance or a start anywhere.
    pub fn ask(&self) -> bool {
        self.start.is_some() || self.tips.iter().flatten().any(|decision| decision.value > 1.0)
    }
}

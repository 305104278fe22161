//! Findings of the tear criterion for the split.

use crate::components::{BlockedNucleation, DecidedBy, LigamentFailure};
use crate::math::Sym2;
use crate::storage::{TipKey, TriangleKey, Triangles, VertexKey, Vertices};
use glam::DVec3;

/// Where a tear starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub enum TearSite {
    /// At the centroid of the triangle in this row.
    Triangle(u32),
    /// At the vertex in this row.
    Vertex(u32),
}

/// Where a start was refused: rows change with every edit, keys do not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub enum RefusedSite {
    /// In this triangle.
    Triangle(TriangleKey),
    /// At this vertex.
    Vertex(VertexKey),
}

impl RefusedSite {
    /// The key of a site in the present tables.
    pub(crate) fn of(site: TearSite, vertices: &Vertices, triangles: &Triangles) -> Option<Self> {
        match site {
            TearSite::Vertex(vertex) => vertices.key(vertex).map(Self::Vertex),
            TearSite::Triangle(triangle) => triangles.key(triangle).map(Self::Triangle),
        }
    }
}

/// The criterion's answer at a tip, a vertex of the boundary or inside a triangle. Directions are unit vectors of the rest shape.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct TearDecision {
    /// The row of the vertex or triangle.
    pub row: u32,
    /// The direction of the largest criterion.
    pub direction: DVec3,
    /// Largest criterion of any admissible direction; the tear advances where it exceeds 1.
    pub value: f64,
    /// The direction of the runner-up, if there is one.
    pub other: Option<DVec3>,
    /// 1 − (best other direction's criterion)/value; infinite without another.
    pub margin: f64,
    /// Whether the margin is under 5 %.
    pub is_ambiguous: bool,
    /// Which criterion this is.
    pub by: DecidedBy,
    /// Energy that an advance in this direction, or the whole opening of a start, releases per area of tear \[N/mm\], where energy counts.
    pub release: Option<f64>,
    /// Mean Biot stress over the averaging disc \[MPa\], in `axes`.
    pub stress: Sym2,
    /// Mean fibre over the disc.
    pub fibre: DVec3,
    /// Axes of the tangent plane.
    pub axes: [DVec3; 2],
    /// Averaging radius over mean edge length; under 3 the mesh is too coarse for R.
    pub edges_per_radius: f64,
}

/// A tip that glides, in the present step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TipGlide {
    /// The tip.
    pub tip: TipKey,
    /// Way in this step \[mm\].
    pub way: f64,
    /// Length of the last move \[mm\] and G/G_c before it, until a solve has followed.
    pub last: Option<(f64, f64)>,
    /// Whether the tip has moved, or was to move, in this step or the last one.
    pub is_running: bool,
    /// G/G_c expected after the moves of the last step.
    pub expected: f64,
    /// Rise of G/G_c above the expected one in this step; the next step is taken to add as much.
    pub load: f64,
}

/// *State.* One decision per tip, in the order of the tips' rows, one for the place where a tear may start, and refusals that are
/// reported already.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct TearDecisions {
    /// Per tip; `None` where no direction is admissible.
    pub tips: Vec<Option<TearDecision>>,
    /// Site that nucleates a tear, with its decision; `None` where no criterion is met.
    pub nucleation: Option<(TearSite, TearDecision)>,
    /// Failure of a ligament, or of tissue beyond its ultimate stretch.
    pub(crate) ligament_failure: Option<Box<LigamentFailure>>,
    /// Length torn or cut \[mm\] when the mesh last refused to part a ligament; none is looked for until it has grown.
    pub ligament_refused_at: f64,
    /// Where the last ligament failure was refused, if it was.
    pub refused_ligament_failure: Option<RefusedSite>,
    /// Length \[mm\] that the nucleation opens at once, on either side of a site inside; zero opens one edge (strength criterion).
    pub nucleation_length: f64,
    /// Strongest site where the strength is reached and the energy does not suffice.
    pub blocked_by_energy: Option<BlockedNucleation>,
    /// Whether the blocked nucleation has been reported; cleared when none is blocked.
    pub is_blocked_reported: bool,
    /// Where the last start was refused, if it was.
    pub refused_nucleation: Option<RefusedSite>,
    /// Vertices of the boundary at which a tear may start: scratch of the search.
    pub rim: Vec<u32>,
    /// Whether the step is redone for this body: its tips may advance further or, in a static solve, tissue has torn.
    pub may_advance_further: bool,
    /// *Derived*: number of corrector solves in the present pass.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub correctors: u32,
    /// *Derived*: criterion of each tip before the last corrector solve.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub before_corrector: Vec<f64>,
    /// *Derived*: tips that glide.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub glides: Vec<TipGlide>,
}

impl TearDecisions {
    /// Forgets the findings before an edit that gives rows to others; refused sites stay known.
    pub fn forget(&mut self) {
        self.tips.clear();
        (self.nucleation, self.nucleation_length, self.blocked_by_energy, self.ligament_failure) =
            (None, 0.0, None, None);
    }

    /// Reserves room for the criterion of `tips` tips before a corrector solve.
    pub(crate) fn make_room(&mut self, tips: usize) {
        self.before_corrector.reserve(tips.saturating_sub(self.before_corrector.len()));
    }

    /// Counts a corrector solve and keeps the present criterion of each tip.
    pub(crate) fn note_corrector(&mut self) {
        self.correctors += 1;
        self.before_corrector.clear();
        self.before_corrector.extend(self.tips.iter().map(|decision| decision.map_or(0.0, |decision| decision.value)));
    }

    /// Whether the criterion asks for an advance or a start anywhere.
    pub fn ask(&self) -> bool {
        self.nucleation.is_some()
            || self.ligament_failure.is_some()
            || self.tips.iter().flatten().any(|decision| decision.value > 1.0)
    }
}

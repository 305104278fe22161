//! Makes the mesh as fine around tear tips as their averaging radius needs, and coarse again behind them.

use crate::components::BodyError;
use crate::components::check::{Check, Host, not_negative, number};
use crate::storage::{EditRecord, Tables, TipKey, VertexKey};
use glam::DVec3;

/// Local refinement around tear tips, in the rest shape. Needs [`Tearing`](crate::components::Tearing). *Parameter.*
///
/// Before every solve, triangles that reach into the disc of R + `margin` around a tip are bisected until they are small enough.
/// So a tip is judged only by the stress of a mesh that is fine around it. The size of a triangle is the edge of the equilateral
/// one with its area; the reports call it edges per radius.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Refinement {
    /// Averaging radius R over the largest size of a triangle around a tip, above 0 and at most 100. From 3 on, the stress at
    /// a tip is that of the tissue; under it that of the mesh.
    pub edges_per_radius: f64,
    /// How far beyond R the mesh is kept fine \[mm\], ≥ 0; R/2 if `None`. It gives the disc a surrounding of its own fineness.
    pub margin: Option<f64>,
    /// Most triangles, as a multiple of those at the start, 1 to 100. Triangles that tears and cuts add are not counted: the body never
    /// has more than this multiple and those added.
    pub budget: f64,
    /// Whether vertices that were added since the start are taken out again where tips have gone.
    pub may_coarsen: bool,
}

impl Default for Refinement {
    fn default() -> Self {
        Self { edges_per_radius: 4.0, margin: None, budget: 1.6, may_coarsen: true }
    }
}

impl Refinement {
    /// Largest size of a triangle around a tip \[mm\], for the averaging radius \[mm\].
    pub fn edge(&self, radius: f64) -> f64 {
        radius / self.edges_per_radius
    }

    /// How far from a tip the mesh is fine \[mm\], for the averaging radius \[mm\].
    pub fn reach(&self, radius: f64) -> f64 {
        radius + self.margin.unwrap_or(0.5 * radius)
    }

    /// Most triangles that refinement may add to `start_count`.
    pub fn most_added(&self, start_count: usize) -> i64 {
        ((self.budget - 1.0) * start_count as f64) as i64
    }
}

/// Record of the refinement done, and of the part that coarsening may take back. *State.*
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Refined {
    /// Triangles at the start.
    pub start_count: usize,
    /// Triangles that refinement has added, less those that coarsening has removed.
    pub added: i64,
    /// Edges split.
    pub split_count: u32,
    /// Vertices removed.
    pub removed_count: u32,
    /// How often the budget has ended a refinement.
    pub budget_hit_count: u32,
    /// Sum of the changes of elastic energy \[mJ\] by coarsening at unchanged positions. Splits change none.
    pub energy_change: f64,
    /// Vertices added since the start, by refinement and by tears: those that may be removed.
    pub made: Vec<VertexKey>,
    /// Tips and where they were in the rest shape when the mesh was last refined around them.
    pub tips: Vec<(TipKey, DVec3)>,
    /// Whether tips have gone on since the mesh was last coarsened.
    pub is_behind: bool,
    /// Whether the budget of the last step has left halvings to the next one.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub is_put_off: bool,
    /// Triangles that are too large: number of the refinement's pass over the tips, distance from the tip, row.
    pub queue: Vec<(f64, u32)>,
}

impl Refined {
    /// Remembers the vertices that an edit has added; the tables are those after it.
    pub fn follow(&mut self, record: &EditRecord, tables: Tables<'_>) {
        self.made.extend(record.created().filter_map(|(row, _)| tables.vertices.key(row)));
    }
}

impl Check for Refinement {
    fn check(&self, _: &Host<'_>) -> Result<(), BodyError> {
        let (edges, budget) = (self.edges_per_radius, self.budget);
        let is_right = edges > 0.0 && edges <= 100.0;
        number("Refinement", "edges_per_radius", edges, (is_right, "it must be above 0 and at most 100"))?;
        let is_right = (1.0..=100.0).contains(&budget);
        number("Refinement", "budget", budget, (is_right, "it must be from 1 to 100"))?;
        self.margin.map_or(Ok(()), |margin| not_negative("Refinement", "margin", margin))
    }
}

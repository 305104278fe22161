//! Makes the mesh as fine around tear tips as their averaging radius needs, and coarse again behind them.

use crate::components::BodyError;
use crate::components::check::{Check, Host, not_negative, number};

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

//! Contact of a body with itself.

use super::obstacle::Contact;
use crate::components::BodyError;
use crate::components::check::{Host, not_negative, number, positive};
use crate::storage::Triangles;

/// Contact of a body with itself: its layers keep a distance, and none passes through another. *Parameter* of [`Contact`]. A planar body has none.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct SelfContact {
    /// Distance \[mm\] below which two layers repel each other, above 0 and at most half a mean edge of the mesh that takes it, or a band that is given: the thickness of the
    /// tissue or more.
    pub radius: f64,
    /// Rest distance \[mm\] within which vertices, and parts with them, do not touch, ≥ 0: those of small triangles, and the lips of a tear. Without it
    /// the body takes one radius.
    pub band: Option<f64>,
}

impl SelfContact {
    /// Contact at a distance \[mm\], with the default band.
    pub fn new(radius: f64) -> Self {
        Self { radius, band: None }
    }

    pub(super) fn check(&self, host: &Host<'_>) -> Result<(), BodyError> {
        positive("Contact", "radius of self_contact", self.radius)?;
        self.band.map_or(Ok(()), |band| not_negative("Contact", "band of self_contact", band))?;
        // A body that has taken a band may have been refined since.
        let most = host.surface.map_or(f64::INFINITY, |(triangles, _)| 0.5 * mean_edge(triangles));
        let is_right = self.radius <= most.max(self.band.unwrap_or(0.0));
        number(
            "Contact",
            "radius of self_contact",
            self.radius,
            (is_right, "it must be at most half a mean edge, or the band"),
        )
    }
}

impl Contact {
    /// Contact with the band that it takes; `None` where it has one, or needs none.
    pub(crate) fn with_band(&self) -> Option<Self> {
        let SelfContact { radius, band: None } = self.self_contact? else { return None };
        Some(Self { self_contact: Some(SelfContact { radius, band: Some(radius) }), ..*self })
    }
}

/// Edge \[mm\] of the equilateral triangle with the mean rest area.
fn mean_edge(triangles: &Triangles) -> f64 {
    let area: f64 = triangles.rest.iter().map(|rest| rest.area).sum();
    (4.0 / 3.0_f64.sqrt() * area / triangles.len().max(1) as f64).sqrt()
}

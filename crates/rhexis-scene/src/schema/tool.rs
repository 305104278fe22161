//! What cuts a body: cuts, needles and blades.

use super::{Point, TimePath};
use serde::Deserialize;

/// One of `[[bodies.cuts]]`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CutSpec {
    /// Points in the rest shape \[mm\]: a notch if it begins at the boundary, else a slit.
    pub polyline: Vec<Point>,
    /// Time \[ms\], ≥ 0; made before the first step that begins then or later. Default before the first step.
    pub at: Option<f64>,
}

/// One of `[[bodies.punctures]]`: a slit where the surface, as it lies then, is nearest to a point.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PunctureSpec {
    /// Time \[ms\], ≥ 0.
    pub at: f64,
    /// Where the needle is \[mm\]; the surface must be nearer than `length`.
    pub point: Point,
    /// Direction of the slit, of any length, laid into the surface.
    pub direction: Point,
    /// Length of the slit \[mm, rest shape\], > 0.
    pub length: f64,
}

/// One of `[[bodies.blades]]`: an edge that moves through space and cuts the body where it touches the surface.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BladeSpec {
    /// `[[time, [x, y, z]], …]` \[ms, mm\]: the edge is in space from the first time to the last.
    pub path: TimePath,
    /// Farthest from the surface at which it cuts \[mm\], > 0. Default 0.5.
    #[serde(default = "blade_reach")]
    pub reach: f64,
    /// Shortest cut \[mm\], > 0; shorter strokes are saved up. Default 0.5.
    #[serde(default = "blade_reach")]
    pub least: f64,
}

fn blade_reach() -> f64 {
    0.5
}

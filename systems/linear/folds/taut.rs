//! Which triangles bend in the tangent of a dynamic step: all but those that are taut.
//!
//! A taut sheet is held level by its tension. With the slope p of a triangle an edge is tilted by no more than |p| from either side,
//! and Σ ¼·θ·Q·θ over triangles is at most Σ |p|²·½·(3·tr Q + Σ tr Q') with the laws Q' of the triangles across, while tension has
//! Σ V·p·S⁺·p. Where the first is at most half of the second, around a triangle and its neighbours, the moments of the triangle are
//! left out of the tangent: what is left is two thirds of the whole and more, and backward Euler is stable from a half on.
//! Forces know no such difference, so that a sheet comes to rest in the same shape; and in most of a taut sheet a product
//! has nothing to bend.

use super::Folds;
use crate::components::Frames;
use crate::storage::{NONE, Triangles};
use crate::systems::parallel;

/// The part of the stiffness by tension that may be left out.
const LEAST: f64 = 0.5;

/// What of a triangle is in the majorant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Part {
    /// Nothing.
    None,
    /// Its tilts only, for a neighbour's moments.
    Tilts,
    /// Its tilts and moments.
    #[default]
    Whole,
}

impl Folds {
    /// The bound of the stiffness along normals per squared slope of a triangle.
    pub(super) fn stiffest(&self, t: usize, neighbours: [u32; 3]) -> f64 {
        let trace = |t: usize| self.rest[t].law[..3].iter().sum::<f64>();
        let others = neighbours.iter().filter(|n| **n != NONE).map(|&n| trace(n as usize));
        0.5 * (3.0 * trace(t) + others.sum::<f64>())
    }

    /// Leaves the moments of taut triangles out of the majorant, for the frames of the same state.
    pub fn leave_out_taut(&mut self, triangles: &Triangles, frames: &Frames) {
        let Self { rest, is_taut, part, factor, .. } = self;
        is_taut.resize(rest.len(), false);
        parallel::for_rows(is_taut, |t, is_taut| {
            let volume = triangles.rest[t].area * triangles.thickness[t];
            let least = rest[t].stiffest * *factor / (LEAST * volume);
            let tension = frames.geometric[t].normal;
            let (x, y) = (tension.xx - least, tension.yy - least);
            // Both principal values are above; not so where one is no number.
            *is_taut = x > 0.0 && y > 0.0 && x * y > tension.xy * tension.xy;
        });
        let any =
            |t: usize, is: &dyn Fn(usize) -> bool| rest[t].across.iter().any(|&n| n != NONE && is(n as usize / 3));
        parallel::for_rows(part, |t, part| {
            let is_slack = |t: usize| !is_taut[t];
            let bends = |t: usize| is_slack(t) || any(t, &is_slack);
            *part = if bends(t) {
                Part::Whole
            } else if any(t, &bends) {
                Part::Tilts
            } else {
                Part::None
            };
        });
    }

    /// Whether the majorant knows anything of a triangle.
    #[inline(always)]
    pub fn has_part(&self, t: usize) -> bool {
        self.part[t] != Part::None
    }
}

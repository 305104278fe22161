//! Which triangles bend in the tangent of a dynamic step: all but those that are taut.
//!
//! A taut sheet is held level by its tension. With the slope p of a triangle its edges with normals m are tilted by p·m from its
//! side. Then Σ ¼·θ·Q·θ over triangles is at most Σ p·C·p, while tension has Σ V·p·S⁺·p. Here C = Σ ½·(λ + λ')·m⊗m over the edges,
//! with the largest stiffnesses λ, λ' of the laws on both sides. Where the first sum is at most half of the second, in a triangle
//! and its neighbours, the moments of the triangle are left out of the tangent. The remaining tangent is two thirds of the whole
//! and more, and backward Euler is stable from a half on. Forces leave nothing out, so that a sheet comes to rest in the same
//! shape; and in most of a taut sheet a product has nothing to bend.

use super::DihedralAngles;
use crate::components::Frames;
use crate::math::Sym2;
use crate::storage::{NONE, Triangles};
use crate::systems::kernels::bending::EdgeMatrix;
use crate::systems::parallel;

/// The part of the stiffness by tension that may be left out.
const LEAST_TENSION: f64 = 0.5;

/// Part of a triangle that the majorant includes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Part {
    /// Nothing.
    None,
    /// The tilts of the triangle only, for a neighbour's moments.
    Tilts,
    /// The tilts and moments of the triangle.
    #[default]
    Whole,
}

/// No principal value of a law is larger (Gershgorin).
fn largest(q: &EdgeMatrix) -> f64 {
    let (a, b, c) = (q[3].abs(), q[4].abs(), q[5].abs());
    (q[0] + a + c).max(q[1] + a + b).max(q[2] + b + c)
}

impl DihedralAngles {
    /// C of a triangle, of the rest shape.
    pub(super) fn stiffest(&self, t: usize, neighbours: [u32; 3]) -> Sym2 {
        let gradients = self.made_of[t].0.all_gradients();
        let own = largest(&self.rest[t].law);
        (0..3).fold(Sym2::ZERO, |sum, e| match neighbours[e] {
            NONE => sum,
            n => {
                let normal = gradients[(e + 2) % 3].normalize_or_zero();
                sum + Sym2::outer(normal) * (0.5 * (own + largest(&self.rest[n as usize].law)))
            }
        })
    }

    /// Leaves the moments of taut triangles out of the majorant, for the frames of the same state.
    pub fn leave_out_taut(&mut self, triangles: &Triangles, frames: &Frames) {
        let Self { rest, is_slack, bends, part, factor, .. } = self;
        is_slack.resize(rest.len(), false);
        bends.resize(rest.len(), false);
        parallel::for_rows(is_slack, |t, is_slack| {
            let volume = triangles.rest[t].area * triangles.thickness[t];
            let left = frames.geometric_stiffness(t).normal * (LEAST_TENSION * volume) - rest[t].stiffest * *factor;
            // Taut where that is positive definite; not so where one is no number.
            *is_slack = !(left.xx > 0.0 && left.yy > 0.0 && left.determinant() > 0.0);
        });
        let is_near = |t: usize, of: &[bool]| rest[t].across.iter().any(|&n| n != NONE && of[n as usize / 3]);
        parallel::for_rows(bends, |t, bends| *bends = is_slack[t] || is_near(t, is_slack));
        parallel::for_rows(&mut part[..rest.len()], |t, part| {
            *part = if bends[t] {
                Part::Whole
            } else if is_near(t, bends) {
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

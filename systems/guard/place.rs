//! Place and cause of spurious energy, found for every solve above the limit but later Newton corrections.

use super::solved::{Solved, Sums};
use crate::components::{CompartmentState, ExternalStiffness, Grips};
use crate::event::{GuardCause, GuardPlace};
use crate::storage::{Triangles, Vertices};

/// Query of the components that may hold vertices of a body.
pub(super) type Holders<'a> = (Option<&'a Grips>, Option<&'a ExternalStiffness>, Option<&'a CompartmentState>);

/// A triangle's place in the rest shape.
pub(crate) fn of_triangle(
    cause: GuardCause,
    (vertices, triangles): (&Vertices, &Triangles),
    t: usize,
    energy: f64,
) -> GuardPlace {
    let corners = triangles.corners[t];
    let at = corners.iter().map(|&v| vertices.rest_position[v as usize]).sum::<glam::DVec3>() / 3.0;
    let energy = if energy.is_finite() { energy } else { 0.0 };
    GuardPlace { cause, triangle: u32::try_from(t).ok(), vertex: Some(corners[0]), at, energy }
}

impl Solved<'_> {
    /// The largest of the terms that create energy, at the triangle that creates most; `residual` is the work of the solve's residual,
    /// `sum` all that is created \[mJ\]. Triangles are compared in their order, so that the answer is the same for any thread count.
    pub(super) fn place(&self, residual: f64, sum: f64, holders: Holders<'_>, sums: &mut Sums<'_>) -> GuardPlace {
        let whole = 1.0;
        let (vertices, triangles) = (self.operator.vertices, self.operator.triangles);
        let (mut membrane, mut damping, mut most, mut worst) = (0.0, 0.0, f64::NEG_INFINITY, None);
        for t in 0..triangles.len() {
            let of_triangle = self.of_triangle(t, whole);
            let damped = self.damped_along(t, whole);
            damping -= damped;
            membrane += of_triangle + damped;
            // A value that is not a number is the worst.
            if !(of_triangle <= most) {
                (most, worst) = (of_triangle, Some(t));
                if of_triangle.is_nan() {
                    break;
                }
            }
        }
        let bending = self.bent(whole, sums);
        let masses = sum - membrane - damping - bending - residual;
        let terms = [
            (GuardCause::Membrane, membrane),
            (GuardCause::Bending, bending),
            (GuardCause::Damping, damping),
            (GuardCause::Residual, residual),
            (GuardCause::Drag, masses),
        ];
        let largest =
            |largest: (GuardCause, f64), term: (GuardCause, f64)| if term.1 > largest.1 { term } else { largest };
        let (cause, _) = terms.into_iter().fold((GuardCause::Membrane, f64::NEG_INFINITY), largest);
        let Some(t) = worst else { return GuardPlace::nowhere(cause) };
        let cause = if cause == GuardCause::Membrane { self.holder(t, holders) } else { cause };
        of_triangle(cause, (vertices, triangles), t, sum)
    }

    /// Cause of a triangle's membrane energy: grips or contact at a corner, or else the membrane.
    fn holder(&self, t: usize, (grips, external, _): Holders<'_>) -> GuardCause {
        let (triangles, topology) = (self.operator.triangles, self.operator.topology);
        let corners = triangles.corners[t];
        let is_gripped =
            |v: &u32| grips.is_some_and(|grips| grips.pinches.iter().any(|pinch| pinch.held.rows().contains(v)));
        if corners.iter().any(is_gripped) {
            return GuardCause::Grips;
        }
        let is_held = |v: &u32| {
            let dragged = self.drag * topology.vertex_area(triangles, *v);
            let block = external.and_then(|external| external.block.get(*v as usize));
            // Beyond rounding of the drag terms there.
            block.is_some_and(|block| block.diagonal.element_sum() > 3.0 * dragged * (1.0 + 1e-9))
        };
        if corners.iter().any(is_held) { GuardCause::Contact } else { GuardCause::Membrane }
    }
}

//! Rotation warp: a factor rotated with the tissue.
//!
//! The stiffness of a body that has turned since it was factored is about that of before, turned. With the rotation R of every
//! vertex since then, R·M⁻¹·Rᵀ preconditions as M⁻¹ did (stiffness warping, Müller et al. 2002). It stays symmetric and positive.

use crate::components::FreeAxes;
use crate::math::Polar;
use crate::systems::parallel;
use crate::systems::solver::Operator;
use glam::{DMat3, DVec3};

/// Turns that all are smaller than this change no iteration: how far the ends of axes have moved.
const SMALL_TURN: f64 = 0.1;

/// One in so many vertices tells whether any has turned: the time of a look at all of them is a tenth of a step's. A turn that
/// fewer have made costs an iteration.
const SAMPLE: usize = 8;

/// The rotation of the vertices of one mesh since a state of it.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct RotationWarp {
    /// The axes at that state of the triangle that a vertex turns with, its first.
    then: Vec<[DVec3; 2]>,
    /// The turns since; empty where they all are small.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    turns: Vec<DMat3>,
}

/// Axes of the first triangle of a vertex; `None` at a vertex without any.
fn axes(operator: &Operator, v: usize) -> Option<[DVec3; 2]> {
    let entry = *operator.topology.incident[v].first()?;
    let Polar { fibre_axis, transverse_axis, .. } = operator.frames.state(entry as usize / 3).polar;
    Some([fibre_axis, transverse_axis])
}

impl RotationWarp {
    /// No turns yet, at the operator's state.
    pub(super) fn new(operator: &Operator) -> Self {
        let vertices = 0..operator.topology.incident.len();
        Self { then: vertices.map(|v| axes(operator, v).unwrap_or([DVec3::X, DVec3::Y])).collect(), turns: Vec::new() }
    }

    /// Finds the turns up to the operator's state, on the mesh that it began with. Prescribed axes do not turn.
    pub(super) fn update(&mut self, operator: &Operator, free: &FreeAxes) {
        let Self { then, turns } = self;
        let is_turned = |v: usize| axes(operator, v).is_some_and(|now| !is_near(then[v], now));
        if !(0..then.len()).step_by(SAMPLE).any(is_turned) {
            return turns.clear();
        }
        turns.resize(then.len(), DMat3::IDENTITY);
        parallel::for_rows(turns, |v, turn| {
            *turn = axes(operator, v).map_or(DMat3::IDENTITY, |now| between(then[v], now));
            // In a plane the normal is one but for rounding.
            let keeps = |axis: usize| free[v][axis] != 0.0 || (turn.col(axis)[axis] - 1.0).abs() < 1e-9;
            if !(keeps(0) && keeps(1) && keeps(2)) {
                *turn = DMat3::IDENTITY;
            }
        });
    }

    /// The part kept by a snapshot: the rotations are recomputed.
    pub(super) fn state(&self) -> Self {
        Self { then: self.then.clone(), turns: Vec::new() }
    }

    /// Number of vertices.
    #[cfg(feature = "snapshot")]
    pub(super) fn vertex_count(&self) -> usize {
        self.then.len()
    }

    /// The turn R of every vertex; none where all are small.
    pub(super) fn turns(&self) -> &[DMat3] {
        &self.turns
    }
}

fn is_near([a, b]: [DVec3; 2], [p, q]: [DVec3; 2]) -> bool {
    p.distance_squared(a) <= SMALL_TURN * SMALL_TURN && q.distance_squared(b) <= SMALL_TURN * SMALL_TURN
}

/// The rotation that takes one pair of axes to another.
#[inline(always)]
fn between([a, b]: [DVec3; 2], [p, q]: [DVec3; 2]) -> DMat3 {
    // In a plane the rest is products with zero.
    if a.z == 0.0 && b.z == 0.0 && p.z == 0.0 && q.z == 0.0 {
        let column = |i: usize| DVec3::new(p.x * a[i] + q.x * b[i], p.y * a[i] + q.y * b[i], 0.0);
        let normal = (p.x * q.y - q.x * p.y) * (a.x * b.y - b.x * a.y);
        return DMat3::from_cols(column(0), column(1), DVec3::new(0.0, 0.0, normal));
    }
    let then = DMat3::from_cols(a, b, a.cross(b));
    DMat3::from_cols(p, q, p.cross(q)) * then.transpose()
}

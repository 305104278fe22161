//! Motions of the vertices in touch along with a rigid obstacle, as a coarse space of preconditioners.
//!
//! Springs to a light obstacle are stiff one by one and soft in common: preconditioners see the first alone, and conjugate gradients
//! would stop before they see the second. So z has W·(Wᵀ·A·W)⁻¹·Wᵀ·r beside the preconditioner's answer (additive two-level method,
//! Nicolaides 1987), with the six motions of the patch in touch in the columns of W.

use super::Operator;
use crate::components::{FreeAxes, RigidCoupling, Six, cholesky, solve_lower, solve_upper};
use crate::systems::bending::BendingPasses;
use glam::DVec3;

/// Part by which the diagonal of Wᵀ·A·W is raised: of one or two vertices not all six motions are different.
const SHIFT: f64 = 1e-9;

/// Vertices in touch with a rigid obstacle, and how they answer its six motions.
#[derive(Debug)]
pub(super) struct Patch {
    /// Rows of W along free axes.
    rows: Vec<(u32, [DVec3; 6])>,
    lower: [Six; 6],
}

impl Patch {
    /// Patches of the rigid obstacles that an operator has.
    pub(super) fn all(operator: &Operator, free: &FreeAxes) -> Vec<Self> {
        let couplings = operator.external.map_or(&[][..], |external| &external.coupled.rigid);
        couplings.iter().filter_map(|coupling| Self::of(coupling, operator, free)).collect()
    }

    /// The patch of one coupling; `None` where it has no answer.
    pub(super) fn of(coupling: &RigidCoupling, operator: &Operator, free: &FreeAxes) -> Option<Self> {
        let mut rows: Vec<u32> = coupling.rows.iter().map(|(row, _)| *row).collect();
        rows.sort_unstable();
        rows.dedup();
        let motions = |row: u32| {
            let arm = operator.vertices.position[row as usize] - coupling.centre;
            let axes = [DVec3::X, DVec3::Y, DVec3::Z];
            let turning = axes.map(|axis| axis.cross(arm));
            let own = [axes[0], axes[1], axes[2], turning[0], turning[1], turning[2]];
            (row, own.map(|motion| motion * free[row as usize]))
        };
        let rows: Vec<(u32, [DVec3; 6])> = rows.into_iter().map(motions).collect();
        let count = operator.vertices.len();
        let (mut moved, mut forces, mut passes) =
            (vec![DVec3::ZERO; count], vec![DVec3::ZERO; count], BendingPasses::default());
        let mut matrix = [[0.0; 6]; 6];
        for j in 0..6 {
            rows.iter().for_each(|(row, motions)| moved[*row as usize] = motions[j]);
            operator.apply_sparse(&moved, &mut forces, &mut passes);
            for (i, row) in matrix.iter_mut().enumerate() {
                row[j] = rows.iter().map(|(v, motions)| motions[i].dot(forces[*v as usize])).sum();
            }
        }
        for (i, row) in matrix.iter_mut().enumerate() {
            row[i] = if row[i] > 0.0 { row[i] * (1.0 + SHIFT) } else { 1.0 };
        }
        Some(Self { rows, lower: cholesky(&matrix)? })
    }

    /// The patch with rows in another order.
    pub(super) fn renumbered(mut self, row: &[u32]) -> Self {
        self.rows.iter_mut().for_each(|(v, _)| *v = row[*v as usize]);
        self
    }

    /// Answer (Wᵀ·A·W)⁻¹·Wᵀ·r to a residual, and its part of r·z.
    pub(super) fn answer(&self, residual: impl Fn(usize) -> DVec3) -> (Six, f64) {
        let mut force = [0.0; 6];
        for (row, motions) in &self.rows {
            let r = residual(*row as usize);
            force.iter_mut().zip(motions).for_each(|(sum, motion)| *sum += motion.dot(r));
        }
        let answer = solve_upper(&self.lower, solve_lower(&self.lower, force));
        (answer, force.iter().zip(answer).map(|(force, answer)| force * answer).sum())
    }

    /// Calls `add(row, W·answer)` for every vertex.
    pub(super) fn spread(&self, answer: &Six, mut add: impl FnMut(usize, DVec3)) {
        for (row, motions) in &self.rows {
            add(*row as usize, RigidCoupling::back(motions, answer));
        }
    }
}

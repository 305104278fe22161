//! The operator as the blocks of its matrix, of which a factor is made.

use crate::components::FreeAxes;
use crate::systems::bending::Dihedral;
use crate::systems::parallel;
use crate::systems::solver::{Operator, load_block};
use glam::{DMat3, DVec3};

/// The operator at one state.
#[derive(Debug, Default)]
pub(super) struct OperatorCopy {
    /// Corners of the triangles.
    pub corners: Vec<[u32; 3]>,
    /// Per triangle the blocks K₁₁, K₁₂, K₂₂ \[N/mm\]; those of corner 0 follow, as a translation exerts no force.
    pub blocks: Vec<[DMat3; 3]>,
    /// Mass and external stiffness of every vertex \[N/mm\].
    pub own: Vec<DMat3>,
    /// Edges of every triangle as its load stiffness has them \[N/mm\]; empty without one.
    pub loads: Vec<[DVec3; 3]>,
    /// Dihedrals of bending.
    pub hinges: Vec<Dihedral>,
    /// 1 along free axes, 0 along prescribed ones.
    pub free: FreeAxes,
}

impl OperatorCopy {
    /// The operator as it is, over these free axes.
    pub(super) fn new(operator: &Operator, free: &FreeAxes) -> Self {
        let corners = operator.triangles.corners.clone();
        let (mut blocks, mut own) = (vec![[DMat3::ZERO; 3]; corners.len()], vec![DMat3::ZERO; free.len()]);
        parallel::for_rows(&mut blocks, |t, blocks| *blocks = operator.element(t).blocks());
        let loads = if operator.pressure == 0.0 { 0 } else { corners.len() };
        let loads = (0..loads).map(|t| operator.edge_loads(t)).collect();
        parallel::for_rows(&mut own, |v, own| *own = operator.own_block(v));
        let hinges = operator.folds.map_or_else(Vec::new, |folds| folds.hinges(&corners).collect());
        Self { corners, blocks, loads, own, hinges, free: free.clone() }
    }

    /// The vertices of the dihedrals.
    pub(super) fn folded(&self) -> Vec<[u32; 4]> {
        self.hinges.iter().map(|hinge| hinge.vertices).collect()
    }

    /// The block of corners `i` and `j` of a triangle.
    pub(super) fn block(&self, t: usize, i: usize, j: usize) -> DMat3 {
        match self.loads.get(t) {
            Some(edges) => self.membrane_block(t, i, j) + load_block(edges, i, j),
            None => self.membrane_block(t, i, j),
        }
    }

    fn membrane_block(&self, t: usize, i: usize, j: usize) -> DMat3 {
        let [k11, k12, k22] = &self.blocks[t];
        match (i, j) {
            (1, 1) => *k11,
            (1, 2) => *k12,
            (2, 1) => k12.transpose(),
            (2, 2) => *k22,
            (0, 0) => *k11 + *k12 + k12.transpose() + *k22,
            (0, 1) => -(*k11 + k12.transpose()),
            (1, 0) => -(*k11 + *k12),
            (0, _) => -(*k12 + *k22),
            _ => -(k12.transpose() + *k22),
        }
    }
}

//! Terms of the operator in single precision between vertices that no triangle joins: layers that touch, and rigid obstacles.

use super::order::Order;
use super::vertex_blocks::VertexBlocks;
use crate::components::FreeAxes;
use crate::systems::kernels::block::Block;
use crate::systems::solver::{Operator, patch::Patch};
use glam::{DVec3, Vec4};

/// A row in touch with a rigid obstacle, and its columns.
type CoupledRow = (u32, [Vec4; 6]);

/// The terms, with rows numbered as in the [`Partition`](super::partition::Partition).
#[derive(Debug, Default)]
pub(super) struct Between {
    /// Springs between layers that touch.
    pairs: Vec<RowPair>,
    /// Blocks of these springs on the diagonal, for preconditioners; empty without any.
    pub pair_blocks: Vec<Block>,
    /// Rigid obstacles: rows in touch with each and their columns, and the patch in touch, for preconditioners.
    rigid: Vec<(Vec<CoupledRow>, Option<Patch>)>,
}

/// A spring between layers.
#[derive(Clone, Copy, Debug)]
struct RowPair {
    rows: [u32; 4],
    weights: Vec4,
    normal: Vec4,
    stiffness: f32,
}

impl Between {
    /// Assembles the terms of the double-precision operator, in the memory of earlier ones; `None` where it has none.
    pub(super) fn assemble(this: &mut Option<Box<Self>>, operator: &Operator, order: &Order, free: &FreeAxes) {
        let coupled = operator.external.map(|external| &*external.coupled);
        let Some(coupled) = coupled.filter(|coupled| !coupled.is_empty()) else {
            *this = None;
            return;
        };
        let Self { pairs, pair_blocks, rigid } = &mut **this.get_or_insert_default();
        pairs.clear();
        pair_blocks.clear();
        rigid.clear();
        pairs.extend(coupled.pairs.iter().map(|spring| RowPair {
            rows: spring.rows.map(|v| order.row[v as usize]),
            weights: Vec4::from_array(spring.weights.map(|weight| weight as f32)),
            normal: spring.normal.as_vec3().extend(0.0),
            stiffness: spring.stiffness as f32,
        }));
        if !pairs.is_empty() {
            pair_blocks.extend(order.vertex.iter().map(|&v| {
                let block = coupled.pair_block[v as usize].to_mat();
                [block.x_axis, block.y_axis, block.z_axis].map(|column| column.as_vec3().extend(0.0))
            }));
        }
        rigid.extend(coupled.rigid.iter().map(|coupling| {
            let single = |column: DVec3| column.as_vec3().extend(0.0);
            let rows = coupling.rows.iter().map(|(v, columns)| (order.row[*v as usize], columns.map(single))).collect();
            let patch = Patch::of(coupling, operator, free);
            (rows, patch.map(|patch| patch.renumbered(&order.row)))
        }));
    }

    /// Patches of the rigid obstacles.
    pub(super) fn patches(&self) -> impl Iterator<Item = &Patch> {
        self.rigid.iter().filter_map(|(_, patch)| patch.as_ref())
    }

    /// Adds the products along free axes; returns their part of u·(A·u).
    pub(super) fn add(&self, u: &[Vec4], out: &mut [Vec4], blocks: &VertexBlocks) -> f64 {
        let mut product = 0.0;
        for pair in &self.pairs {
            let way: f32 = (0..4).map(|i| pair.normal.dot(u[pair.rows[i] as usize]) * pair.weights[i]).sum();
            let force = pair.stiffness * way;
            product += f64::from(force) * f64::from(way);
            for (i, &row) in pair.rows.iter().enumerate() {
                out[row as usize] += pair.normal * (force * pair.weights[i]) * blocks.free(row as usize);
            }
        }
        for (rows, _) in &self.rigid {
            let mut seen = [0.0_f32; 6];
            for (row, columns) in rows {
                seen.iter_mut().zip(columns).for_each(|(seen, column)| *seen += column.dot(u[*row as usize]));
            }
            product -= seen.iter().map(|seen| f64::from(*seen) * f64::from(*seen)).sum::<f64>();
            for (row, columns) in rows {
                let force: Vec4 = columns.iter().zip(seen).map(|(column, seen)| *column * seen).sum();
                out[*row as usize] -= force * blocks.free(*row as usize);
            }
        }
        product
    }
}

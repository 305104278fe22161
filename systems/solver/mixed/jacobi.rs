//! Block Jacobi: the inverse of each vertex' 3×3 diagonal block.

use super::cg::{Precondition, Vectors};
use super::empty;
use super::matrix::{Matrix, OfPacks, dot};
use super::partition::Partition;
use crate::systems::kernels::block::{self, Block};
use crate::systems::kernels::simd::wide;
use crate::systems::parallel;
use glam::DVec2;

/// The inverse blocks.
#[derive(Debug, Default)]
pub(super) struct Jacobi {
    inverse: Vec<Block>,
}

impl Jacobi {
    /// Inverts the diagonal blocks of the operator.
    pub(super) fn factor(&mut self, partition: &Partition, matrix: &Matrix) {
        let rows = matrix.vertex_blocks.row_count();
        empty(&mut self.inverse, rows);
        self.inverse.extend((0..rows).map(|row| Block::own(matrix, row)));
        wide(|| {
            let add = |row: usize, block: &Block| block::add(&mut self.inverse[row], block);
            matrix.add_blocks(partition, partition.all_blocks(), add, |_, _, _| ())
        });
        parallel::for_rows(&mut self.inverse, |v, inverse| {
            let free = matrix.vertex_blocks.free(v);
            let own = block::mask(inverse, free, free);
            *inverse = block::invert(&own, free).unwrap_or_else(|| block::invert_alone(&own, free));
        });
    }
}

impl Precondition for Jacobi {
    fn forward_sweep(&mut self, alpha: f32, vectors: &mut Vectors) -> DVec2 {
        let Vectors { xr, p, q, pairs, .. } = vectors;
        parallel::sum_rows(xr, pairs, |v, [x, r]| {
            *x += p[v] * alpha;
            *r -= q[v] * alpha;
            DVec2::new(dot(*r, *r), dot(*r, block::apply(&self.inverse[v], *r)))
        })
    }

    fn backward_sweep(&mut self, beta: f32, vectors: &mut Vectors) {
        let Vectors { xr, p, .. } = vectors;
        // Once more M⁻¹·r: as fast as to write and read it.
        parallel::for_rows(p, |v, p| *p = block::apply(&self.inverse[v], xr[v][1]) + *p * beta);
    }
}

//! Vertex blocks: masses and external stiffness of the vertices, and their free axes.

use super::size;
use crate::systems::kernels::block::{self, Block};
use crate::systems::kernels::factor_block::FactorBlock;
use crate::systems::kernels::flat_block::FlatBlock;
use crate::systems::parallel;
use glam::{DMat3, DVec3, Vec4};

/// The blocks of all rows \[N/mm\].
#[derive(Debug, Default)]
pub(super) struct VertexBlocks {
    /// Blocks of a body in space, or of a planar one.
    pub solid: Vec<Block>,
    pub flat: Vec<FlatBlock>,
    /// Free axes: x counts 1, y 2, z 4.
    free: Vec<u8>,
}

/// Free axes (1) by their bit mask.
const FREE_BY_MASK: [Vec4; 8] = {
    let mut free = [Vec4::ZERO; 8];
    let mut axes = 0;
    while axes < 8 {
        free[axes] = Vec4::new((axes & 1) as f32, (axes >> 1 & 1) as f32, (axes >> 2) as f32, 0.0);
        axes += 1;
    }
    free
};

impl VertexBlocks {
    /// Takes the blocks and free axes of so many rows.
    pub(super) fn assemble(&mut self, is_flat: bool, rows: usize, of_row: impl Fn(usize) -> (DMat3, DVec3) + Sync) {
        size(&mut self.free, rows, 0);
        let Self { solid, flat, free } = self;
        if is_flat {
            size(flat, rows, FlatBlock::default());
            fill(flat, free, &of_row);
        } else {
            size(solid, rows, block::ZERO);
            fill(solid, free, &of_row);
        }
    }

    /// Number of rows.
    pub(super) fn row_count(&self) -> usize {
        self.free.len()
    }

    /// Free axes (1) of a row.
    #[inline(always)]
    pub(super) fn free(&self, row: usize) -> Vec4 {
        FREE_BY_MASK[self.free[row] as usize % FREE_BY_MASK.len()]
    }
}

fn fill<B: FactorBlock>(blocks: &mut [B], free: &mut [u8], of_row: &(impl Fn(usize) -> (DMat3, DVec3) + Sync)) {
    parallel::for_pairs(blocks, free, |first, blocks, free| {
        for (i, (block, free)) in blocks.iter_mut().zip(free).enumerate() {
            let (own, axes) = of_row(first + i);
            *block = B::of(&[own.x_axis, own.y_axis, own.z_axis].map(|column| column.as_vec3().extend(0.0)));
            *free = axes.cmpne(DVec3::ZERO).bitmask() as u8;
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_axes_may_be_free() {
        let free = |row: usize| DVec3::from_array([0, 1, 2].map(|axis| (row >> axis & 1) as f64));
        for is_flat in [false, true] {
            let mut own = VertexBlocks::default();
            own.assemble(is_flat, 8, |row| (DMat3::IDENTITY, free(row)));
            assert!((0..8).all(|row| own.free(row) == free(row).as_vec3().extend(0.0)));
        }
    }
}

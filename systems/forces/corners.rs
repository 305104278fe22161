//! Sums at the vertices over the corner values of triangles.

use crate::storage::Topology;
use crate::systems::kernels::simd::{Kernel, run};
use crate::systems::parallel;
use glam::DVec3;

/// Triangles whose corners are written down at a time where one thread adds up: 18 kB, which stay in the first cache.
const CORNER_BLOCK: usize = 256;

/// Sets `out` to the sums per vertex of the kernel's corner values of the triangles, in the order of their rows; `seen` is
/// shown all corners on the way. `corner` is scratch.
///
/// One thread adds up block by block. Several write down all corners, then every vertex gathers its own: 72 bytes per triangle, and
/// the same bits.
pub fn add_up(
    (corners, topology): (&[[u32; 3]], &Topology),
    corner: &mut Vec<[DVec3; 3]>,
    out: &mut [DVec3],
    kernel: &impl Kernel<[DVec3; 3]>,
    mut seen: impl FnMut(&[[DVec3; 3]]),
) {
    if parallel::is_worth_sharing(corners.len()) {
        corner.resize(corners.len(), [DVec3::ZERO; 3]);
        parallel::for_chunks(corner, kernel);
        seen(corner);
        return parallel::for_rows(out, |v, out| *out = gathered(topology, corner, v));
    }
    corner.resize(corner.len().max(CORNER_BLOCK), [DVec3::ZERO; 3]);
    out.fill(DVec3::ZERO);
    for (b, block) in corners.chunks(CORNER_BLOCK).enumerate() {
        let of_block = &mut corner[..block.len()];
        run(kernel, b * CORNER_BLOCK, of_block);
        seen(of_block);
        for (of_triangle, corners) in of_block.iter().zip(block) {
            for (of_corner, &v) in of_triangle.iter().zip(corners) {
                out[v as usize] += *of_corner;
            }
        }
    }
}

/// The sum at one vertex of all corners, in the order of the triangles' rows.
pub fn gathered(topology: &Topology, corner: &[[DVec3; 3]], v: usize) -> DVec3 {
    // An incident entry is three times its triangle plus the corner: an index into the corners laid end to end.
    let corner = corner.as_flattened();
    topology.incident[v].iter().map(|&c| corner[c as usize]).sum()
}

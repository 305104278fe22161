//! The operator of the next coarser level: PᵀAP.

use super::super::empty;
use super::super::pattern::Pattern;
use super::interpolation::Parts;
use super::level::Level;
use super::transfer::Transfer;
use crate::systems::kernels::block;

/// The pattern of the coarser level.
pub fn rebuild_pattern(coarse: &mut Pattern, fine: &Pattern, transfer: &Transfer) {
    let node_count = transfer.coarsening.row.len();
    // As many as on a regular grid.
    coarse.begin(node_count, 4 * node_count);
    for node in 0..node_count {
        let rows = transfer.support(node).iter().flat_map(|&(row, _)| fine.neighbours(row as usize).chain([row]));
        let columns = rows.flat_map(|row| transfer.parts[row as usize].iter().map(|(other, _)| other as u32));
        coarse.push_row(columns.filter(|&other| (other as usize) < node));
    }
    coarse.finish();
}

/// The numbers of the coarser level, whose pattern and free axes stand.
pub fn assemble(coarse: &mut Level, fine: &Level, transfer: &Transfer) {
    let node_count = coarse.pattern.row_count();
    let Level { pattern, diagonal, lower, .. } = coarse;
    let pattern = &*pattern;
    empty(diagonal, node_count);
    diagonal.resize(node_count, block::ZERO);
    empty(lower, pattern.column.len());
    lower.resize(pattern.column.len(), block::ZERO);
    for node in 0..node_count {
        let start = pattern.row_start[node] as usize;
        let columns = &pattern.column[start..pattern.row_start[node + 1] as usize];
        let (own, of_row) = (&mut diagonal[node], &mut lower[start..start + columns.len()]);
        let mut add = |row: usize, weight: f32, value: &block::Block| {
            let Parts { node: others, weight: weights } = transfer.parts[row];
            for (other, part) in others.into_iter().zip(weights) {
                let factor = weight * part;
                if factor == 0.0 || other as usize > node {
                    continue;
                }
                let target = if other as usize == node {
                    &mut *own
                } else {
                    let k = columns.iter().take_while(|&&column| column != other).count();
                    &mut of_row[k]
                };
                *target = block::sum(target, value, factor);
            }
        };
        for &(row, weight) in transfer.support(node) {
            let row = row as usize;
            add(row, weight, &fine.diagonal[row]);
            let p = &fine.pattern;
            for k in p.before(row) {
                add(p.column[k] as usize, weight, &fine.lower[k]);
            }
            for k in p.after(row) {
                add(p.below[k][0] as usize, weight, &fine.upper[k]);
            }
        }
    }
}

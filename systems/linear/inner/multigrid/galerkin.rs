//! The operator of the next coarser level: PᵀAP.

use super::super::empty;
use super::super::pattern::Pattern;
use super::interpolation::Parts;
use super::level::Level;
use crate::systems::kernels::block;
use glam::Vec4;

/// Which rows hang on a node.
#[derive(Debug, Default)]
pub struct Support {
    /// First entry of every node in `row`; one more entry at the end.
    start: Vec<u32>,
    /// Rows and their weights, ascending rows for each node.
    row: Vec<(u32, f32)>,
}

impl Support {
    /// Sorts the parts of the rows by nodes.
    pub fn rebuild(&mut self, parts: &[Parts], node_count: usize) {
        empty(&mut self.start, node_count + 1);
        self.start.resize(node_count + 1, 0);
        for (node, _) in parts.iter().flat_map(Parts::iter) {
            self.start[node + 1] += 1;
        }
        for node in 0..node_count {
            self.start[node + 1] += self.start[node];
        }
        let count = self.start[node_count] as usize;
        empty(&mut self.row, count);
        self.row.resize(count, (0, 0.0));
        for (row, parts) in parts.iter().enumerate() {
            for (node, weight) in parts.iter() {
                self.row[self.start[node] as usize] = (row as u32, weight);
                self.start[node] += 1;
            }
        }
        self.start.rotate_right(1);
        self.start[0] = 0;
    }

    fn of(&self, node: usize) -> &[(u32, f32)] {
        &self.row[self.start[node] as usize..self.start[node + 1] as usize]
    }
}

/// The pattern of the coarser level.
pub fn rebuild_pattern(coarse: &mut Pattern, fine: &Pattern, parts: &[Parts], support: &Support, node_count: usize) {
    // As many as on a regular grid.
    coarse.begin(node_count, 4 * node_count);
    for node in 0..node_count {
        let rows = support.of(node).iter().flat_map(|&(row, _)| fine.neighbours(row as usize).chain([row]));
        let columns = rows.flat_map(|row| parts[row as usize].iter().map(|(other, _)| other as u32));
        coarse.push_row(columns.filter(|&other| (other as usize) < node));
    }
    coarse.finish();
}

/// The numbers of the coarser level, whose pattern and free axes stand.
pub fn assemble(coarse: &mut Level, fine: &Level, parts: &[Parts], support: &Support) {
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
            let Parts { node: others, weight: weights } = parts[row];
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
        for &(row, weight) in support.of(node) {
            let row = row as usize;
            add(row, weight, &fine.diagonal[row]);
            let p = &fine.pattern;
            for k in p.row_start[row] as usize..p.row_start[row + 1] as usize {
                add(p.column[k] as usize, weight, &fine.lower[k]);
            }
            for k in p.column_start[row] as usize..p.column_start[row + 1] as usize {
                add(p.below[k][0] as usize, weight, &fine.upper[k]);
            }
        }
    }
}

/// A node has the free axes of its row.
pub fn free_axes(coarse: &mut Vec<Vec4>, fine: &[Vec4], row: &[u32]) {
    empty(coarse, row.len());
    coarse.extend(row.iter().map(|&row| fine[row as usize]));
}

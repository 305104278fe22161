//! Transfer from one level to the next: which rows are its nodes, how the others hang on them.

use super::super::empty;
use super::super::pattern::BlockPattern;
use super::coarsen::{Coarsening, NO_NODE};
use super::interpolation::{self, Parts, Place};
use super::marks::Marks;
use super::numbering::Numbering;
use crate::systems::parallel;
use glam::Vec4;

/// From a level to the next coarser one.
#[derive(Debug, Default)]
pub(super) struct Transfer {
    /// Which rows are nodes.
    pub coarsening: Coarsening,
    /// The nodes of every row.
    pub parts: Vec<Parts>,
    /// First entry of every node in `support`; one more entry at the end.
    start: Vec<u32>,
    /// Rows that hang on every node, and their weights: ascending rows.
    support: Vec<(u32, f32)>,
    /// Room for the rows of the nodes in another order.
    by_row: Vec<u32>,
    /// Scratch of edits: marks two edges and three about those of the rows.
    stale: Marks,
    near: Marks,
}

impl Transfer {
    /// With this choice of nodes; the rest comes with [`follow`](Self::follow).
    pub(super) fn of(coarsening: Coarsening) -> Self {
        Self { coarsening, ..Self::default() }
    }

    /// Sorts the parts of the rows by nodes.
    pub(super) fn sort(&mut self) {
        let node_count = self.coarsening.row.len();
        empty(&mut self.start, node_count + 1);
        self.start.resize(node_count + 1, 0);
        for (node, _) in self.parts.iter().flat_map(Parts::iter) {
            self.start[node + 1] += 1;
        }
        for node in 0..node_count {
            self.start[node + 1] += self.start[node];
        }
        let count = self.start[node_count] as usize;
        empty(&mut self.support, count);
        self.support.resize(count, (0, 0.0));
        for (row, parts) in self.parts.iter().enumerate() {
            for (node, weight) in parts.iter() {
                self.support[self.start[node] as usize] = (row as u32, weight);
                self.start[node] += 1;
            }
        }
        // Every start has moved on to that of the next node.
        self.start.rotate_right(1);
        self.start[0] = 0;
    }

    /// Gives the nodes, which stand in the order of their places, their rows in a numbering.
    pub(super) fn renumber(&mut self, numbering: Numbering) {
        let by_place = &self.coarsening.row;
        empty(&mut self.by_row, by_place.len());
        self.by_row.extend((0..by_place.len() as u32).map(|row| by_place[numbering.place(row) as usize]));
        std::mem::swap(&mut self.coarsening.row, &mut self.by_row);
        for node in self.coarsening.node.iter_mut().filter(|node| **node != NO_NODE) {
            *node = numbering.row(*node);
        }
        parallel::for_rows(&mut self.parts, |_, parts| parts.node = parts.node.map(|place| numbering.row(place)));
        self.sort();
    }

    /// After edits: recomputes the parts of rows within two edges of marked ones, the range of the neighbourhoods that they depend on.
    /// Leaves marks on the nodes whose rows of the next level may have other columns.
    pub(super) fn follow(&mut self, pattern: &BlockPattern, places: &[Place], marks: &Marks, of_nodes: &mut Marks) {
        self.parts.resize(places.len(), Parts::default());
        of_nodes.clear(self.coarsening.row.len());
        self.near.spread_from(marks, pattern);
        self.stale.spread_from(&self.near, pattern);
        self.near.spread_from(&self.stale, pattern);
        for (parts, mark) in self.parts.iter().zip(self.near.iter()) {
            // A row that is gone tells which rows to recompute, not where edits have been.
            parts.iter().for_each(|(node, _)| of_nodes.add(node, mark.of_stale()));
        }
        let stale = &self.stale;
        interpolation::refresh(&mut self.parts, pattern, places, &self.coarsening.node, |row| stale.is_any(row));
        for (parts, mark) in self.parts.iter().zip(self.near.iter()) {
            parts.iter().for_each(|(node, _)| of_nodes.add(node, mark));
        }
        self.sort();
    }

    /// Rows that hang on a node, and their weights.
    #[inline(always)]
    pub(super) fn support(&self, node: usize) -> &[(u32, f32)] {
        &self.support[self.start[node] as usize..self.start[node + 1] as usize]
    }

    /// `coarse` = Pᵀ·fine.
    pub(super) fn restrict(&self, fine: &[Vec4], coarse: &mut [Vec4]) {
        parallel::for_rows(coarse, |node, sum| {
            *sum = Vec4::ZERO;
            for &(row, weight) in self.support(node) {
                *sum += fine[row as usize] * weight;
            }
        });
    }

    /// fine += P·coarse.
    pub(super) fn prolong(&self, coarse: &[Vec4], fine: &mut [Vec4]) {
        parallel::for_rows(fine, |row, x| {
            let Parts { node: [a, b, c], weight: [u, v, w] } = self.parts[row];
            *x += coarse[a as usize] * u + coarse[b as usize] * v + coarse[c as usize] * w;
        });
    }
}

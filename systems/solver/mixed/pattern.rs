//! Where the blocks of a symmetric sparse matrix stand: those below the diagonal by rows and, for who asks, each again by columns, which
//! is its transpose above the diagonal by rows.

use super::adjacency::{before_with_fill, neighbours};
use super::edits::Edits;
use super::empty;
use super::matrix::{EDGES, Matrix, OfPacks};
use super::partition::{EMPTY, Partition};
use crate::storage::Topology;
use crate::systems::kernels::pack::LANES;
use crate::systems::kernels::simd::wide;
use std::ops::Range;

/// The pattern of a symmetric matrix.
#[derive(Debug, Default)]
pub(super) struct BlockPattern {
    /// First block of every row in `column`; one more entry at the end.
    pub row_start: Vec<u32>,
    /// Columns of the blocks before the diagonal, ascending in each row.
    pub column: Vec<u32>,
    /// First entry of every column in `below`; one more entry at the end. Empty until the pattern is finished, as is `below`.
    pub column_start: Vec<u32>,
    /// Row and block of every entry below the diagonal, rows ascending in each column.
    pub below: Vec<[u32; 2]>,
    /// Per lane of every pack where in their rows the blocks of its [`EDGES`] stand; [`FAR_IN_ROW`] where that is to be counted.
    target: Vec<[[u8; LANES]; 3]>,
    /// Scratch of edits: the rows and columns before.
    row_start_before: Vec<u32>,
    column_before: Vec<u32>,
    /// Whether it has the fill of level one, and rows of even length.
    is_filled: bool,
}

/// So far into its row or farther.
const FAR_IN_ROW: u8 = u8::MAX;

impl BlockPattern {
    /// A pattern with the fill of level one: besides neighbours, rows have a block where both are neighbours of a row before them. A row
    /// of an odd number of blocks has one more in its own column, for all to come in pairs.
    pub(super) fn filled() -> Self {
        Self { is_filled: true, ..Self::default() }
    }

    /// Finds the pattern of the triangles anew, by rows; `vertex` has the vertices in their order, `row` the row of each, `near` the
    /// neighbours of a vertex.
    pub(super) fn rebuild<I: Iterator<Item = u32>>(
        &mut self,
        partition: &Partition,
        (vertex, row): (&[u32], &[u32]),
        corners: &[[u32; 3]],
        near: impl Fn(u32) -> I + Copy,
    ) {
        // Three edges for each vertex of a surface; about one block of fill for each, and half a one for even rows.
        let blocks = if self.is_filled { 9 * vertex.len() / 2 } else { 3 * vertex.len() };
        self.begin(vertex.len(), blocks);
        for &v in vertex {
            self.push_row_of(v, row, near);
        }
        let mut target = std::mem::take(&mut self.target);
        empty(&mut target, partition.places.len());
        self.find_targets(&mut target, partition, row, corners);
        self.target = target;
    }

    /// Follows edits: rows that they do not touch, and that say so, keep their columns, and rows that stood elsewhere are moved. Arguments
    /// of [`rebuild`](Self::rebuild), all of them after the edits.
    pub(super) fn follow(
        &mut self,
        partition: &Partition,
        (vertex, row): (&[u32], &[u32]),
        corners: &[[u32; 3]],
        topology: &Topology,
        edits: &Edits,
        stays: impl Fn(usize) -> bool,
    ) {
        let near = |v: u32| neighbours(v, corners, topology);
        self.renew(vertex.len(), &stays, |pattern, i| pattern.push_row_of(vertex[i], row, near));
        // Targets change where rows have been pushed anew, and in packs with other triangles.
        let mut target = std::mem::take(&mut self.target);
        target.truncate(partition.packs_as_before(edits.count_before));
        let rows_before = self.row_start_before.len().saturating_sub(1);
        for (_, &v) in vertex.iter().enumerate().filter(|(row, _)| *row >= rows_before || !stays(*row)) {
            for t in topology.incident[v as usize].iter().map(|entry| entry / 3) {
                let (pack, lane) = partition.place_of(t);
                if let Some(targets) = target.get_mut(pack) {
                    for (targets, edge) in targets.iter_mut().zip(EDGES) {
                        targets[lane] = self.find_target(t, edge, row, corners);
                    }
                }
            }
        }
        self.find_targets(&mut target, partition, row, corners);
        self.target = target;
    }

    /// Becomes a pattern of so many rows: those that there were and that stay as they are keep their columns, and `push` adds the others.
    pub(super) fn renew(&mut self, rows: usize, stays: impl Fn(usize) -> bool, mut push: impl FnMut(&mut Self, usize)) {
        std::mem::swap(&mut self.row_start, &mut self.row_start_before);
        std::mem::swap(&mut self.column, &mut self.column_before);
        self.begin(rows, self.column_before.len());
        let rows_before = self.row_start_before.len().saturating_sub(1);
        let stays = |row: usize| row < rows_before && stays(row);
        let mut next = 0;
        while next < rows {
            let end = (next..rows).find(|&row| !stays(row)).unwrap_or(rows);
            if end > next {
                let (from, to) = (self.row_start_before[next] as usize, self.row_start_before[end] as usize);
                let start = self.column.len() as u32;
                let starts = &self.row_start_before[next + 1..=end];
                self.row_start.extend(starts.iter().map(|&before| before - from as u32 + start));
                self.column.extend_from_slice(&self.column_before[from..to]);
            } else {
                push(self, next);
            }
            next = end.max(next + 1);
        }
    }

    /// The lists that only edits use.
    pub(super) fn spare_lists(&mut self) -> [&mut Vec<u32>; 2] {
        [&mut self.row_start_before, &mut self.column_before]
    }

    /// Becomes another pattern with its rows in another order: `new` gives a row its new place, `old` the other way round.
    pub(super) fn reorder(&mut self, other: &Self, new: impl Fn(u32) -> u32, old: impl Fn(u32) -> u32) {
        self.begin(other.row_count(), other.column.len());
        for row in 0..other.row_count() as u32 {
            self.push_row(other.neighbours(old(row) as usize).map(&new).filter(|&column| column < row));
        }
        self.finish();
    }

    /// Begins a pattern of so many rows and about so many blocks.
    pub(super) fn begin(&mut self, rows: usize, blocks: usize) {
        empty(&mut self.row_start, rows + 1);
        empty(&mut self.column, blocks);
        self.row_start.push(0);
    }

    /// Adds the row of a vertex.
    fn push_row_of<I: Iterator<Item = u32>>(&mut self, v: u32, row: &[u32], near: impl Fn(u32) -> I + Copy) {
        let i = row[v as usize];
        if !self.is_filled {
            self.push_row(near(v).map(|w| row[w as usize]).filter(|&c| c < i));
            return;
        }
        self.push_row(before_with_fill(v, row, near).map(|w| row[w as usize]));
        if !self.column.len().is_multiple_of(2) {
            self.column.push(i);
            *self.row_start.last_mut().unwrap_or(&mut 0) += 1;
        }
    }

    /// Adds a row: its columns before the diagonal, in any order, some of them more than once.
    pub(super) fn push_row(&mut self, columns: impl Iterator<Item = u32>) {
        let start = self.column.len();
        for column in columns {
            if !self.column[start..].contains(&column) {
                self.column.push(column);
            }
        }
        self.column[start..].sort_unstable();
        self.row_start.push(self.column.len() as u32);
    }

    /// After the last row, for who goes by columns too: sorts the blocks by them.
    pub(super) fn finish(&mut self) {
        let n = self.row_count();
        empty(&mut self.column_start, n + 1);
        self.column_start.resize(n + 1, 0);
        for &column in &self.column {
            self.column_start[column as usize + 1] += 1;
        }
        for column in 0..n {
            self.column_start[column + 1] += self.column_start[column];
        }
        empty(&mut self.below, self.column.len());
        self.below.resize(self.column.len(), [0; 2]);
        for row in 0..n {
            for block in self.row_start[row]..self.row_start[row + 1] {
                let next = &mut self.column_start[self.column[block as usize] as usize];
                self.below[*next as usize] = [row as u32, block];
                *next += 1;
            }
        }
        // Every start has moved on to that of the next column.
        self.column_start.rotate_right(1);
        self.column_start[0] = 0;
    }

    /// Adds the targets of the packs that have none yet.
    fn find_targets(
        &self,
        targets: &mut Vec<[[u8; LANES]; 3]>,
        partition: &Partition,
        row: &[u32],
        corners: &[[u32; 3]],
    ) {
        for pack in targets.len()..partition.places.len() {
            let (triangles, mut target) = (partition.triangles(pack), [[0; LANES]; 3]);
            for (target, edge) in target.iter_mut().zip(EDGES) {
                for (target, &t) in target.iter_mut().zip(&triangles).filter(|(_, t)| **t != EMPTY) {
                    *target = self.find_target(t, edge, row, corners);
                }
            }
            targets.push(target);
        }
    }

    /// The target of an edge of a triangle.
    fn find_target(&self, t: u32, edge: [usize; 2], row: &[u32], corners: &[[u32; 3]]) -> u8 {
        let [a, b] = edge.map(|corner| row[corners[t as usize][corner] as usize] as usize);
        u8::try_from(self.find(a.max(b), a.min(b))).unwrap_or(FAR_IN_ROW)
    }

    /// Where in its row the block of two neighbours stands.
    fn find(&self, row: usize, column: usize) -> usize {
        self.column[self.before(row)].iter().take_while(|&&c| c as usize != column).count()
    }

    /// Whether it is the same pattern, entry by entry.
    #[cfg(test)]
    pub fn equals(&self, other: &Self) -> bool {
        let rows = |p: &Self| (p.row_start.clone(), p.column.clone());
        let columns = |p: &Self| (p.column_start.clone(), p.below.clone());
        rows(self) == rows(other) && columns(self) == columns(other) && self.target == other.target
    }

    /// Number of rows.
    pub(super) fn row_count(&self) -> usize {
        self.row_start.len() - 1
    }

    /// Blocks of a row before the diagonal.
    #[inline(always)]
    pub(super) fn before(&self, row: usize) -> Range<usize> {
        self.row_start[row] as usize..self.row_start[row + 1] as usize
    }

    /// Entries of `below` for a row, which are its blocks after the diagonal.
    #[inline(always)]
    pub(super) fn after(&self, row: usize) -> Range<usize> {
        self.column_start[row] as usize..self.column_start[row + 1] as usize
    }

    /// Largest difference of row and column of a block.
    pub(super) fn width(&self) -> u32 {
        let of_row = |row: usize| self.column[self.before(row)].first().map_or(0, |&column| row as u32 - column);
        (0..self.row_count()).map(of_row).max().unwrap_or(0)
    }

    /// The rows that a row has a block with, but for itself: those before it, then those after it.
    pub(super) fn neighbours(&self, row: usize) -> impl Iterator<Item = u32> + '_ {
        let (before, after) = (&self.column[self.before(row)], &self.below[self.after(row)]);
        before.iter().copied().chain(after.iter().map(|entry| entry[0]))
    }

    /// Calls `diagonal(row, block)` and `lower(row, place, block)` for the blocks of the triangles of some of the partition's; `place` is
    /// where one stands below the diagonal. `row` is where a row of the matrix stands here.
    pub(super) fn gather<B: OfPacks>(
        &self,
        (partition, blocks): (&Partition, Range<usize>),
        matrix: &Matrix,
        row: impl Fn(usize) -> usize,
        mut diagonal: impl FnMut(usize, &B),
        mut lower: impl FnMut(usize, usize, &B),
    ) {
        // Marked down to the last closure: a call that is not inlined has none of the wide instructions.
        wide(
            #[inline(always)]
            || {
                matrix.add_blocks(
                    partition,
                    blocks,
                    #[inline(always)]
                    |of, value: &B| diagonal(row(of), value),
                    #[inline(always)]
                    |(pack, edge, lane), rows, value| {
                        let [a, b] = rows.map(&row);
                        let (row, column) = (a.max(b), a.min(b));
                        let value = if a < b { &value.transposed() } else { value };
                        let within = match self.target[pack][edge][lane] {
                            FAR_IN_ROW => self.find(row, column),
                            near => near.into(),
                        };
                        lower(row, self.row_start[row] as usize + within, value);
                    },
                );
            },
        );
    }
}

//! Where the blocks of a symmetric sparse matrix stand: those below the diagonal by rows, and each again by columns, which is
//! its transpose above the diagonal by rows.

use super::empty;
use super::matrix::Matrix;
use super::order::neighbours;
use super::partition::{EMPTY, Partition};
use crate::storage::Topology;
use crate::systems::kernels::block::{self, Block};
use crate::systems::kernels::pack::LANES;
use crate::systems::kernels::simd::wide;
use crate::systems::parallel;
use std::ops::Range;

/// The pattern of a symmetric matrix.
#[derive(Debug, Default)]
pub struct Pattern {
    /// First block of every row in `column`; one more entry at the end.
    pub row_start: Vec<u32>,
    /// Columns of the blocks before the diagonal, ascending in each row.
    pub column: Vec<u32>,
    /// First entry of every column in `below`; one more entry at the end.
    pub column_start: Vec<u32>,
    /// Row and block of every entry below the diagonal, rows ascending in each column.
    pub below: Vec<[u32; 2]>,
    /// Per lane of every pack the blocks of its edges 1–0, 2–0, 2–1, doubled; odd where the block is the transpose.
    target: Vec<[[u32; LANES]; 3]>,
}

/// Corners of the edges of `target`.
const EDGES: [[usize; 2]; 3] = [[1, 0], [2, 0], [2, 1]];

impl Pattern {
    /// Finds the pattern of the triangles anew; `vertex` has the vertices in their order, `row` the row of each.
    pub fn rebuild(
        &mut self,
        partition: &Partition,
        (vertex, row): (&[u32], &[u32]),
        corners: &[[u32; 3]],
        topology: &Topology,
    ) {
        // Three edges for each vertex of a surface.
        self.begin(vertex.len(), 3 * vertex.len());
        for (i, &v) in vertex.iter().enumerate() {
            self.push_row(neighbours(v, corners, topology).map(|w| row[w as usize]).filter(|&c| c < i as u32));
        }
        self.finish();
        self.find_targets(partition, row, corners);
    }

    /// Becomes another pattern with its rows in another order: `new` gives a row its new place, `old` the other way round.
    pub fn reorder(&mut self, other: &Self, new: impl Fn(u32) -> u32, old: impl Fn(u32) -> u32) {
        self.begin(other.row_count(), other.column.len());
        for row in 0..other.row_count() as u32 {
            self.push_row(other.neighbours(old(row) as usize).map(&new).filter(|&column| column < row));
        }
        self.finish();
    }

    /// Begins a pattern of so many rows and about so many blocks.
    pub fn begin(&mut self, rows: usize, blocks: usize) {
        empty(&mut self.row_start, rows + 1);
        empty(&mut self.column, blocks);
        self.row_start.push(0);
    }

    /// Adds a row: its columns before the diagonal, in any order, some of them more than once.
    pub fn push_row(&mut self, columns: impl Iterator<Item = u32>) {
        let start = self.column.len();
        for column in columns {
            if !self.column[start..].contains(&column) {
                self.column.push(column);
            }
        }
        self.column[start..].sort_unstable();
        self.row_start.push(self.column.len() as u32);
    }

    /// After the last row: sorts the blocks by columns.
    pub fn finish(&mut self) {
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

    fn find_targets(&mut self, partition: &Partition, row: &[u32], corners: &[[u32; 3]]) {
        empty(&mut self.target, partition.triangle.len());
        for triangles in &partition.triangle {
            let mut target = [[0; LANES]; 3];
            for (target, [a, b]) in target.iter_mut().zip(EDGES) {
                for (target, &t) in target.iter_mut().zip(triangles) {
                    if t != EMPTY {
                        let [a, b] = [a, b].map(|corner| row[corners[t as usize][corner] as usize]);
                        *target = 2 * self.find(a.max(b), a.min(b)) + u32::from(a < b);
                    }
                }
            }
            self.target.push(target);
        }
    }

    /// The block of two neighbours.
    fn find(&self, row: u32, column: u32) -> u32 {
        let start = self.row_start[row as usize];
        let columns = &self.column[start as usize..self.row_start[row as usize + 1] as usize];
        start + columns.iter().take_while(|&&c| c != column).count() as u32
    }

    /// Number of rows.
    pub fn row_count(&self) -> usize {
        self.row_start.len() - 1
    }

    /// Blocks of a row before the diagonal.
    #[inline(always)]
    pub fn before(&self, row: usize) -> Range<usize> {
        self.row_start[row] as usize..self.row_start[row + 1] as usize
    }

    /// Entries of `below` for a row, which are its blocks after the diagonal.
    #[inline(always)]
    pub fn after(&self, row: usize) -> Range<usize> {
        self.column_start[row] as usize..self.column_start[row + 1] as usize
    }

    /// Largest difference of row and column of a block.
    pub fn width(&self) -> u32 {
        let of_row = |row: usize| self.column[self.before(row)].first().map_or(0, |&column| row as u32 - column);
        (0..self.row_count()).map(of_row).max().unwrap_or(0)
    }

    /// The rows that a row has a block with, but for itself: those before it, then those after it.
    pub fn neighbours(&self, row: usize) -> impl Iterator<Item = u32> + '_ {
        let (before, after) = (&self.column[self.before(row)], &self.below[self.after(row)]);
        before.iter().copied().chain(after.iter().map(|entry| entry[0]))
    }

    /// Sums the triangles' blocks and those that the vertices have by themselves. `place` is where a row of the matrix stands here.
    pub fn gather(
        &self,
        partition: &Partition,
        matrix: &Matrix,
        place: impl Fn(usize) -> usize,
        diagonal: &mut Vec<Block>,
        lower: &mut Vec<Block>,
    ) {
        empty(lower, self.column.len());
        lower.resize(self.column.len(), block::ZERO);
        empty(diagonal, matrix.own.len());
        diagonal.resize(matrix.own.len(), block::ZERO);
        for (row, [x, y, z, _]) in matrix.own.iter().enumerate() {
            diagonal[place(row)] = [*x, *y, *z];
        }
        wide(|| {
            matrix.add_blocks(
                partition,
                |row, value| block::add(&mut diagonal[place(row)], value),
                |pack, edge, lane, value| {
                    let target = self.target[pack][edge][lane];
                    let block = &mut lower[target as usize / 2];
                    if target % 2 == 1 { block::add(block, &block::transpose(value)) } else { block::add(block, value) }
                },
            );
        });
    }

    /// The blocks above the diagonal, by rows: the transposes of those below, by columns.
    pub fn mirror(&self, lower: &[Block], upper: &mut Vec<Block>) {
        empty(upper, lower.len());
        upper.resize(lower.len(), block::ZERO);
        parallel::for_rows(upper, |i, block| *block = block::transpose(&lower[self.below[i][1] as usize]));
    }
}

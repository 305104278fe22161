//! Incomplete Cholesky factor without fill, by 3×3 blocks: M = L·D·Lᵀ, L with the pattern of A (Meijerink, van der Vorst 1977).
//!
//! A body torn, folded and partly slack has stiff and soft directions side by side, and changes from step to step: the factor is
//! made anew for every solve, which costs as much as a few iterations and saves three out of four of them. Both sweeps are
//! serial by nature; rows stand in an order in which neighbours are far apart (see [`super::order`]), so that the processor
//! works on several at a time.

use super::cg::{Precondition, Vectors};
use super::empty;
use super::matrix::{Matrix, dot};
use super::order::{Order, neighbours};
use super::partition::{EMPTY, Partition};
use crate::storage::Topology;
use crate::systems::kernels::block::{self, Block};
use crate::systems::kernels::pack::LANES;
use crate::systems::kernels::simd::wide;
use glam::DVec2;

/// The factor, and where its blocks stand.
#[derive(Debug, Default)]
pub struct Incomplete {
    /// First block of every row in `column`; one more entry at the end.
    row_start: Vec<u32>,
    /// Columns of the blocks before the diagonal, ascending in each row.
    column: Vec<u32>,
    /// First entry of every column in `below`; one more entry at the end.
    column_start: Vec<u32>,
    /// Row and block of every entry below the diagonal.
    below: Vec<[u32; 2]>,
    /// Per lane of every pack the blocks of its edges 1–0, 2–0, 2–1, doubled; odd where the block is the transpose.
    target: Vec<[[u32; LANES]; 3]>,
    /// Blocks of L.
    lower: Vec<Block>,
    /// Their transposes, by columns.
    upper: Vec<Block>,
    /// Diagonal blocks of A, then the inverses of those of D.
    inverse: Vec<Block>,
    /// Blocks of L·D in the row at hand.
    row: Vec<Block>,
}

/// A pivot is to be at least this part of the body's own diagonal block, as quadratic forms: below, the fill that is left out
/// has used it up. (A direction that is soft in the block itself may be as soft in the pivot.)
const LEAST_PART: f32 = 0.1;

/// Parts of its own block by which a pivot that has been used up is raised, the least that will do.
const REPAIRS: [f32; 3] = [0.1, 0.3, 1.0];

/// Corners of the edges of `target`.
const EDGES: [[usize; 2]; 3] = [[1, 0], [2, 0], [2, 1]];

impl Incomplete {
    /// Finds the pattern anew.
    pub fn rebuild(&mut self, partition: &Partition, order: &Order, corners: &[[u32; 3]], topology: &Topology) {
        let n = order.vertex.len();
        empty(&mut self.row_start, n + 1);
        // Three edges for each vertex of a surface.
        empty(&mut self.column, 3 * n);
        empty(&mut self.column_start, n + 1);
        self.column_start.resize(n + 1, 0);
        for (row, &v) in order.vertex.iter().enumerate() {
            let start = self.column.len();
            self.row_start.push(start as u32);
            for w in neighbours(v, corners, topology) {
                let column = order.row[w as usize];
                if column < row as u32 && !self.column[start..].contains(&column) {
                    self.column.push(column);
                    self.column_start[column as usize + 1] += 1;
                }
            }
            self.column[start..].sort_unstable();
        }
        self.row_start.push(self.column.len() as u32);
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
        self.find_targets(partition, &order.row, corners);
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

    /// Factors the operator with its diagonal raised by a fraction `shift` of itself (Manteuffel 1980).
    pub fn factor(&mut self, partition: &Partition, matrix: &Matrix, shift: f32) {
        wide(|| {
            self.gather(partition, matrix);
            self.eliminate(matrix, shift);
        });
        wide(|| {
            empty(&mut self.upper, self.lower.len());
            self.upper.extend(self.below.iter().map(|entry| block::transpose(&self.lower[entry[1] as usize])));
        });
    }

    /// Sums the triangles' blocks.
    #[inline(always)]
    fn gather(&mut self, partition: &Partition, matrix: &Matrix) {
        empty(&mut self.lower, self.column.len());
        self.lower.resize(self.column.len(), block::ZERO);
        empty(&mut self.inverse, matrix.own.len());
        self.inverse.extend(matrix.own.iter().map(|[x, y, z, _]| [*x, *y, *z]));
        let (diagonal, lower, target) = (&mut self.inverse, &mut self.lower, &self.target);
        matrix.add_blocks(
            partition,
            |row, value| block::add(&mut diagonal[row], value),
            |pack, edge, lane, value| {
                let target = target[pack][edge][lane];
                let block = &mut lower[target as usize / 2];
                if target % 2 == 1 { block::add(block, &block::transpose(value)) } else { block::add(block, value) }
            },
        );
    }

    #[inline(always)]
    fn eliminate(&mut self, matrix: &Matrix, shift: f32) {
        for i in 0..self.inverse.len() {
            let (start, end) = (self.row_start[i] as usize, self.row_start[i + 1] as usize);
            let free = matrix.own[i][3];
            let own = block::mask(&self.inverse[i], free, free).map(|column| column * (1.0 + shift));
            let mut diagonal = own;
            self.row.clear();
            for k in start..end {
                let column = self.column[k] as usize;
                let mut w = block::mask(&self.lower[k], free, matrix.own[column][3]);
                let mut other = self.row_start[column] as usize;
                let other_end = self.row_start[column + 1] as usize;
                // Both rows ascend.
                for j in start..k {
                    while other < other_end && self.column[other] < self.column[j] {
                        other += 1;
                    }
                    if other < other_end && self.column[other] == self.column[j] {
                        block::subtract_product_transposed(&mut w, &self.row[j - start], &self.lower[other]);
                    }
                }
                let l = block::product(&w, &self.inverse[column]);
                block::subtract_product_transposed(&mut diagonal, &w, &l);
                self.lower[k] = l;
                self.row.push(w);
            }
            let is_sound = |d: &Block| block::is_positive(&block::sum(d, &own, -LEAST_PART), free);
            if !is_sound(&diagonal) {
                let mut repaired = REPAIRS.iter().map(|&part| block::sum(&diagonal, &own, part));
                diagonal = repaired.find(is_sound).unwrap_or(own);
            }
            self.inverse[i] = block::invert(&diagonal, free).unwrap_or_else(|| block::invert_alone(&own, free));
        }
    }
}

impl Precondition for Incomplete {
    fn descend(&mut self, alpha: f32, vectors: &mut Vectors) -> DVec2 {
        let Vectors { xr, p, q, z, .. } = vectors;
        let mut sums = DVec2::ZERO;
        wide(|| {
            for (i, [x, r]) in xr.iter_mut().enumerate() {
                *x += p[i] * alpha;
                *r -= q[i] * alpha;
                let mut y = *r;
                let row = self.row_start[i] as usize..self.row_start[i + 1] as usize;
                for (l, &j) in self.lower[row.clone()].iter().zip(&self.column[row]) {
                    y -= block::apply(l, z[j as usize]);
                }
                z[i] = y;
                sums += DVec2::new(dot(*r, *r), dot(y, block::apply(&self.inverse[i], y)));
            }
        });
        sums
    }

    fn ascend(&mut self, beta: f32, vectors: &mut Vectors) {
        let Vectors { p, z: all, .. } = vectors;
        wide(|| {
            for i in (0..p.len()).rev() {
                let mut z = block::apply(&self.inverse[i], all[i]);
                let column = self.column_start[i] as usize..self.column_start[i + 1] as usize;
                for (u, &[row, _]) in self.upper[column.clone()].iter().zip(&self.below[column]) {
                    z -= block::apply(u, all[row as usize]);
                }
                all[i] = z;
                p[i] = z + p[i] * beta;
            }
        });
    }
}

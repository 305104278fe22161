//! A Cholesky factor laid out for solving with it: one dense panel of numbers per supernode.
//!
//! A supernode is a run of columns of L with the same rows: a triangle T on the diagonal and a rectangle B under it. Solving
//! with L takes y = T⁻¹·x and subtracts B·y from the rows below; solving with Lᵀ is the transpose of that. Both are products
//! with the one panel P = [T⁻¹; B·T⁻¹], which is therefore stored: no chain of dependent divisions is left, and every
//! number is read once on the way down and once on the way up.
//!
//! Columns in two subdomains that do not need each other (see [`super::dissect`]) are swept side by side, with the same bits on one
//! thread as on two. The second subdomain has its own sums for the columns of the separator.

use crate::systems::kernels::simd::{LANES, NullaryFnOnce, wide};
use crate::systems::parallel;
use faer::sparse::linalg::cholesky::supernodal::SupernodalLltRef;
use std::ops::Range;

/// A factor's panels. The layout of one with `w` columns: blocks of eight rows, in each block the columns one after the other.
#[derive(Debug, Default)]
pub(super) struct Panels {
    /// First column of each supernode, and the number of columns at the end.
    first: Vec<u32>,
    /// Where each supernode's rows below its triangle begin in `row`; one more entry at the end.
    row_start: Vec<u32>,
    row: Vec<u32>,
    /// Where each panel begins in `block`; one more entry at the end.
    block_start: Vec<usize>,
    block: Vec<[f64; LANES]>,
    /// The supernodes with which the second subdomain and the separator begin; zero where there is no cut, and all are the
    /// separator.
    second: usize,
    separator: usize,
    /// The second subdomain's share in the columns of the separator.
    sums: Vec<f64>,
    /// A panel's input or output, for each of two threads.
    work: [Vec<[f64; LANES]>; 2],
    /// One number per column: the right-hand side, then the answer.
    pub column: Vec<f64>,
    /// The panel at hand, by columns.
    panel: Vec<f64>,
}

impl Panels {
    /// Takes over a factor; `subdomains` has the columns with which the second subdomain and the separator begin, if there are two
    /// subdomains.
    pub(super) fn fill(&mut self, factor: SupernodalLltRef<'_, u32, f64>, subdomains: Option<[u32; 2]>) {
        let symbolic = factor.symbolic();
        for list in [&mut self.first, &mut self.row_start, &mut self.row] {
            list.clear();
        }
        self.block_start.clear();
        self.block.clear();
        let (mut tallest, mut top) = (0, vec![0.0; self.make_room(factor)]);
        for s in 0..symbolic.n_supernodes() {
            let node = factor.supernode(s);
            let (height, width) = (node.val().nrows(), node.val().ncols());
            self.first.push(node.start() as u32);
            self.row_start.push(self.row.len() as u32);
            self.row.extend_from_slice(node.pattern());
            self.block_start.push(self.block.len());
            self.panel.clear();
            (0..width).for_each(|j| self.panel.extend(node.val().col(j).iter()));
            times_inverse_of_triangle(&mut self.panel, height, width, &mut top);
            for top in (0..height).step_by(LANES) {
                for column in self.panel.chunks_exact(height) {
                    let mut lanes = [0.0; LANES];
                    lanes.iter_mut().zip(&column[top..]).for_each(|(lane, x)| *lane = *x);
                    self.block.push(lanes);
                }
            }
            tallest = tallest.max(height);
        }
        self.first.push(symbolic.ncols() as u32);
        self.row_start.push(self.row.len() as u32);
        self.block_start.push(self.block.len());
        for work in &mut self.work {
            work.resize(tallest.div_ceil(LANES), [0.0; LANES]);
        }
        self.column.resize(symbolic.ncols(), 0.0);
        (self.second, self.separator) =
            subdomains.and_then(|subdomains| self.subdomains(subdomains)).unwrap_or_default();
        let shared = if self.separator > 0 { self.column.len() - self.first[self.separator] as usize } else { 0 };
        self.sums.clear();
        self.sums.resize(shared, 0.0);
    }

    /// The supernodes with which the second subdomain and the separator begin. One with columns of both is taken to the separator.
    fn subdomains(&self, [second, separator]: [u32; 2]) -> Option<(usize, usize)> {
        let second = self.first.binary_search(&second).ok()?;
        let separator = self.first[1..].partition_point(|&end| end <= separator).max(second);
        let (second_column, separator_column) = (self.first[second], self.first[separator]);
        let is_apart = |row: &u32| *row < second_column || *row >= separator_column;
        let is_sorted = |s: usize| self.panel(s).2.is_sorted();
        let rows_of_first = &self.row[..self.row_start[second] as usize];
        ((0..separator).all(is_sorted) && rows_of_first.iter().all(is_apart)).then_some((second, separator))
    }

    /// Makes room for the panels of a factor, which are to be written one after the other. Returns the largest width.
    fn make_room(&mut self, factor: SupernodalLltRef<'_, u32, f64>) -> usize {
        let count = factor.symbolic().n_supernodes();
        let (mut rows, mut blocks, mut largest, mut widest) = (0, 0, 0, 0);
        for panel in (0..count).map(|s| factor.supernode(s).val()) {
            let (height, width) = (panel.nrows(), panel.ncols());
            rows += height - width;
            blocks += height.div_ceil(LANES) * width;
            largest = largest.max(height * width);
            widest = widest.max(width);
        }
        for (list, len) in [(&mut self.first, count + 1), (&mut self.row_start, count + 1), (&mut self.row, rows)] {
            list.reserve_exact(len);
        }
        self.block_start.reserve_exact(count + 1);
        self.block.reserve_exact(blocks);
        self.panel.clear();
        self.panel.reserve_exact(largest);
        widest
    }

    /// Replaces `column` b by L⁻¹·b on the way down, by L⁻ᵀ·b on the way up.
    pub(super) fn sweep(&mut self, is_down: bool) {
        let (mut column, mut sums) = (std::mem::take(&mut self.column), std::mem::take(&mut self.sums));
        let [mut work, mut other_work] = std::mem::take(&mut self.work);
        let Self { second, separator, .. } = *self;
        let start = |s: usize| self.first[s] as usize;
        let sweep = |nodes: Range<usize>, own: &mut [f64], above: &mut [f64], work: &mut [[f64; LANES]]| {
            let (own_start, above_start) = (start(nodes.start), start(nodes.end.max(separator)));
            wide(Sweep { panels: self, nodes, own, own_start, above, above_start, work, is_down });
        };
        let (of_subdomains, of_separator) = column.split_at_mut(start(separator));
        let (of_first, of_second) = of_subdomains.split_at_mut(start(second));
        let all = self.first.len() - 1;
        if !is_down {
            sweep(separator..all, of_separator, &mut [], &mut work);
        }
        if separator > 0 {
            sums.iter_mut().zip(&*of_separator).for_each(|(sum, x)| *sum = if is_down { 0.0 } else { *x });
            let of_second = || sweep(second..separator, of_second, &mut sums, &mut other_work);
            parallel::both(start(separator), || sweep(0..second, of_first, of_separator, &mut work), of_second);
            if is_down {
                of_separator.iter_mut().zip(&sums).for_each(|(x, sum)| *x += *sum);
            }
        }
        if is_down {
            sweep(separator..all, of_separator, &mut [], &mut work);
        }
        (self.column, self.sums, self.work) = (column, sums, [work, other_work]);
    }

    /// First column and width of a supernode, its rows below and its panel.
    #[inline(always)]
    fn panel(&self, s: usize) -> (usize, usize, &[u32], &[[f64; LANES]]) {
        let (first, end) = (self.first[s] as usize, self.first[s + 1] as usize);
        let row = &self.row[self.row_start[s] as usize..self.row_start[s + 1] as usize];
        (first, end - first, row, &self.block[self.block_start[s]..self.block_start[s + 1]])
    }
}

/// A sweep over the panels of some supernodes.
struct Sweep<'a> {
    panels: &'a Panels,
    nodes: Range<usize>,
    /// Columns of the supernodes in the sweep, and which the first of them is.
    own: &'a mut [f64],
    own_start: usize,
    /// Columns of the separator, or the second subdomain's sums for them; the backward sweep only reads them.
    above: &'a mut [f64],
    above_start: usize,
    work: &'a mut [[f64; LANES]],
    is_down: bool,
}

impl NullaryFnOnce for Sweep<'_> {
    type Output = ();

    #[inline(always)]
    fn call(mut self) {
        if self.is_down {
            for s in self.nodes.clone() {
                self.down(s);
            }
        } else {
            for s in self.nodes.clone().rev() {
                self.up(s);
            }
        }
    }
}

impl Sweep<'_> {
    /// x ← T⁻¹·x in the supernode's columns, x ← x − B·T⁻¹·x in its rows below.
    #[inline(always)]
    fn down(&mut self, s: usize) {
        let Self { own, own_start, above, above_start, work, .. } = self;
        let (first, width, row, blocks) = self.panels.panel(s);
        let columns = first - *own_start..first - *own_start + width;
        let (x, out) = (&own[columns.clone()], &mut work[..blocks.len() / width]);
        for (block, out) in blocks.chunks_exact(width).zip(&mut *out) {
            let mut sum = [0.0; LANES];
            for (lanes, &x) in block.iter().zip(x) {
                for l in 0..LANES {
                    sum[l] += lanes[l] * x;
                }
            }
            *out = sum;
        }
        let out = out.as_flattened();
        own[columns].copy_from_slice(&out[..width]);
        // Rows ascend.
        let (row, row_above) = row.split_at(row.partition_point(|&i| (i as usize) < *above_start));
        let (changes, changes_above) = out[width..].split_at(row.len());
        for (&i, &change) in row.iter().zip(changes) {
            own[i as usize - *own_start] -= change;
        }
        for (&i, &change) in row_above.iter().zip(changes_above) {
            above[i as usize - *above_start] -= change;
        }
    }

    /// The transpose of [`down`](Self::down).
    #[inline(always)]
    fn up(&mut self, s: usize) {
        let Self { own, own_start, above, above_start, work, .. } = self;
        let (first, width, row, blocks) = self.panels.panel(s);
        let columns = first - *own_start..first - *own_start + width;
        let input = &mut work[..blocks.len() / width];
        if let Some(last) = input.last_mut() {
            *last = [0.0; LANES];
        }
        let flat = input.as_flattened_mut();
        flat[..width].copy_from_slice(&own[columns.clone()]);
        let (row, row_above) = row.split_at(row.partition_point(|&i| (i as usize) < *above_start));
        let (of_own, of_above) = flat[width..].split_at_mut(row.len());
        for (&i, input) in row.iter().zip(of_own) {
            *input = -own[i as usize - *own_start];
        }
        for (&i, input) in row_above.iter().zip(of_above) {
            *input = -above[i as usize - *above_start];
        }
        let x = &mut own[columns];
        let mut start = 0;
        while start + ABREAST <= width {
            x[start..start + ABREAST].copy_from_slice(&dots::<ABREAST>(blocks, width, start, input));
            start += ABREAST;
        }
        for column in start..width {
            [x[column]] = dots(blocks, width, column, input);
        }
    }
}

/// Columns of a panel that are multiplied side by side, so that their sums do not wait for each other.
const ABREAST: usize = 4;

/// Products of `K` columns of a panel, from `start` on, with a vector.
#[inline(always)]
fn dots<const K: usize>(blocks: &[[f64; LANES]], width: usize, start: usize, input: &[[f64; LANES]]) -> [f64; K] {
    let mut sums = [[0.0; LANES]; K];
    for (block, input) in blocks.chunks_exact(width).zip(input) {
        let block = &block[start..start + K];
        for k in 0..K {
            for l in 0..LANES {
                sums[k][l] += block[k][l] * input[l];
            }
        }
    }
    let mut dots = [0.0; K];
    for (dot, lanes) in dots.iter_mut().zip(&sums) {
        *dot = sum(lanes);
    }
    dots
}

/// The sum of the lanes, halves first.
#[inline(always)]
fn sum(lanes: &[f64; LANES]) -> f64 {
    let mut lanes = *lanes;
    for half in [4, 2, 1] {
        for l in 0..half {
            let other = lanes[l + half];
            lanes[l] += other;
        }
    }
    lanes[0]
}

/// [T; B] ← [T⁻¹; B·T⁻¹] for a panel by columns with a lower triangle T on top; zeros above the diagonal. `top` is scratch of
/// at least the width.
fn times_inverse_of_triangle(panel: &mut [f64], height: usize, width: usize, top: &mut [f64]) {
    // From the last column to the first: column j of P·T = [I; B] gives P_j = ([e_j; B_j] − Σ_{k>j} P_k·T_kj)/T_jj, and the
    // columns k > j are done already.
    let top = &mut top[..width];
    for j in (0..width).rev() {
        let (before, done) = panel.split_at_mut((j + 1) * height);
        let column = &mut before[j * height..];
        let inverse = 1.0 / column[j];
        let (triangle, below) = column.split_at_mut(width);
        top.fill(0.0);
        top[j] = 1.0;
        for k in j + 1..width {
            let factor = triangle[k];
            let done = &done[(k - j - 1) * height..(k - j) * height];
            for i in k..width {
                top[i] -= factor * done[i];
            }
            for (x, d) in below.iter_mut().zip(&done[width..]) {
                *x -= factor * d;
            }
        }
        triangle.iter_mut().zip(&*top).for_each(|(x, t)| *x = t * inverse);
        below.iter_mut().for_each(|x| *x *= inverse);
    }
}

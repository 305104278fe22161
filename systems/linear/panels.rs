//! A Cholesky factor laid out for solving with it: one dense panel of numbers per supernode.
//!
//! A supernode is a run of columns of L with the same rows: a triangle T on the diagonal and a rectangle B under it. Solving
//! with L takes y = T⁻¹·x and subtracts B·y from the rows below; solving with Lᵀ is the transpose of that. Both are products
//! with the one panel P = [T⁻¹; B·T⁻¹], which is therefore what is stored: no chain of dependent divisions is left, and every
//! number is read once on the way down and once on the way up.
//!
//! Single precision halves the memory that a solve waits for and is enough of a preconditioner where inertia holds every
//! vertex. Where nothing may hold a piece of the body, its free motion takes double precision: a rounding error in the forces
//! on it is answered with the inverse of next to nothing.

use crate::systems::kernels::simd::{LANES, NullaryFnOnce, wide};
use faer::sparse::linalg::cholesky::supernodal::SupernodalLltRef;
use std::ops::{AddAssign, Mul, Neg, SubAssign};

/// The numbers of a panel: `f32` or `f64`.
pub trait Real: Copy + Default + AddAssign + SubAssign + Mul<Output = Self> + Neg<Output = Self> + Into<f64> {
    /// The nearest number.
    fn nearest(x: f64) -> Self;
}

impl Real for f32 {
    fn nearest(x: f64) -> Self {
        x as Self
    }
}

impl Real for f64 {
    fn nearest(x: f64) -> Self {
        x
    }
}

/// A factor's panels. The layout of one with `w` columns: blocks of eight rows, in each block the columns one after the other.
#[derive(Debug, Default)]
pub struct Panels<T> {
    /// First column of each supernode, and the number of columns at the end.
    first: Vec<u32>,
    /// Where each supernode's rows below its triangle begin in `row`; one more entry at the end.
    row_start: Vec<u32>,
    row: Vec<u32>,
    /// Where each panel begins in `block`; one more entry at the end.
    block_start: Vec<usize>,
    block: Vec<[T; LANES]>,
    /// A panel's input or output.
    work: Vec<[T; LANES]>,
    /// One number per column: what to solve for, then the answer.
    pub column: Vec<T>,
    /// The panel at hand, by columns.
    panel: Vec<f64>,
}

impl<T: Real> Panels<T> {
    /// Takes over a factor.
    pub fn fill(&mut self, factor: SupernodalLltRef<'_, u32, f64>) {
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
                    let mut lanes = [T::default(); LANES];
                    lanes.iter_mut().zip(&column[top..]).for_each(|(lane, x)| *lane = T::nearest(*x));
                    self.block.push(lanes);
                }
            }
            tallest = tallest.max(height);
        }
        self.first.push(symbolic.ncols() as u32);
        self.row_start.push(self.row.len() as u32);
        self.block_start.push(self.block.len());
        self.work.resize(tallest.div_ceil(LANES), [T::default(); LANES]);
        self.column.resize(symbolic.ncols(), T::default());
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

    /// Replaces `column` by L⁻¹ times it, the way down of a solve; returns the scalar product of what it was with (L·Lᵀ)⁻¹ times it,
    /// which is the squared norm of what it is now.
    pub fn descend(&mut self) -> f64 {
        self.sweep(true);
        let mut sums = [0.0; LANES];
        for (i, &x) in self.column.iter().enumerate() {
            let x: f64 = x.into();
            sums[i % LANES] += x * x;
        }
        sums.iter().sum()
    }

    /// Replaces `column` by L⁻ᵀ times it, the way up.
    pub fn ascend(&mut self) {
        self.sweep(false);
    }

    fn sweep(&mut self, is_down: bool) {
        let (mut work, mut column) = (std::mem::take(&mut self.work), std::mem::take(&mut self.column));
        wide(Sweep { panels: self, column: &mut column, work: &mut work, is_down });
        (self.work, self.column) = (work, column);
    }

    /// First column and width of a supernode, its rows below and its panel.
    #[inline(always)]
    fn panel(&self, s: usize) -> (usize, usize, &[u32], &[[T; LANES]]) {
        let (first, end) = (self.first[s] as usize, self.first[s + 1] as usize);
        let row = &self.row[self.row_start[s] as usize..self.row_start[s + 1] as usize];
        (first, end - first, row, &self.block[self.block_start[s]..self.block_start[s + 1]])
    }

    /// x ← T⁻¹·x in the supernode's columns, x ← x − B·T⁻¹·x in its rows below.
    #[inline(always)]
    fn down(&self, s: usize, x: &mut [T], work: &mut [[T; LANES]]) {
        let (first, width, row, blocks) = self.panel(s);
        let (columns, out) = (&x[first..first + width], &mut work[..blocks.len() / width]);
        for (block, out) in blocks.chunks_exact(width).zip(&mut *out) {
            let mut sum = [T::default(); LANES];
            for (lanes, &x) in block.iter().zip(columns) {
                for l in 0..LANES {
                    sum[l] += lanes[l] * x;
                }
            }
            *out = sum;
        }
        let out = out.as_flattened();
        x[first..first + width].copy_from_slice(&out[..width]);
        for (&i, &change) in row.iter().zip(&out[width..]) {
            x[i as usize] -= change;
        }
    }

    /// The transpose of [`down`](Self::down).
    #[inline(always)]
    fn up(&self, s: usize, x: &mut [T], work: &mut [[T; LANES]]) {
        let (first, width, row, blocks) = self.panel(s);
        let input = &mut work[..blocks.len() / width];
        if let Some(last) = input.last_mut() {
            *last = [T::default(); LANES];
        }
        let flat = input.as_flattened_mut();
        flat[..width].copy_from_slice(&x[first..first + width]);
        for (&i, input) in row.iter().zip(&mut flat[width..]) {
            *input = -x[i as usize];
        }
        let columns = &mut x[first..first + width];
        let mut start = 0;
        while start + ABREAST <= width {
            columns[start..start + ABREAST].copy_from_slice(&dots::<T, ABREAST>(blocks, width, start, input));
            start += ABREAST;
        }
        for column in start..width {
            [columns[column]] = dots(blocks, width, column, input);
        }
    }
}

/// A sweep over all panels.
struct Sweep<'a, T> {
    panels: &'a Panels<T>,
    column: &'a mut [T],
    work: &'a mut [[T; LANES]],
    is_down: bool,
}

impl<T: Real> NullaryFnOnce for Sweep<'_, T> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { panels, column, work, is_down } = self;
        let count = panels.first.len() - 1;
        if is_down {
            for s in 0..count {
                panels.down(s, column, work);
            }
        } else {
            for s in (0..count).rev() {
                panels.up(s, column, work);
            }
        }
    }
}

/// Columns of a panel that are multiplied side by side, so that their sums do not wait for each other.
const ABREAST: usize = 4;

/// Products of `K` columns of a panel, from `start` on, with a vector.
#[inline(always)]
fn dots<T: Real, const K: usize>(blocks: &[[T; LANES]], width: usize, start: usize, input: &[[T; LANES]]) -> [T; K] {
    let mut sums = [[T::default(); LANES]; K];
    for (block, input) in blocks.chunks_exact(width).zip(input) {
        let block = &block[start..start + K];
        for k in 0..K {
            for l in 0..LANES {
                sums[k][l] += block[k][l] * input[l];
            }
        }
    }
    let mut dots = [T::default(); K];
    for (dot, lanes) in dots.iter_mut().zip(&sums) {
        *dot = sum(lanes);
    }
    dots
}

/// The sum of the lanes, halves first.
#[inline(always)]
fn sum<T: Real>(lanes: &[T; LANES]) -> T {
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

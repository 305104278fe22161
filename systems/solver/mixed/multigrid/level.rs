//! One level: a symmetric operator in rows of blocks, and its Gauss–Seidel sweeps.
//!
//! A forward sweep from zero leaves the residual −U·x, for the blocks U above the diagonal: the first half of a cycle reads every
//! block once, and so does the backward sweep that ends it. One is the adjoint of the other, and either converges for any
//! symmetric positive matrix: so the cycle is symmetric and positive, whatever the coarser levels are the Galerkin operators of.

use super::super::empty;
use super::super::matrix::dot;
use super::super::pattern::BlockPattern;
use super::interpolation::Place;
use super::marks::Marks;
use super::numbering::Numbering;
use crate::systems::kernels::block::{self, Block};
use crate::systems::kernels::factor_block::FactorBlock;
use crate::systems::kernels::flat_block::{Coefficient, FlatBlock};
use crate::systems::kernels::lanes::Lanes;
use crate::systems::kernels::simd::Kernel;
use crate::systems::parallel;
use glam::Vec4;

/// No axis prescribed.
pub(super) const FREE: Vec4 = Vec4::new(1.0, 1.0, 1.0, 0.0);

/// The numbers of a level. Rows and columns of prescribed axes are zero.
#[derive(Debug, Default)]
pub(super) struct Level {
    /// The order of the rows.
    pub numbering: Numbering,
    /// Where the blocks stand.
    pub pattern: BlockPattern,
    /// Blocks on the diagonal \[N/mm\].
    pub diagonal: Vec<Block>,
    /// Blocks below it.
    pub lower: Vec<Block>,
    /// Free axes (1) of every row.
    pub free: Vec<Vec4>,
    /// Where the rows are on the rest surface, and whether at its boundary.
    pub places: Vec<Place>,
    pub is_boundary: Vec<bool>,
    /// Numbers read by the sweeps of a body in space, or of one in a plane.
    pub(super) solid: Sweeps<Block>,
    pub(super) flat: Sweeps<FlatBlock>,
    pub(super) is_flat: bool,
}

/// Numbers read by the sweeps.
#[derive(Debug, Default)]
pub(super) struct Sweeps<B> {
    /// Blocks below the diagonal, where they are not the level's own.
    lower: Vec<B>,
    /// Blocks above it: the transposes.
    upper: Vec<B>,
    /// Inverses of those on the diagonal \[mm/N\].
    inverse: Vec<B>,
}

/// Vectors of a level.
#[derive(Debug, Default)]
pub(super) struct Vectors {
    /// Right-hand side, where it is not the solver's \[N\].
    pub r: Vec<Vec4>,
    /// Answer \[mm\].
    pub x: Vec<Vec4>,
    /// Residual that the forward sweep leaves of the right-hand side \[N\].
    pub left: Vec<Vec4>,
    /// Correction that the sweep of a second cycle adds to the answer of the first \[mm\].
    pub change: Vec<Vec4>,
}

/// Parts of its trace by which a block is raised that is not positive, the least that will do.
const RAISES: [f32; 4] = [1e-6, 1e-4, 1e-2, 1.0];

impl Level {
    /// Zeroes prescribed rows and columns, makes the diagonal invertible and inverts it, mirrors the rest.
    pub(super) fn finish(&mut self) {
        let Self { pattern, diagonal, lower, free, solid, flat, is_flat, .. } = self;
        parallel::for_rows(diagonal, |row, diagonal| {
            let own = block::mask(diagonal, free[row], free[row]);
            let trace = own[0].x + own[1].y + own[2].z;
            let unit = block::mask(&[Vec4::X, Vec4::Y, Vec4::Z], free[row], free[row]);
            let mut raised = RAISES.iter().map(|part| block::sum(&own, &unit, part * trace));
            let is_positive = |block: &Block| block::invert(block, free[row]).is_some();
            // All of the cycle takes the raised block for the operator's: its levels are still those of one operator.
            *diagonal = if is_positive(&own) { own } else { raised.find(is_positive).unwrap_or(block::ZERO) };
        });
        let inverse = |row: usize| block::invert(&diagonal[row], free[row]).unwrap_or(block::ZERO);
        if free.iter().any(|free| *free != FREE) {
            for row in 0..diagonal.len() {
                for k in pattern.before(row) {
                    lower[k] = block::mask(&lower[k], free[row], free[pattern.column[k] as usize]);
                }
            }
        }
        *is_flat = free.iter().all(|free| free.z == 0.0);
        if *is_flat {
            flat.fill(
                diagonal.len(),
                lower.len(),
                |row| FlatBlock::of(&inverse(row)),
                |i| FlatBlock::of(&lower[pattern.below[i][1] as usize]).transposed(),
            );
            empty(&mut flat.lower, lower.len());
            flat.lower.resize(lower.len(), FlatBlock::default());
            parallel::for_rows(&mut flat.lower, |i, block| *block = FlatBlock::of(&lower[i]));
        } else {
            solid
                .fill(diagonal.len(), lower.len(), inverse, |i| block::transpose(&lower[pattern.below[i][1] as usize]));
        }
    }

    /// x = (D + L)⁻¹·r; returns x·D·x.
    pub(super) fn forward(&self, x: &mut [Vec4], partials: &mut Vec<f64>, r: impl Fn(usize) -> Vec4 + Sync) -> f64 {
        if self.is_flat {
            return self.forward_with((&self.flat.lower, &self.flat), x, partials, r);
        }
        self.forward_with((&self.lower, &self.solid), x, partials, r)
    }

    fn forward_with<B: Coefficient>(
        &self,
        (lower, sweeps): (&[B], &Sweeps<B>),
        x: &mut [Vec4],
        partials: &mut Vec<f64>,
        r: impl Fn(usize) -> Vec4 + Sync,
    ) -> f64 {
        let blocks = Blocks { level: self, lower, sweeps };
        let size = self.numbering.size();
        let [first, second, added] = self.numbering.split(x);
        let of_first = parallel::sum_pieces(first, size, partials, &Forward { blocks, offset: 0, other: &[], r: &r });
        let offset = first.len();
        let of_second = parallel::sum_pieces(second, size, partials, &Forward { blocks, offset, other: first, r: &r });
        if added.is_empty() {
            return of_first + of_second;
        }
        let (offset, size) = (offset + second.len(), added.len());
        let (before, added) = x.split_at_mut(offset);
        of_first
            + of_second
            + parallel::sum_pieces(added, size, partials, &Forward { blocks, offset, other: before, r: &r })
    }

    /// Copies the places of its rows from the finer level; `rows` has the finer row of each.
    pub(super) fn copy_places(&mut self, fine: &Self, rows: &[u32]) {
        empty(&mut self.places, rows.len());
        self.places.extend(rows.iter().map(|&row| fine.places[row as usize]));
        empty(&mut self.is_boundary, rows.len());
        self.is_boundary.extend(rows.iter().map(|&row| fine.is_boundary[row as usize]));
    }

    /// Whether sweeps allow for the blocks of the rows that are marked.
    pub(super) fn is_in_order(&self, marks: &Marks) -> bool {
        let rows = (0..self.pattern.row_count()).filter(|&row| marks.is_any(row));
        let mut blocks =
            rows.flat_map(|row| self.pattern.before(row).map(move |k| (row as u32, self.pattern.column[k])));
        blocks.all(|(row, column)| self.numbering.may_meet(row, column))
    }

    /// `left` = −U·x, which is the residual r − A·x after [`Level::forward`].
    pub(super) fn subtract(&self, x: &[Vec4], left: &mut [Vec4]) {
        if self.is_flat {
            parallel::for_chunks(left, &Subtract { level: self, upper: &self.flat.upper, x });
        } else {
            parallel::for_chunks(left, &Subtract { level: self, upper: &self.solid.upper, x });
        }
    }

    /// x = (D + U)⁻¹·(r − L·x).
    pub(super) fn backward(&self, x: &mut [Vec4], r: impl Fn(usize) -> Vec4 + Sync) {
        if self.is_flat {
            return self.backward_with((&self.flat.lower, &self.flat), x, r);
        }
        self.backward_with((&self.lower, &self.solid), x, r);
    }

    fn backward_with<B: Coefficient>(
        &self,
        (lower, sweeps): (&[B], &Sweeps<B>),
        x: &mut [Vec4],
        r: impl Fn(usize) -> Vec4 + Sync,
    ) {
        let blocks = Blocks { level: self, lower, sweeps };
        let size = self.numbering.size();
        let [first, second, added] = self.numbering.split(x).map(|rows| rows.len());
        if added > 0 {
            let (before, rows) = x.split_at_mut(first + second);
            let offset = before.len();
            parallel::for_pieces(rows, added, &Backward { blocks, offset, before, after: (&[], 0), r: &r });
        }
        let [of_first, of_second, of_added] = self.numbering.split(x);
        let after = (&*of_added, first + second);
        parallel::for_pieces(of_second, size, &Backward { blocks, offset: first, before: of_first, after, r: &r });
        let (of_first, others) = x.split_at_mut(first);
        let after = (&*others, first);
        parallel::for_pieces(of_first, size, &Backward { blocks, offset: 0, before: &[], after, r: &r });
    }
}

impl<B: Send> Sweeps<B> {
    /// Fills all but `lower`: inverses by rows, and the blocks above the diagonal.
    fn fill(
        &mut self,
        row_count: usize,
        block_count: usize,
        inverse: impl Fn(usize) -> B + Sync,
        upper: impl Fn(usize) -> B + Sync,
    ) where
        B: Default + Clone,
    {
        empty(&mut self.inverse, row_count);
        self.inverse.resize(row_count, B::default());
        parallel::for_rows(&mut self.inverse, |row, block| *block = inverse(row));
        empty(&mut self.upper, block_count);
        self.upper.resize(block_count, B::default());
        parallel::for_rows(&mut self.upper, |i, block| *block = upper(i));
    }
}

/// The blocks of a level, of either kind.
#[derive(Clone, Copy)]
struct Blocks<'a, B> {
    level: &'a Level,
    lower: &'a [B],
    sweeps: &'a Sweeps<B>,
}

impl<B: Coefficient> Blocks<'_, B> {
    /// `y` less the products of the columns before a row: those before the piece that begins at `start` are of the other colour.
    #[inline(always)]
    fn subtract_before(&self, mut y: Vec4, row: usize, start: usize, other: &[Vec4], x: &[Vec4]) -> Vec4 {
        let pattern = &self.level.pattern;
        let blocks = pattern.before(row);
        for (l, &column) in self.lower[blocks.clone()].iter().zip(&pattern.column[blocks]) {
            let column = column as usize;
            y -= l.times(if column < start { other[column] } else { x[column - start] });
        }
        y
    }
}

/// A forward sweep over a chunk.
struct Forward<'a, B, R> {
    blocks: Blocks<'a, B>,
    /// First row of the colour.
    offset: usize,
    /// The colour before this one.
    other: &'a [Vec4],
    r: &'a R,
}

impl<B: Coefficient, R: Fn(usize) -> Vec4 + Sync> Kernel<Vec4, f64> for Forward<'_, B, R> {
    #[inline(always)]
    fn run<L: Lanes>(&self, _: L, first: usize, x: &mut [Vec4]) -> f64 {
        let Self { blocks, offset, other, r } = self;
        let start = offset + first;
        let mut product = 0.0;
        for i in 0..x.len() {
            let row = start + i;
            let y = blocks.subtract_before(r(row), row, start, other, x);
            x[i] = B::only_axes(blocks.sweeps.inverse[row].times(y));
            product += dot(x[i], y);
        }
        product
    }
}

/// Residual −U·x that a forward sweep leaves.
struct Subtract<'a, B> {
    level: &'a Level,
    upper: &'a [B],
    x: &'a [Vec4],
}

impl<B: Coefficient> Kernel<Vec4> for Subtract<'_, B> {
    #[inline(always)]
    fn run<L: Lanes>(&self, _: L, first: usize, left: &mut [Vec4]) {
        let pattern = &self.level.pattern;
        for (i, left) in left.iter_mut().enumerate() {
            let blocks = pattern.after(first + i);
            let mut y = Vec4::ZERO;
            for (u, &[column, _]) in self.upper[blocks.clone()].iter().zip(&pattern.below[blocks]) {
                y -= u.times(self.x[column as usize]);
            }
            *left = B::only_axes(y);
        }
    }
}

/// A backward sweep over a chunk.
struct Backward<'a, B, R> {
    blocks: Blocks<'a, B>,
    /// First row of the colour.
    offset: usize,
    /// The rows before it.
    before: &'a [Vec4],
    /// The rows after it, and the first of them.
    after: (&'a [Vec4], usize),
    r: &'a R,
}

impl<B: Coefficient, R: Fn(usize) -> Vec4 + Sync> Kernel<Vec4> for Backward<'_, B, R> {
    #[inline(always)]
    fn run<L: Lanes>(&self, _: L, first: usize, x: &mut [Vec4]) {
        let Self { blocks, offset, before, after: (others, others_start), r } = self;
        let (Level { pattern, .. }, Sweeps { upper, inverse, .. }) = (blocks.level, blocks.sweeps);
        let start = offset + first;
        for i in (0..x.len()).rev() {
            let row = start + i;
            let mut y = blocks.subtract_before(r(row), row, start, before, x);
            let after = pattern.after(row);
            let end = start + x.len();
            for (u, &[column, _]) in upper[after.clone()].iter().zip(&pattern.below[after]) {
                let column = column as usize;
                let value = if column < end { x[column - start] } else { others[column - others_start] };
                y -= u.times(value);
            }
            x[i] = B::only_axes(inverse[row].times(y));
        }
    }
}

//! Incomplete Cholesky factor M = L·D·Lᵀ with the fill of level one, by 3×3 blocks, in a plane by 2×2. L has the pattern of A and
//! the entries that eliminating one row of A puts between its later neighbours (Meijerink, van der Vorst 1977; levels: Watts 1981).
//!
//! A body torn, bent and partly slack has stiff and soft directions side by side, and changes from step to step. So the factor is
//! made anew for every solve, which costs as much as a few iterations and saves three out of four of them. Both sweeps are serial
//! by nature; rows of one level do not need each other and stand together (see [`super::order`]), so that the processor works on
//! several at a time. The sweeps take the blocks of a row two by two.
//!
//! Where a [`Dissection`] splits the rows, two threads gather, factor and sweep the two subdomains side by side. Each has the
//! triangles and rows that it has in products too. The separator follows, or comes first on the way up.

mod sweeps;

use super::adjacency::Adjacency;
use super::dissection::Dissection;
use super::edits::Edits;
use super::empty;
use super::matrix::{Matrix, OfPacks};
use super::order::Order;
use super::partition::Partition;
use super::pattern::BlockPattern;
use crate::storage::Topology;
use crate::systems::kernels::block::Block;
use crate::systems::kernels::factor_block::FactorBlock;
use crate::systems::kernels::flat_block::FlatBlock;
use crate::systems::kernels::simd::{NullaryFnOnce, wide};
use crate::systems::parallel;
use std::ops::Range;

/// The factor.
#[derive(Debug)]
pub(super) struct Incomplete {
    /// Where the blocks stand.
    pattern: BlockPattern,
    /// Numbers of the factor for a body in space, or for one in a plane.
    solid: Numbers<Block>,
    flat: Numbers<FlatBlock>,
    is_flat: bool,
    /// The largest entry of A on its diagonal \[N/mm\].
    pub stiffest: f32,
    /// Rows that do not need each other.
    dissection: Dissection,
}

/// The numbers of a factor.
#[derive(Debug)]
struct Numbers<B: FactorBlock> {
    /// Blocks of L, two by two.
    lower: Vec<B::Pair>,
    /// Diagonal blocks of A, then the inverses of those of D.
    inverse: Vec<B>,
    /// Blocks of L·D in the row at hand, for each of two threads.
    row: [Vec<B>; 2],
    /// Contributions of the triangles of the second subdomain to the rows of the separator: to its diagonal blocks, and to those below.
    share: (Vec<B>, Vec<B::Pair>),
}

impl<B: FactorBlock> Default for Numbers<B> {
    fn default() -> Self {
        Self { lower: Vec::new(), inverse: Vec::new(), row: Default::default(), share: Default::default() }
    }
}

impl Default for Incomplete {
    fn default() -> Self {
        let (solid, flat) = (Numbers::default(), Numbers::default());
        let dissection = Dissection::default();
        Self { pattern: BlockPattern::filled(), solid, flat, is_flat: false, stiffest: 0.0, dissection }
    }
}

/// A pivot is to be at least this part of the body's own diagonal block, as quadratic forms: below, the fill that is left out
/// has used it up. (A direction that is soft in the block itself may be as soft in the pivot.)
const LEAST_PART: f32 = 0.1;

/// Parts of its own block by which a pivot that has been used up is raised, the least that will do.
const REPAIRS: [f32; 3] = [0.1, 0.3, 1.0];

/// Blocks of a row for which scratch has room from the start: vertices have some six neighbours, of which half come before.
const LONGEST_ROW: usize = 64;

impl Incomplete {
    /// Finds the pattern anew.
    pub(super) fn rebuild(
        &mut self,
        partition: &Partition,
        order: &Order,
        corners: &[[u32; 3]],
        adjacency: &Adjacency,
    ) {
        self.pattern.rebuild(partition, (&order.vertex, &order.row), corners, |v| adjacency.of(v));
    }

    /// The lists of its pattern that only edits use.
    pub(super) fn spare_lists(&mut self) -> [&mut Vec<u32>; 2] {
        self.pattern.spare_lists()
    }

    /// Brings the pattern up to date after edits.
    pub(super) fn follow(
        &mut self,
        partition: &Partition,
        order: &Order,
        corners: &[[u32; 3]],
        topology: &Topology,
        edits: &Edits,
    ) {
        let stays = |row: usize| !edits.is_touched[row];
        self.pattern.follow(partition, (&order.vertex, &order.row), corners, topology, edits, stays);
    }

    /// Factors the operator with its diagonal raised by a fraction `shift` of itself (Manteuffel 1980).
    pub(super) fn factor(&mut self, partition: &Partition, dissection: Dissection, matrix: &Matrix, shift: f32) {
        (self.is_flat, self.dissection) = (matrix.is_flat, dissection);
        self.stiffest = if self.is_flat {
            self.flat.factor(&self.pattern, (partition, dissection), matrix, shift)
        } else {
            self.solid.factor(&self.pattern, (partition, dissection), matrix, shift)
        };
    }
}

impl<B: OfPacks> Numbers<B> {
    /// Factors the operator and returns the largest entry on its diagonal \[N/mm\].
    fn factor(
        &mut self,
        pattern: &BlockPattern,
        (partition, dissection): (&Partition, Dissection),
        matrix: &Matrix,
        shift: f32,
    ) -> f32 {
        self.gather(pattern, (partition, dissection), matrix);
        let stiffest = self.inverse.iter().map(B::largest).fold(0.0, f32::max);
        let Self { lower, inverse, row: [scratch, other_scratch], .. } = self;
        let parts = dissection.ranges(inverse.len());
        let eliminate = |part: usize, first: usize, numbers: (&mut [B::Pair], &mut [B]), row: &mut Vec<B>| {
            let (lower, inverse) = numbers;
            let rows = parts[part].clone();
            wide(Elimination { pattern, matrix, shift, rows, first, lower, inverse, row });
        };
        if dissection.are_cut() {
            let [lower, other_lower, _] = split_blocks(lower, pattern, dissection);
            let [inverse, other_inverse, _] = dissection.split(inverse);
            parallel::both(
                matrix.vertex_blocks.row_count(),
                || eliminate(0, 0, (lower, inverse), scratch),
                || eliminate(1, parts[1].start, (other_lower, other_inverse), other_scratch),
            );
        }
        eliminate(2, 0, (lower, inverse), scratch);
        stiffest
    }

    /// Takes the blocks of A.
    fn gather(&mut self, pattern: &BlockPattern, (partition, dissection): (&Partition, Dissection), matrix: &Matrix) {
        let Self { lower, inverse, share: (share, lower_share), .. } = self;
        let (rows, separator) = (matrix.vertex_blocks.row_count(), dissection.separator as usize);
        empty(lower, pattern.column.len() / 2);
        lower.resize(pattern.column.len() / 2, B::NO_PAIR);
        empty(inverse, rows);
        inverse.resize(rows, B::ZERO);
        parallel::for_rows(inverse, |row, block| *block = B::own(matrix, row));
        if !dissection.are_cut() {
            let none = Blocks { first: 0, diagonal: &mut [], lower: &mut [] };
            let all = Blocks { first: 0, diagonal: inverse, lower };
            return gather_subdomain(pattern, (partition, partition.all_blocks()), matrix, none, all, 0);
        }
        let [first, second] = partition.blocks_of_subdomains(dissection.cut);
        let [lower, other_lower, lower_of_separator] = split_blocks(lower, pattern, dissection);
        let [diagonal, other_diagonal, diagonal_of_separator] = dissection.split(inverse);
        empty(share, diagonal_of_separator.len());
        share.resize(diagonal_of_separator.len(), B::ZERO);
        empty(lower_share, lower_of_separator.len());
        lower_share.resize(lower_of_separator.len(), B::NO_PAIR);
        {
            let of_first = Blocks { first: 0, diagonal, lower };
            let of_second = Blocks { first: dissection.second as usize, diagonal: other_diagonal, lower: other_lower };
            let of_separator =
                Blocks { first: separator, diagonal: &mut *diagonal_of_separator, lower: &mut *lower_of_separator };
            let shares = Blocks { first: separator, diagonal: &mut *share, lower: &mut *lower_share };
            let (mut first, mut second) = (Some((first, of_first, of_separator)), Some((second, of_second, shares)));
            let gather = |half: &mut Option<(Range<usize>, Blocks<B>, Blocks<B>)>| {
                if let Some((blocks, own, of_separator)) = half.take() {
                    gather_subdomain(pattern, (partition, blocks), matrix, own, of_separator, separator);
                }
            };
            parallel::both(rows, || gather(&mut first), || gather(&mut second));
        }
        diagonal_of_separator.iter_mut().zip(&*share).for_each(|(block, share)| block.add(share));
        for k in 0..2 * lower_share.len() {
            B::add_to(lower_of_separator, k, &B::get(lower_share, k));
        }
    }
}

/// The blocks below the diagonal of the two subdomains and of the separator.
fn split_blocks<'a, T>(lower: &'a mut [T], pattern: &BlockPattern, dissection: Dissection) -> [&'a mut [T]; 3] {
    // Rows begin with a pair.
    let start = |row: u32| pattern.row_start[row as usize] as usize / 2;
    let (parts, separator) = lower.split_at_mut(start(dissection.separator));
    let (first, second) = parts.split_at_mut(start(dissection.second));
    [first, second, separator]
}

/// Blocks of some rows, on the diagonal and below it.
struct Blocks<'a, B: FactorBlock> {
    /// The first of the rows.
    first: usize,
    diagonal: &'a mut [B],
    lower: &'a mut [B::Pair],
}

/// Adds the triangles of some of the partition's blocks to the rows of their subdomain, and to the separator, which begins with row
/// `separator`.
fn gather_subdomain<B: OfPacks>(
    pattern: &BlockPattern,
    triangles: (&Partition, Range<usize>),
    matrix: &Matrix,
    own: Blocks<B>,
    of_separator: Blocks<B>,
    separator: usize,
) {
    let start = |blocks: &Blocks<B>| pattern.row_start[blocks.first] as usize;
    let (own_start, separator_start) = (start(&own), start(&of_separator));
    let (diagonal, diagonal_of_separator) = (own.diagonal, of_separator.diagonal);
    pattern.gather(
        triangles,
        matrix,
        |row| row,
        #[inline(always)]
        |row, block| match row.checked_sub(separator) {
            Some(row) => diagonal_of_separator[row].add(block),
            None => diagonal[row - own.first].add(block),
        },
        #[inline(always)]
        |row, place, block| {
            if row >= separator {
                B::add_to(of_separator.lower, place - separator_start, block);
            } else {
                B::add_to(own.lower, place - own_start, block);
            }
        },
    );
}

/// The elimination of some rows.
struct Elimination<'a, B: FactorBlock> {
    pattern: &'a BlockPattern,
    matrix: &'a Matrix,
    shift: f32,
    rows: Range<usize>,
    /// The first of the rows whose blocks are here.
    first: usize,
    lower: &'a mut [B::Pair],
    inverse: &'a mut [B],
    row: &'a mut Vec<B>,
}

impl<B: FactorBlock> NullaryFnOnce for Elimination<'_, B> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { pattern, matrix, shift, rows, first, lower, inverse, row } = self;
        let first_block = pattern.row_start[first] as usize;
        row.clear();
        row.reserve(LONGEST_ROW);
        for i in rows {
            let (start, end) = (pattern.row_start[i] as usize, pattern.row_start[i + 1] as usize);
            let free = matrix.vertex_blocks.free(i);
            let own = inverse[i - first].masked(free, free).scaled(1.0 + shift);
            let mut diagonal = own;
            row.clear();
            for k in start..end {
                let column = pattern.column[k] as usize;
                if column == i {
                    // There for the length to be even.
                    break;
                }
                let mut w = B::get(lower, k - first_block).masked(free, matrix.vertex_blocks.free(column));
                let mut other = pattern.row_start[column] as usize;
                let other_end = pattern.row_start[column + 1] as usize;
                // Both rows ascend.
                for j in start..k {
                    while other < other_end && pattern.column[other] < pattern.column[j] {
                        other += 1;
                    }
                    if other < other_end && pattern.column[other] == pattern.column[j] {
                        w.subtract_product_transposed(&row[j - start], &B::get(lower, other - first_block));
                    }
                }
                let l = w.product(&inverse[column - first]);
                diagonal.subtract_product_transposed(&w, &l);
                B::set(lower, k - first_block, &l);
                row.push(w);
            }
            let is_sound = |d: &B| d.plus(&own, -LEAST_PART).is_positive(free);
            if !is_sound(&diagonal) {
                let mut repaired = REPAIRS.iter().map(|&part| diagonal.plus(&own, part));
                diagonal = repaired.find(is_sound).unwrap_or(own);
            }
            inverse[i - first] = diagonal.inverted(free).unwrap_or_else(|| own.inverted_alone(free));
        }
    }
}

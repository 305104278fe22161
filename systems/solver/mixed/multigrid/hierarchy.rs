//! The levels, the finest first: how they are found, take an operator's numbers, and are cycled through.

use super::super::adjacency::neighbours;
use super::super::empty;
use super::super::matrix::{Matrix, OfPacks, dot};
use super::super::order::Order;
use super::super::partition::Partition;
use super::super::pattern::BlockPattern;
use super::coarsest::Coarsest;
use super::galerkin;
use super::interpolation::{self, Place};
use super::level::{Level, Vectors};
use super::marks::{Mark, Marks};
use super::numbering::Numbering;
use super::transfer::Transfer;
use crate::storage::{Topology, Triangles, Vertices};
use crate::systems::kernels::block::{self, Block};
use crate::systems::parallel;
use glam::{DVec3, Vec4};

/// Nodes of the coarsest level at the most: its dense factor then takes less than a millisecond.
pub(super) const MOST_COARSEST: usize = 40;

/// First level that is cycled twice; it and the coarser ones are a fiftieth of the finest. A sheet of 1.5 million triangles with stiff
/// fibres then takes five iterations to 1e-3 instead of six (`rhexis bench targets --full "static linear"`).
const TWICE: usize = 3;

/// A level's own right-hand side.
const OWN: Option<&fn(usize) -> Vec4> = None;

/// A coarser level with more than this part of its nodes is not worth having: many pieces, each down to its last nodes.
pub(super) const MOST_COARSE_SHARE: f64 = 0.7;

/// The levels of a body.
#[derive(Debug, Default)]
pub(super) struct Hierarchy {
    pub(super) levels: Vec<Level>,
    vectors: Vec<Vectors>,
    /// From every level to the next.
    pub(super) transfers: Vec<Transfer>,
    coarsest: Coarsest,
    partials: Vec<f64>,
    /// Vertex of every row of the finest level, and row of every vertex.
    pub(super) vertex: Vec<u32>,
    pub(super) row: Vec<u32>,
    /// Room for the pattern of a level before it is numbered.
    by_place: BlockPattern,
    /// Whether there is more than the choice of nodes.
    pub(super) is_made: bool,
    /// Scratch of edits: marks on a level and on the next.
    pub(super) marks: Marks,
    pub(super) next_marks: Marks,
}

impl Hierarchy {
    /// Finds levels, weights and patterns anew.
    pub(super) fn rebuild(
        &mut self,
        partition: &Partition,
        order: &Order,
        (vertices, triangles, topology): (&Vertices, &Triangles, &Topology),
    ) {
        let (corners, n) = (&triangles.corners, order.vertex.len());
        let width = |c: &[u32; 3]| {
            let [a, b, c] = c.map(|v| order.row[v as usize]);
            a.max(b).max(c) - a.min(b).min(c)
        };
        if self.levels.is_empty() {
            self.levels.push(Level::default());
        }
        self.levels[0].numbering = Numbering::of_width(n, corners.iter().map(width).max().unwrap_or(0));
        self.number(order);
        let near = |v: u32| neighbours(v, corners, topology);
        self.levels[0].pattern.rebuild(partition, (&self.vertex, &self.row), corners, near);
        self.levels[0].pattern.finish();
        self.marks.clear(n);
        self.find_places((vertices, triangles, topology));
        let mut count = 1;
        while self.levels[count - 1].pattern.row_count() > MOST_COARSEST && self.coarsen(count) {
            count += 1;
        }
        self.levels.truncate(count);
        self.transfers.truncate(count - 1);
        self.is_made = true;
        self.fit_vectors();
    }

    /// Gives the vertices their rows on the finest level, whose numbering stands.
    pub(super) fn number(&mut self, order: &Order) {
        let numbering = self.levels[0].numbering;
        for list in [&mut self.vertex, &mut self.row] {
            empty(list, order.vertex.len());
        }
        self.vertex.extend((0..order.vertex.len() as u32).map(|row| order.vertex[numbering.place(row) as usize]));
        self.row.extend(order.row.iter().map(|&place| numbering.row(place)));
    }

    /// Finds where the rows of the finest level are on the rest surface; marks those that were elsewhere.
    pub(super) fn find_places(&mut self, (vertices, triangles, topology): (&Vertices, &Triangles, &Topology)) {
        let Self { levels, marks, vertex, .. } = self;
        let (vertex, Level { places, is_boundary, .. }) = (&*vertex, &mut levels[0]);
        places.resize(vertex.len(), Place::default());
        let place = |row: usize| {
            let v = vertex[row] as usize;
            let normal = |&entry: &u32| {
                let [a, b, c] = triangles.corners[entry as usize / 3].map(|v| vertices.rest_position[v as usize]);
                (b - a).cross(c - a)
            };
            let normal: DVec3 = topology.incident[v].iter().map(normal).sum();
            Place { position: vertices.rest_position[v], normal: normal.normalize_or(DVec3::Z) }
        };
        parallel::for_pairs(places, marks.as_mut_slice(), |first, places, marks| {
            for (i, (before, mark)) in places.iter_mut().zip(marks).enumerate() {
                let place = place(first + i);
                if std::mem::replace(before, place) != place {
                    mark.add(Mark::STALE);
                }
            }
        });
        empty(is_boundary, vertex.len());
        is_boundary.extend(vertex.iter().map(|&v| topology.is_boundary_vertex(v)));
    }

    /// Gives the vectors of all levels their lengths.
    pub(super) fn fit_vectors(&mut self) {
        self.vectors.resize_with(self.levels.len(), Vectors::default);
        for (vectors, level) in self.vectors.iter_mut().zip(&self.levels) {
            for vector in [&mut vectors.r, &mut vectors.x, &mut vectors.left] {
                empty(vector, level.pattern.row_count());
                vector.resize(level.pattern.row_count(), Vec4::ZERO);
            }
        }
    }

    /// Finds the level `count`; returns whether it is worth having.
    fn coarsen(&mut self, count: usize) -> bool {
        if self.transfers.len() < count {
            self.transfers.push(Transfer::default());
            self.levels.push(Level::default());
        }
        let transfer = &mut self.transfers[count - 1];
        let (fine, coarse) = self.levels.split_at_mut(count);
        let (fine, coarse) = (&fine[count - 1], &mut coarse[0]);
        transfer.coarsening.rebuild(&fine.pattern, fine.numbering, &fine.is_boundary);
        let nodes = transfer.coarsening.row.len();
        if nodes as f64 > MOST_COARSE_SHARE * fine.pattern.row_count() as f64 {
            return false;
        }
        interpolation::rebuild(&mut transfer.parts, &fine.pattern, &fine.places, &transfer.coarsening.node);
        transfer.sort();
        galerkin::rebuild_pattern(&mut coarse.pattern, &fine.pattern, transfer);
        coarse.numbering = Numbering::of_width(nodes, coarse.pattern.width());
        let numbering = coarse.numbering;
        if numbering != Numbering::single(nodes) {
            self.by_place.reorder(&coarse.pattern, |place| numbering.row(place), |row| numbering.place(row));
            std::mem::swap(&mut coarse.pattern, &mut self.by_place);
            transfer.renumber(numbering);
        }
        coarse.copy_places(fine, &transfer.coarsening.row);
        true
    }

    /// Takes the operator's numbers.
    pub(super) fn assemble(&mut self, partition: &Partition, matrix: &Matrix) {
        let Level { numbering, pattern, diagonal, lower, free, .. } = &mut self.levels[0];
        empty(lower, pattern.column.len());
        lower.resize(pattern.column.len(), block::ZERO);
        let row = |place: usize| numbering.row(place as u32) as usize;
        let rows = matrix.vertex_blocks.row_count();
        empty(diagonal, rows);
        diagonal.resize(rows, block::ZERO);
        (0..rows).for_each(|of| diagonal[row(of)] = Block::own(matrix, of));
        pattern.gather(
            (partition, partition.all_blocks()),
            matrix,
            row,
            |row, value| block::add(&mut diagonal[row], value),
            |_, place, value| block::add(&mut lower[place], value),
        );
        empty(free, rows);
        free.extend((0..rows).map(|row| matrix.vertex_blocks.free(numbering.place(row as u32) as usize)));
        self.finish();
    }

    /// Takes the numbers that the finest level of the same mesh has had; whether they fit.
    pub(super) fn set(&mut self, diagonal: &[Block], lower: &[Block], free: &[Vec4]) -> bool {
        let finest = &mut self.levels[0];
        let (rows, blocks) = (finest.pattern.row_count(), finest.pattern.column.len());
        if (diagonal.len(), lower.len(), free.len()) != (rows, blocks, rows) {
            return false;
        }
        (finest.diagonal, finest.lower, finest.free) = (diagonal.to_vec(), lower.to_vec(), free.to_vec());
        self.finish();
        true
    }

    /// Finds the numbers of the coarser levels from those of the finest.
    fn finish(&mut self) {
        self.levels[0].finish();
        for (i, transfer) in self.transfers.iter().enumerate() {
            let (fine, coarse) = self.levels.split_at_mut(i + 1);
            let (fine, coarse) = (&fine[i], &mut coarse[0]);
            // A node has the free axes of its row.
            empty(&mut coarse.free, transfer.coarsening.row.len());
            coarse.free.extend(transfer.coarsening.row.iter().map(|&row| fine.free[row as usize]));
            galerkin::assemble(coarse, fine, transfer);
            coarse.finish();
        }
        if let Some(last) = self.levels.last()
            && last.pattern.row_count() <= MOST_COARSEST
        {
            self.coarsest.factor(last);
        }
    }

    /// The finest level.
    pub(super) fn finest(&self) -> &Level {
        &self.levels[0]
    }

    /// The answer of a cycle on the finest level, by its rows.
    pub(super) fn answer(&self) -> &[Vec4] {
        &self.vectors[0].x
    }

    /// The first half of a cycle for the right-hand side `r` of the finest level: as much as it takes to know the scalar product of `r`
    /// with the answer, which is returned. A level's sweep and its adjoint, whose matrices are D + L and its transpose, add x·D·x to
    /// it, for the x that the first has left.
    pub(super) fn forward_sweep(&mut self, r: impl Fn(usize) -> Vec4 + Sync) -> f64 {
        let of_sweeps: f64 = (0..self.above_twice()).map(|i| self.down(i, (i == 0).then_some(&r))).sum();
        if self.above_twice() == self.levels.len() { of_sweeps } else { of_sweeps + self.cycle_twice() }
    }

    /// The second half, back up to the finest level, after the first for the same `r`.
    pub(super) fn backward_sweep(&mut self, r: impl Fn(usize) -> Vec4 + Sync) {
        for i in (0..self.above_twice()).rev() {
            self.up(i, (i == 0).then_some(&r));
        }
    }

    /// How many levels there are above the one that is cycled [`TWICE`].
    fn above_twice(&self) -> usize {
        if self.levels.len() > TWICE + 1 { TWICE } else { self.levels.len() }
    }

    /// Two cycles from the level [`TWICE`] on, for its right-hand side; returns the scalar product of that with the answer. The error
    /// propagation of two cycles, (1 − M·A)², is symmetric in the sense of A and positive, as that of one.
    fn cycle_twice(&mut self) -> f64 {
        self.down(TWICE, OWN);
        self.end_cycle(TWICE);
        self.down_again(TWICE);
        self.end_cycle(TWICE);
        let Vectors { r, x, .. } = &self.vectors[TWICE];
        r.iter().zip(x).map(|(r, x)| dot(*r, *x)).sum()
    }

    /// Remainder of a cycle from a level, after that level's part in the first half.
    fn end_cycle(&mut self, first: usize) {
        let last = self.levels.len() - 1;
        (first + 1..=last).for_each(|i| _ = self.down(i, OWN));
        (first..=last).rev().for_each(|i| self.up(i, OWN));
    }

    /// The part of a level in the first half of a cycle from zero, for its own right-hand side or, of the finest, `r`.
    fn down(&mut self, i: usize, r: Option<&(impl Fn(usize) -> Vec4 + Sync)>) -> f64 {
        let Self { levels, vectors, transfers, coarsest, partials, .. } = self;
        let (level, last) = (&levels[i], levels.len() - 1);
        let (fine, coarse) = vectors.split_at_mut(i + 1);
        let Vectors { r: own, x, left, .. } = &mut fine[i];
        if i == last && x.len() <= MOST_COARSEST {
            r.into_iter().for_each(|r| own.iter_mut().enumerate().for_each(|(row, own)| *own = r(row)));
            coarsest.solve(own, x);
            return own.iter().zip(&*x).map(|(r, x)| dot(*r, *x)).sum();
        }
        let product = match r {
            Some(r) => level.forward(x, partials, r),
            None => level.forward(x, partials, |row| own[row]),
        };
        if i < last {
            level.subtract(x, left);
            transfers[i].restrict(left, &mut coarse[0].r);
        }
        product
    }

    /// The part of a level in the first half of a cycle from the answer x of a cycle: with y for the result of the sweep,
    /// (D + L)·y = r − U·x leaves the residual −U·(y − x).
    fn down_again(&mut self, i: usize) {
        let Self { levels, vectors, transfers, partials, .. } = self;
        let (fine, coarse) = vectors.split_at_mut(i + 1);
        let Vectors { r, x, left, change } = &mut fine[i];
        levels[i].subtract(x, left);
        empty(change, x.len());
        change.extend_from_slice(x);
        levels[i].forward(x, partials, |row| r[row] + left[row]);
        parallel::for_rows(change, |row, change| *change = x[row] - *change);
        levels[i].subtract(change, left);
        transfers[i].restrict(left, &mut coarse[0].r);
    }

    /// The part of a level in the second half of a cycle.
    fn up(&mut self, i: usize, r: Option<&(impl Fn(usize) -> Vec4 + Sync)>) {
        let Self { levels, vectors, transfers, .. } = self;
        let (fine, coarse) = vectors.split_at_mut(i + 1);
        let Vectors { r: own, x, .. } = &mut fine[i];
        if i + 1 < levels.len() {
            transfers[i].prolong(&coarse[0].x, x);
        } else if x.len() <= MOST_COARSEST {
            return;
        }
        match r {
            Some(r) => levels[i].backward(x, r),
            None => levels[i].backward(x, |row| own[row]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::galerkin::tests::{SIDE, coarser, grid};
    use super::*;

    /// In space, and with nothing free along z: then sweeps take flat blocks.
    #[test]
    fn half_a_cycle_knows_the_product_with_the_answer() {
        for axes in [Vec4::new(1.0, 1.0, 1.0, 0.0), Vec4::new(1.0, 1.0, 0.0, 0.0)] {
            let mut fine = grid();
            fine.free.iter_mut().for_each(|free| *free *= axes);
            fine.finish();
            let (_, transfer, coarse) = coarser(&fine);
            let mut coarsest = Coarsest::default();
            coarsest.factor(&coarse);
            let vectors = [&fine, &coarse].map(|level| {
                let zero = vec![Vec4::ZERO; level.free.len()];
                Vectors { r: zero.clone(), x: zero.clone(), left: zero, ..Vectors::default() }
            });
            let r: Vec<Vec4> = (0..SIDE * SIDE)
                .map(|row| Vec4::new((row as f32).sin(), (2.0 * row as f32).cos(), (3.0 * row as f32).sin(), 0.0))
                .zip(&fine.free)
                .map(|(r, free)| r * *free)
                .collect();
            let (levels, transfers, vectors) = (vec![fine, coarse], vec![transfer], vectors.into());
            let mut hierarchy = Hierarchy { levels, transfers, vectors, coarsest, ..Hierarchy::default() };
            let product = hierarchy.forward_sweep(|row| r[row]);
            hierarchy.backward_sweep(|row| r[row]);
            let expected: f64 = r.iter().zip(hierarchy.answer()).map(|(r, x)| dot(*r, *x)).sum();
            // Some two hundred terms of one sign on one side, each rounded to half of 1.2e-7.
            assert!(product > 0.0 && (product - expected).abs() < 2e-5 * product, "{product} against {expected}");
        }
    }
}

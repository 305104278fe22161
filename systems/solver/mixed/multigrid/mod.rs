//! Multigrid: a cycle over coarser and coarser levels (Brandt 1977), none of which needs a grid or a chart of the surface. It is a V-cycle,
//! but that the coarser of many levels are cycled through twice.
//!
//! Coarse nodes are vertices of the mesh ([`coarsen`]), weights come from the rest shape and from distances along edges
//! ([`interpolation`]), operators are PᵀAP ([`galerkin`]), smoothing is one Gauss–Seidel sweep before and its adjoint after
//! ([`level`]). The sides of a tear have no edge in common, and so no weights and no blocks: every side has nodes of its own, on all
//! levels; as a tear goes on, the levels follow ([`follow`]).
//!
//! The cycle is that of the operator it was made for, all levels of it. It stays symmetric and positive however far the body has
//! moved on, and is made anew when that costs less than the iterations it would save.

mod coarsen;
mod coarsest;
mod follow;
mod galerkin;
mod hierarchy;
mod interpolation;
mod level;
mod marks;
mod numbering;
mod state;
mod transfer;

use super::cg::{Precondition, Vectors};
use super::edits::Edits;
use super::matrix::{Matrix, dot};
use super::order::Order;
use super::partition::Partition;
use crate::math::elementary;
use crate::storage::{Topology, Triangles, Vertices};
use crate::systems::parallel;
use glam::DVec2;
use hierarchy::Hierarchy;
pub(super) use state::MultigridState;

/// Cost of renewing the numbers of all levels, in iterations (5 to 8 from 5,000 to 150,000 triangles).
const RENEWAL: f64 = 6.0;

/// Largest number of consecutive solves that each renew the numbers, before older ones are tried again.
const MOST_STRICT: u32 = 64;

/// The levels and how old their numbers are.
#[derive(Debug, Default)]
pub(super) struct Multigrid {
    hierarchy: Hierarchy,
    has_levels: bool,
    /// Whether they were asked for since the last edits.
    is_used: bool,
    /// Whether they have an operator's numbers.
    has_numbers: bool,
    /// Solves since the numbers were renewed.
    served: u32,
    /// Iterations per decade of residual reduction in the first solve with these numbers.
    rate: f64,
    /// Iterations beyond that rate, summed over the later solves with these numbers.
    excess: f64,
    /// Solves left that each renew the numbers, and their number at the last decision.
    strict: u32,
    strictness: u32,
}

impl Multigrid {
    /// Updates the levels after edits; `false` where they must be rebuilt, which needs rows in good order.
    pub(super) fn follow(
        &mut self,
        partition: &Partition,
        order: &Order,
        mesh: (&Vertices, &Triangles, &Topology),
        edits: &Edits,
    ) -> bool {
        if !self.has_levels {
            return true;
        }
        self.has_levels = self.is_used && self.hierarchy.follow(partition, order, mesh, Some(edits));
        (self.is_used, self.has_numbers) = (false, false);
        self.has_levels
    }

    /// Drops the levels: triangles or rows have been replaced.
    pub(super) fn forget(&mut self) {
        self.has_levels = false;
    }

    /// Builds missing levels before a solve, and renews numbers that no longer serve.
    pub(super) fn set_up(
        &mut self,
        partition: &Partition,
        order: &Order,
        mesh: (&Vertices, &Triangles, &Topology),
        matrix: &Matrix,
    ) {
        self.is_used = true;
        if !self.has_levels {
            self.hierarchy.rebuild(partition, order, mesh);
            (self.has_levels, self.has_numbers) = (true, false);
        }
        if !self.has_numbers {
            self.assemble(partition, matrix);
            return;
        }
        let finest = self.hierarchy.finest();
        let is_freed =
            |place: usize| finest.free[finest.numbering.row(place as u32) as usize] != matrix.vertex_blocks.free(place);
        if self.excess >= RENEWAL {
            self.renew(partition, matrix);
        } else if self.strict > 0 || (0..matrix.vertex_blocks.row_count()).any(is_freed) {
            self.strict = self.strict.saturating_sub(1);
            self.assemble(partition, matrix);
        }
    }

    /// Takes the operator's numbers because those of an earlier one no longer serve.
    pub(super) fn renew(&mut self, partition: &Partition, matrix: &Matrix) {
        // Where they were hardly worth keeping they are not kept for a while.
        self.strictness = if self.served <= 2 { (2 * self.strictness).clamp(4, MOST_STRICT) } else { 0 };
        self.strict = self.strictness;
        self.assemble(partition, matrix);
    }

    fn assemble(&mut self, partition: &Partition, matrix: &Matrix) {
        self.hierarchy.assemble(partition, matrix);
        self.has_numbers = true;
        (self.served, self.excess) = (0, 0.0);
    }

    /// Whether the numbers are those of an earlier operator.
    pub(super) fn is_earlier(&self) -> bool {
        self.served > 0
    }

    /// Iteration limit of a solve that reduces the residual by the factor `gain`: at more, renewing the numbers costs less.
    pub(super) fn most(&self, gain: f64) -> u32 {
        if self.served == 0 { u32::MAX } else { (self.rate * powers_of_ten(gain) + 2.0 * RENEWAL) as u32 }
    }

    /// Records a solve that reduced the residual by the factor `gain`.
    pub(super) fn has_served(&mut self, iterations: u32, gain: f64) {
        // A solve that ends at its guess tells nothing.
        if iterations == 0 {
            return;
        }
        let (iterations, powers) = (f64::from(iterations), powers_of_ten(gain));
        if self.served == 0 {
            self.rate = iterations / powers;
        }
        self.excess += (iterations - self.rate * powers).max(0.0);
        self.served += 1;
    }
}

/// Decades of residual reduction, from 0.1 to 16.
fn powers_of_ten(gain: f64) -> f64 {
    if gain > 0.0 { (-elementary::log10(gain)).clamp(0.1, 16.0) } else { 16.0 }
}

impl Precondition for Multigrid {
    fn forward_sweep(&mut self, alpha: f32, vectors: &mut Vectors) -> DVec2 {
        let Vectors { xr, p, q, partials, .. } = vectors;
        let rr = parallel::sum_rows(xr, partials, |row, [x, r]| {
            *x += p[row] * alpha;
            *r -= q[row] * alpha;
            dot(*r, *r)
        });
        let (numbering, xr) = (self.hierarchy.finest().numbering, &*xr);
        DVec2::new(rr, self.hierarchy.forward_sweep(|row| xr[numbering.place(row as u32) as usize][1]))
    }

    fn backward_sweep(&mut self, beta: f32, vectors: &mut Vectors) {
        let Vectors { xr, p, .. } = vectors;
        let (numbering, xr) = (self.hierarchy.finest().numbering, &*xr);
        self.hierarchy.backward_sweep(|row| xr[numbering.place(row as u32) as usize][1]);
        let answer = self.hierarchy.answer();
        parallel::for_rows(p, |place, p| *p = answer[numbering.row(place as u32) as usize] + *p * beta);
    }
}

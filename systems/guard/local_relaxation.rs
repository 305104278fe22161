//! Local relaxation by vertex block descent, where the linear solution would create energy.
//!
//! A step of backward Euler seeks the minimum of the incremental potential Φ(x) = E(x) + ½·(x − y)·M/dt²·(x − y) + …. Here E is the
//! energy, and y the place to which inertia alone would carry. The solve takes E by its tangent. Where a triangle turns far the
//! tangent says nothing, and most often that is a single one: a spike at a torn edge, which hangs on by one side. Its vertices are
//! then moved by descent on Φ itself, one after the other with all others at rest (block coordinate descent; Chen et al. 2024,
//! *Vertex Block Descent*, ACM Trans Graph 43:116). Every move lowers Φ, and so creates nothing. Bending, damping and loads stay as
//! the solve has them, quadratic. All other vertices keep the solve's answer. The residual that the local relaxation leaves, its own and
//! that of the vertices beside it, counts as work that no load has done.

use super::solved::{Solved, Sums};
use crate::components::LocalRelaxation;
use crate::math::{ElementState, elementary};
use crate::storage::room;
use crate::systems::kernels::membrane;
use crate::systems::solver::Operator;
use glam::{DMat3, DVec3};

/// Sweeps over the vertices of a local relaxation at the most.
const SWEEPS: u32 = 40;

/// A sweep that moves no vertex by more than this part of the size of a triangle is the last.
const SETTLED: f64 = 1e-4;

/// Maximum halvings of a move that does not pass the test of [`ARMIJO_OF_MOVE`].
const MOVE_HALVINGS: u32 = 12;
/// Fraction of the decrease promised by the slope that a move must reach (Armijo 1966).
const ARMIJO_OF_MOVE: f64 = 1e-4;

/// Most rounds of a local relaxation; every one after the first enlarges it.
const MOST_RELAXATION_ROUNDS: u32 = 4;

/// Ratio of vertex stiffness (jaws, springs, mass) to membrane stiffness above which a vertex keeps the displacement of the solve.
const LED: f64 = 10.0;

/// Size limit of a local relaxation, as a fraction of the vertices; beyond it the whole step is at fault.
const MOST_RELAXED: f64 = 0.05;

/// Size limit of a local relaxation in small bodies, up to [`FEW_VERTICES`] vertices, as a part of the vertices.
const MOST_RELAXED_OF_FEW: f64 = 0.15;

/// Number of relaxed vertices up to which the size limit of small bodies applies.
const FEW_VERTICES: f64 = 24.0;

/// Factor on the vertex limit of a local relaxation in a body that gets a Newton correction anyway.
const WIDER: usize = 4;
/// Maximum sweeps in such a body.
const FEW_SWEEPS: u32 = 8;

/// Fraction of the excess that suffices once the number of starting triangles is used up.
const NEARLY: f64 = 0.9;

/// Size limits of a local relaxation.
pub(super) struct Extent {
    /// Most triangles that are taken to begin with.
    pub triangles: usize,
    /// Whether a local relaxation may leave some of the excess to a Newton correction.
    pub is_partial: bool,
}

impl LocalRelaxation {
    /// Local relaxation that brings the spurious energy `sum` \[mJ\] of an answer below the limit `most`. Returns the energy that `judge`
    /// finds; `None` where the size limits are exceeded. A partial relaxation may stay above the energy limit.
    pub(super) fn find(
        &mut self,
        solved: &Solved,
        full: &Operator,
        extent: &Extent,
        (mut sum, most): (f64, f64),
        mut judge: impl FnMut(&Self) -> f64,
    ) -> Option<f64> {
        self.begin(solved);
        for round in 0..MOST_RELAXATION_ROUNDS {
            let triangles = if round == 0 { extent.triangles } else { usize::MAX };
            let is_enough = self.grow(solved, sum - most, &Extent { triangles, ..*extent });
            if !is_enough && !extent.is_partial {
                return None;
            }
            self.descend(solved, full, if extent.is_partial { FEW_SWEEPS } else { SWEEPS });
            sum = judge(self);
            if sum <= most || !is_enough {
                return Some(sum);
            }
        }
        extent.is_partial.then_some(sum)
    }

    /// Begins with no vertex, and with the solve's answer.
    fn begin(&mut self, solved: &Solved) {
        let (vertices, triangles) = (solved.operator.vertices, solved.operator.triangles);
        let (count, most) = (solved.delta.len(), vertices.position.capacity());
        self.rows.clear();
        room::grow(&mut self.rows, count, most);
        self.is_in.clear();
        room::grow(&mut self.is_in, count, most);
        self.is_in.resize(count, false);
        room::copy(&mut self.way, solved.delta, most);
        self.off.clear();
        room::grow(&mut self.off, count, most);
        self.off.resize(count, DVec3::ZERO);
        self.created.clear();
        room::grow(&mut self.created, triangles.len(), triangles.corners.capacity());
    }

    /// The body with the way that the local relaxation has found.
    pub(super) fn judged<'a>(&'a self, solved: &Solved<'a>) -> Solved<'a> {
        Solved { delta: &self.way, ..*solved }
    }

    /// Number of vertices.
    pub(super) fn len(&self) -> usize {
        self.rows.len()
    }

    /// Adds the triangles that create most until they account for `excess` \[mJ\], or else the surrounding ones; returns whether the size
    /// limits allow that.
    fn grow(&mut self, solved: &Solved, excess: f64, extent: &Extent) -> bool {
        let Operator { triangles, topology, .. } = solved.operator;
        let mut created = std::mem::take(&mut self.created);
        let judged = self.judged(solved);
        let each = (0..triangles.len()).map(|t| (judged.of_triangle(t, 1.0), t as u32));
        created.clear();
        created.extend(each.filter(|(more, _)| !(*more <= 0.0)));
        created.sort_unstable_by(|(a, t), (b, u)| b.total_cmp(a).then(t.cmp(u)));
        let most = if extent.is_partial { WIDER * self.most() } else { self.most() };
        let before = self.rows.len();
        let mut is_enough = true;
        let mut sum = 0.0;
        for (count, &(more, t)) in created.iter().enumerate() {
            if sum >= if count < extent.triangles { excess } else { NEARLY * excess } {
                break;
            }
            is_enough = count < extent.triangles && self.take(&triangles.corners[t as usize], most);
            if !is_enough {
                break;
            }
            sum += more;
        }
        self.created = created;
        if is_enough && self.rows.len() == before {
            for place in 0..before {
                let around = topology.incident[self.rows[place] as usize].iter().map(|c| c / 3);
                around.for_each(|t| self.add(&triangles.corners[t as usize]));
            }
            is_enough = self.keep(before, most);
        }
        self.rows.sort_unstable();
        is_enough
    }

    /// Adds vertices, or none where there would be more than `most`; returns whether they were added.
    fn take(&mut self, vertices: &[u32], most: usize) -> bool {
        let before = self.rows.len();
        self.add(vertices);
        self.keep(before, most)
    }

    fn add(&mut self, vertices: &[u32]) {
        for v in vertices {
            if !std::mem::replace(&mut self.is_in[*v as usize], true) {
                self.rows.push(*v);
            }
        }
    }

    /// Removes the vertices added after the first `before` if there are more than `most`; returns whether they stay.
    fn keep(&mut self, before: usize, most: usize) -> bool {
        let has_room = self.rows.len() <= most;
        if !has_room {
            self.rows.drain(before..).for_each(|v| self.is_in[v as usize] = false);
        }
        has_room
    }

    fn most(&self) -> usize {
        let count = self.way.len() as f64;
        (MOST_RELAXED * count).max((MOST_RELAXED_OF_FEW * count).min(FEW_VERTICES)) as usize
    }

    /// Sweeps over the relaxed vertices, each moved with all others at rest. `full` is the operator of the solve, with loads and all.
    fn descend(&mut self, solved: &Solved, full: &Operator, sweeps: u32) {
        for _ in 0..sweeps {
            let mut farthest = 0.0_f64;
            for place in 0..self.rows.len() {
                farthest = farthest.max(self.descend_at(self.rows[place] as usize, solved, full));
            }
            if !(farthest > SETTLED) {
                return;
            }
        }
    }

    /// Moves a vertex; returns the length of the move over the size of its smallest triangle.
    fn descend_at(&mut self, v: usize, solved: &Solved, full: &Operator) -> f64 {
        let Operator { triangles, topology, frames, .. } = *full;
        let undamped = Operator { viscosity: 0.0, ..*full };
        let free = DMat3::from_diagonal(solved.free[v]);
        // Forces that do not follow the membrane, and their part of the matrix.
        let mut other = solved.residual[v] - full.apply_at(v, &self.off);
        let (mut elastic, mut pull, mut size) = (DMat3::ZERO, DVec3::ZERO, f64::INFINITY);
        for &c in &topology.incident[v] {
            let (t, corner) = (c as usize / 3, c as usize % 3);
            let (tangent, rest) = (undamped.element(t), &triangles.rest[t]);
            let start = frames.state(t);
            other += tangent.apply(triangles.corners[t].map(|i| self.way[i as usize]))[corner];
            other -= membrane::nodal_forces(&start.polar, start.stress, rest, solved.volume(t))[corner];
            elastic += tangent.diagonal_block(corner);
            let ElementState { polar, stress } =
                solved.law.element(solved.operator.triangles, t).state(self.corners(t, full));
            pull += membrane::nodal_forces(&polar, stress, rest, solved.volume(t))[corner];
            size = size.min(rest.area.sqrt());
        }
        let own = full.diagonal_block(v) - elastic;
        // Vertices led by jaws or springs keep the displacement of the solve: their force is that of a stiff spring.
        if trace(&own) > LED * trace(&elastic) {
            return 0.0;
        }
        let force = free * (other + pull);
        let block = free * (own + elastic) * free + (DMat3::IDENTITY - free);
        let Some(whole) = Some(block.inverse() * force).filter(|way| way.is_finite()) else { return 0.0 };
        let stored = |relaxation: &Self| -> f64 {
            let around = topology.incident[v].iter().map(|&c| c as usize / 3);
            around.map(|t| solved.law.element(solved.operator.triangles, t).energy(relaxation.corners(t, full))).sum()
        };
        let (before, way, off) = (stored(self), self.way[v], self.off[v]);
        for halving in 0..=MOVE_HALVINGS {
            let moved = whole * elementary::powi(0.5, halving);
            (self.way[v], self.off[v]) = (way + moved, off + moved);
            let change = stored(self) - before - other.dot(moved) + 0.5 * moved.dot(own * moved);
            if change <= -ARMIJO_OF_MOVE * force.dot(moved) {
                return moved.length() / size;
            }
        }
        (self.way[v], self.off[v]) = (way, off);
        0.0
    }

    fn corners(&self, t: usize, full: &Operator) -> [DVec3; 3] {
        full.triangles.corners[t].map(|v| full.vertices.position[v as usize] + self.way[v as usize])
    }

    /// Work \[mJ\] of the residual that the local relaxation leaves, r − A·off, along the way: no load has done it.
    pub(super) fn residual_work(&self, solved: &Solved, full: &Operator, sums: &mut Sums<'_>) -> f64 {
        let Sums { passes, product, .. } = sums;
        product.resize(self.off.len(), DVec3::ZERO);
        Operator { volume: None, ..*full }.apply_sparse(&self.off, product, passes);
        let missed = product.iter().zip(solved.residual).map(|(product, residual)| *product - *residual);
        missed.zip(&self.way).enumerate().map(|(v, (force, way))| (solved.free[v] * force).dot(*way)).sum()
    }
}

fn trace(block: &DMat3) -> f64 {
    block.x_axis.x + block.y_axis.y + block.z_axis.z
}

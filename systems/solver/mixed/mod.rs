//! The solve of a dynamic step in mixed precision: residuals in double precision, iterations in single.
//!
//! State, loads and residuals are double. Conjugate gradients in single precision, on the residual scaled to one, find the
//! correction that it asks for. The correction is added, and the residual formed anew (Wilkinson 1963, iterative refinement). So
//! the answer is as good as that of double precision, and what is reported is the true residual. One round does at the tolerances
//! that a step is usually solved to; a tighter one takes several.

mod adjacency;
mod cg;
mod cycle;
mod dissection;
mod edits;
mod factored;
mod folding;
mod incomplete;
mod jacobi;
mod matrix;
mod multigrid;
mod order;
mod partition;
mod pattern;
mod residual;
mod response;
mod state;
mod vertex_blocks;

use super::estimate::Limits;
use super::recurrence::Reached;
use super::{CgError, CgInfo, Factor, Operator, ProductMemory};
use crate::components::{FreeAxes, SolverScratch};
use crate::settings::LinearParams;
use crate::storage::{Revision, Topology, Triangles, Vertices};
use crate::systems::parallel;
use adjacency::Adjacency;
use cg::Vectors;
use edits::Edits;
use factored::Factored;
use glam::{DVec3, Vec4};
use incomplete::Incomplete;
use jacobi::Jacobi;
use matrix::Matrix;
use multigrid::Multigrid;
use order::Order;
use partition::Partition;
use residual::is_single;
use response::LastPreconditioner;
pub use state::MixedState;

/// A round that leaves more of the residual than this has come to nothing: double precision goes on.
const STALLED: f64 = 0.5;

/// Iterations that are few: of hundreds the rounding adds up.
const FEW: u32 = 20;

/// The diagonal is raised by this fraction of itself before it is factored (Manteuffel 1980). Chosen on the lens capsule as it tears.
const SHIFT: f32 = 0.01;

/// Iterations of a round with a factor at the most. One that has come to nothing in so many, or is broken, is a bad one: the next has its
/// diagonal raised ten times as far, up to [`MOST_SHIFT`].
const MOST_WITH_FACTOR: u32 = 150;

/// Maximum fraction by which the diagonal is raised.
const MOST_SHIFT: f32 = 1.0;

/// Minimum number of triangles for nested dissection of the rows of an incomplete factor. Smaller bodies gain little by a second thread.
const LEAST_CUT: usize = 8192;

/// Preconditioner that the mixed-precision solver builds itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MixedPreconditioner {
    /// Block Jacobi: the inverse of the diagonal block of each vertex.
    BlockJacobi,
    /// An incomplete Cholesky factor.
    IncompleteCholesky,
    /// A multigrid cycle over coarser and coarser levels.
    Multigrid,
}

/// Preconditioner of a solve.
#[derive(Debug)]
pub enum ActivePreconditioner<'a> {
    /// Built from the present operator.
    Built(MixedPreconditioner),
    /// Cholesky factor of an earlier operator, and the maximum number of iterations with it.
    Factor(&'a mut Factor, u32),
}

impl ActivePreconditioner<'_> {
    /// Whether rows may be ordered by nested dissection. Multigrid levels need neighbouring rows together; small bodies are solved on one thread.
    fn may_be_cut(&self, operator: &Operator) -> bool {
        let is_by_levels = operator.is_planar() || matches!(self, Self::Built(MixedPreconditioner::Multigrid));
        !is_by_levels && operator.triangles.len() >= LEAST_CUT
    }
}

/// A body's operator in single precision and the vectors of its solves. What depends on the triangles alone is kept while
/// they stay. *Derived.*
#[derive(Debug, Default)]
pub struct MixedSolver {
    /// Moment in the triangles' history of which the rest is.
    followed: Revision,
    adjacency: Adjacency,
    // Many lists each: behind pointers, lest the world keeps room for them wherever it has room for bodies.
    order: Box<Order>,
    partition: Box<Partition>,
    matrix: Box<Matrix>,
    jacobi: Jacobi,
    incomplete: Box<Incomplete>,
    has_pattern: bool,
    /// Whether the pattern was asked for since the last edits.
    needs_pattern: bool,
    edits: Box<Edits>,
    multigrid: Box<Multigrid>,
    vectors: Box<Vectors>,
    /// Preconditioner of the last solve; `None` where the triangles have changed since.
    ready: Option<LastPreconditioner>,
    /// Whether the matrix and the incomplete factor have been made of the operator that several solves share.
    same: Option<[bool; 2]>,
}

impl MixedSolver {
    /// Whether the solves from now on are of one operator, with one set of free axes: what is made of it then serves all.
    pub fn share(&mut self, is_same: bool) {
        self.same = is_same.then_some([false; 2]);
    }

    /// Solves A·x = b for a tangent that is never indefinite, from the guess `x`, whose prescribed axes stay; `scratch` as in the solve in
    /// double precision. The second answer is whether the tolerance or the limit of iterations was reached. Where single
    /// precision has come to nothing instead, `x` is as far as it has come, and `scratch.residual` holds b again. `scratch.direction` holds
    /// it in any case.
    ///
    /// # Errors
    /// [`CgError::NotFinite`] for a right-hand side or an operator that is not finite; `scratch.residual` is then as it was.
    pub fn solve(
        &mut self,
        operator: &Operator,
        params: &LinearParams,
        mut active: ActivePreconditioner,
        memory: &mut ProductMemory<'_>,
        x: &mut [DVec3],
        scratch: &mut SolverScratch,
    ) -> Result<(CgInfo, bool), CgError> {
        let is_single = is_single(params, scratch);
        let (reference_sq, mut residual_sq, is_assembled) =
            self.first_residual(operator, is_single, memory, x, scratch)?;
        let limits = Limits::new(params, reference_sq, [scratch.twice_stored, scratch.motion_scale]);
        let mut info = CgInfo { error_energy: f64::INFINITY, ..CgInfo::default() };
        let (mut is_solved, mut shift) = (true, SHIFT);
        if !limits.are_met_at_end(residual_sq, info.error_energy) {
            if !is_assembled {
                self.assemble(operator, &scratch.free, active.may_be_cut(operator));
            }
            self.set_up(operator, &mut active, &scratch.free, shift);
        }
        while !limits.are_met_at_end(residual_sq, info.error_energy)
            && info.iterations < limits.iterations
            && !info.is_late
        {
            let norm = residual_sq.sqrt();
            self.set_residual(&scratch.residual, norm);
            let most = match active {
                ActivePreconditioner::Built(MixedPreconditioner::BlockJacobi) => u32::MAX,
                ActivePreconditioner::Built(MixedPreconditioner::IncompleteCholesky) => MOST_WITH_FACTOR,
                ActivePreconditioner::Built(MixedPreconditioner::Multigrid) => {
                    self.multigrid.most(limits.of_round(norm, 0).least_sq.sqrt())
                }
                ActivePreconditioner::Factor(_, most) => most - info.iterations,
            };
            let most = most.min(limits.iterations - info.iterations);
            let is_own_factor = matches!(active, ActivePreconditioner::Built(MixedPreconditioner::IncompleteCholesky));
            let round = limits.of_round(norm, most).repeating(&mut scratch.stops);
            let Ok(reached) = self.iterate(&mut active, &round) else {
                // L may have left the range of single precision.
                if is_own_factor && shift < MOST_SHIFT {
                    shift = self.refactor(shift);
                    continue;
                }
                // A direction without curvature may be one that single precision has lost: double precision decides.
                is_solved = false;
                break;
            };
            scratch.stops.note(reached.iterations, reached.is_late);
            info.iterations += reached.iterations;
            info.error_energy = reached.energy * norm * norm;
            info.is_late = reached.is_late;
            let before_sq = residual_sq;
            // Each iteration adds its rounding to what the recursion says of the residual: a few do not show.
            let by_recursion = reached.residual_sq * residual_sq;
            let is_known = is_single && reached.iterations <= FEW;
            residual_sq = if reached.iterations == 0 && limits.are_met_at_end(residual_sq, info.error_energy) {
                residual_sq
            } else if is_known && limits.are_met_at_end(by_recursion, info.error_energy) {
                self.add_to(x, norm);
                let (row, xr) = (&self.order.row, &self.vectors.xr);
                let left = |v: usize| xr[row[v] as usize][1].truncate().as_dvec3() * norm;
                parallel::for_rows(&mut scratch.residual, |v, r| *r = left(v));
                by_recursion
            } else {
                self.add_to(x, norm);
                self.residual(operator, memory, x, scratch)
            };
            if matches!(active, ActivePreconditioner::Built(MixedPreconditioner::Multigrid)) {
                self.multigrid.has_served(reached.iterations, (residual_sq / before_sq).sqrt());
            }
            if limits.are_met_at_end(residual_sq, info.error_energy) {
                break;
            }
            let has_gained = residual_sq <= STALLED * STALLED * before_sq;
            let is_used_up = reached.is_broken || reached.iterations == most;
            if is_own_factor && is_used_up && !has_gained && shift < MOST_SHIFT {
                shift = self.refactor(shift);
                continue;
            }
            let has_stalled = !has_gained && reached.iterations < most;
            let has_used_up = matches!(active, ActivePreconditioner::Factor(_, most) if info.iterations >= most);
            if (has_stalled || has_used_up) && !info.is_late {
                is_solved = false;
                break;
            }
            if reached.iterations == most
                && matches!(active, ActivePreconditioner::Built(MixedPreconditioner::Multigrid))
            {
                self.multigrid.renew(&self.partition, &self.matrix);
            }
        }
        if !is_solved {
            scratch.residual.copy_from_slice(&scratch.direction);
        }
        info.is_solved = limits.are_met_at_end(residual_sq, info.error_energy);
        info.relative_residual = if reference_sq > 0.0 { (residual_sq / reference_sq).sqrt() } else { 0.0 };
        Ok((info, is_solved))
    }

    /// Assembles the operator in single precision.
    fn assemble(&mut self, operator: &Operator, free: &FreeAxes, is_cut: bool) {
        if self.same.as_mut().is_some_and(|made| std::mem::replace(&mut made[0], true)) {
            return;
        }
        self.follow((operator.vertices, operator.triangles, operator.topology), is_cut);
        self.matrix.assemble(operator, &self.partition, &self.order, free);
    }

    /// Builds the preconditioner.
    fn set_up(&mut self, operator: &Operator, active: &mut ActivePreconditioner, free: &FreeAxes, shift: f32) {
        let corners = &operator.triangles.corners;
        match active {
            ActivePreconditioner::Built(MixedPreconditioner::BlockJacobi) => {
                self.jacobi.factor(&self.partition, &self.matrix)
            }
            ActivePreconditioner::Built(MixedPreconditioner::IncompleteCholesky) => {
                if self.same.as_mut().is_some_and(|made| std::mem::replace(&mut made[1], true)) {
                    return;
                }
                self.needs_pattern = true;
                if !self.has_pattern {
                    self.find_neighbours(corners, operator.topology);
                    self.incomplete.rebuild(&self.partition, &self.order, corners, &self.adjacency);
                    self.has_pattern = true;
                }
                self.incomplete.factor(&self.partition, self.order.dissection, &self.matrix, shift);
            }
            ActivePreconditioner::Built(MixedPreconditioner::Multigrid) => {
                let mesh = (operator.vertices, operator.triangles, operator.topology);
                self.multigrid.set_up(&self.partition, &self.order, mesh, &self.matrix);
            }
            ActivePreconditioner::Factor(factor, _) => factor.begin(operator, free),
        }
        self.put_away_neighbours();
        self.ready = Some(match active {
            ActivePreconditioner::Built(mixed) => LastPreconditioner::Built(*mixed),
            ActivePreconditioner::Factor(..) => LastPreconditioner::Factor,
        });
    }

    /// Finds the neighbours of the vertices where they are not known.
    fn find_neighbours(&mut self, corners: &[[u32; 3]], topology: &Topology) {
        if !self.adjacency.is_found() {
            self.adjacency = Adjacency::in_room(self.incomplete.spare_lists());
            self.adjacency.rebuild(corners, topology);
        }
    }

    /// Forgets them, and keeps their room where edits need it too: a body that is not torn has none of either.
    fn put_away_neighbours(&mut self) {
        if self.adjacency.is_found() {
            if self.edits.have_been() {
                self.adjacency.give_room(self.incomplete.spare_lists());
            } else {
                self.adjacency = Adjacency::default();
            }
        }
    }

    /// Factors again with a diagonal shift ten times as large, where a factor with `shift` is bad. Returns the new shift.
    fn refactor(&mut self, shift: f32) -> f32 {
        let shift = 10.0 * shift;
        self.incomplete.factor(&self.partition, self.order.dissection, &self.matrix, shift);
        shift
    }

    /// Whether what depends on the triangles is of these: no edit since has left others.
    fn is_of(&self, corners: &[[u32; 3]], topology: &Topology) -> bool {
        let Self { partition, order, followed, .. } = self;
        let is_sized = partition.triangle_count() == corners.len() && order.vertex.len() == topology.incident.len();
        let mut changed = edits::changed(partition, corners, (&topology.log, *followed), &order.vertex);
        is_sized && (*followed == topology.log.now() || changed.next().is_none())
    }

    /// Brings what depends on the triangles up to date where they have changed: a tear changes few of them. An order that is found anew
    /// is dissected if it `is_cut`.
    fn follow(&mut self, mesh: (&Vertices, &Triangles, &Topology), is_cut: bool) {
        let (_, Triangles { corners, .. }, topology) = mesh;
        let (is_of, now) = (self.is_of(corners, topology), topology.log.now());
        let since = std::mem::replace(&mut self.followed, now);
        if is_of {
            return;
        }
        // Another number of triangles without an edit: all are compared.
        let since = if since == now { Revision::default() } else { since };
        self.ready = None;
        self.put_away_neighbours();
        let Self { order, partition, edits, multigrid, .. } = self;
        let mut is_found = edits.find(partition, corners, (topology, since), order);
        if is_found {
            partition.rebuild(corners, &order.row);
            is_found = multigrid.follow(partition, order, mesh, edits);
        }
        if !is_found {
            self.find_neighbours(corners, topology);
            self.order.rebuild(corners, &self.adjacency, if is_cut { partition::cut(corners.len()) } else { 0 });
            self.partition.rebuild(corners, &self.order.row);
            self.multigrid.forget();
        }
        self.has_pattern &= is_found && self.needs_pattern;
        if self.has_pattern {
            self.incomplete.follow(&self.partition, &self.order, corners, topology, &self.edits);
        }
        self.needs_pattern = false;
    }

    /// Sets the right-hand side to the residual over its norm.
    fn set_residual(&mut self, residual: &[DVec3], norm: f64) {
        let vertex = &self.order.vertex;
        size(&mut self.vectors.xr, vertex.len(), [Vec4::ZERO; 2]);
        parallel::for_rows(&mut self.vectors.xr, |row, xr| {
            *xr = [Vec4::ZERO, (residual[vertex[row] as usize] / norm).as_vec3().extend(0.0)];
        });
    }

    fn iterate(&mut self, active: &mut ActivePreconditioner, limits: &Limits) -> Result<Reached, CgError> {
        let Self { matrix, partition, order, vectors, .. } = self;
        match active {
            ActivePreconditioner::Built(MixedPreconditioner::BlockJacobi) => {
                cg::solve(matrix, partition, &mut self.jacobi, vectors, limits)
            }
            ActivePreconditioner::Built(MixedPreconditioner::IncompleteCholesky) => {
                cg::solve(matrix, partition, &mut *self.incomplete, vectors, limits)
            }
            ActivePreconditioner::Built(MixedPreconditioner::Multigrid) => {
                cg::solve(matrix, partition, &mut *self.multigrid, vectors, limits)
            }
            ActivePreconditioner::Factor(factor, _) => {
                cg::solve(matrix, partition, &mut Factored { factor, order }, vectors, limits)
            }
        }
    }
}

/// Empties a list and makes room for `count` entries, with a sixteenth to spare, as tables have: as a tear adds some, the next steps
/// find it large enough. One that has to grow all the same gets an eighth.
fn empty<T>(list: &mut Vec<T>, count: usize) {
    list.clear();
    if list.capacity() < count {
        let spare = if list.capacity() == 0 { 64 + count / 16 } else { count / 8 };
        list.reserve_exact(count + spare);
    }
}

/// Gives a list `count` entries, all of which are to be written: those of before, or blank ones where there were more or fewer.
fn size<T: Clone>(list: &mut Vec<T>, count: usize, blank: T) {
    if list.len() != count {
        empty(list, count);
        list.resize(count, blank);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::components::Material;
    use crate::membrane::Membrane;
    use crate::settings::Settings;
    use crate::simulation::Simulation;
    use crate::storage::TriangleMesh;

    /// A solve that its guess ends at once finds an order and leaves the neighbours for who needs a pattern: not past the next edit.
    #[test]
    fn neighbours_are_those_of_the_present_triangles() {
        let mut simulation = Simulation::new(Settings { threads: 1, ..Settings::default() }).unwrap();
        let place = |v: u32| DVec3::new(f64::from(v % 21), f64::from(v / 21), 0.0);
        let cell = |i: u32| {
            let a = i / 20 * 21 + i % 20;
            [[a, a + 1, a + 22], [a, a + 22, a + 21]]
        };
        let (positions, triangles) = ((0..441).map(place).collect(), (0..400).flat_map(cell).collect());
        let mesh = TriangleMesh { positions, triangles, fibres: None };
        let body = simulation.spawn(Membrane::new("sheet", mesh, Material::figure_2())).unwrap();
        let mut solver = MixedSolver::default();
        let is_found = [4.3, 14.3].map(|y| {
            let mut tables = simulation.world().query_one::<(&Vertices, &Triangles, &Topology)>(body);
            solver.follow(tables.get().unwrap(), false);
            drop(tables);
            simulation.cut(body, &[DVec3::new(9.0, y, 0.0), DVec3::new(11.0, y + 0.3, 0.0)]).unwrap();
            solver.adjacency.is_found()
        });
        assert!(is_found == [true, false] && solver.edits.have_been());
    }
}

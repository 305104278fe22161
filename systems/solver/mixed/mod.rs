//! The solve of a dynamic step in mixed precision: residuals in double precision, iterations in single.
//!
//! State, loads and residuals are double. Conjugate gradients in single precision, on the residual scaled to one, find the
//! correction that it asks for. The correction is added, and the residual formed anew (Wilkinson 1963, iterative refinement). So
//! the answer is as good as that of double precision, and the residual reported is the true one. One round does at the tolerances
//! that a step is usually solved to; a tighter one takes several.

mod adjacency;
mod between;
mod cg;
mod cycle;
mod dissection;
mod edits;
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
mod rounds;
mod state;
mod vertex_blocks;

use super::Operator;
use crate::components::FreeAxes;
use crate::storage::{Revision, Topology, Triangles, Vertices};
use adjacency::Adjacency;
use cg::Vectors;
use edits::Edits;
use incomplete::Incomplete;
use jacobi::Jacobi;
use matrix::Matrix;
use multigrid::Multigrid;
use order::Order;
use partition::Partition;
pub use state::MixedState;

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

impl MixedPreconditioner {
    /// Whether rows may be ordered by nested dissection. Multigrid levels need neighbouring rows together; small bodies are solved on one thread.
    fn may_be_cut(self, operator: &Operator) -> bool {
        let is_by_levels = operator.is_planar() || self == Self::Multigrid;
        !is_by_levels && operator.triangles.len() >= LEAST_CUT
    }
}

/// A body's operator in single precision and the vectors of its solves. Data that depends on the triangles alone is kept while
/// they stay. *State*: data that do not follow from the body are saved.
#[derive(Debug, Default)]
pub struct MixedSolver {
    /// Moment in the triangles' history of which the rest is.
    followed: Revision,
    adjacency: Adjacency,
    // Many lists each: behind pointers, lest the world keeps room for them wherever it has room for bodies.
    order: Box<Order>,
    partition: Box<Partition>,
    matrix: Box<Matrix>,
    jacobi: Box<Jacobi>,
    incomplete: Box<Incomplete>,
    has_pattern: bool,
    /// Whether the pattern was asked for since the last edits.
    needs_pattern: bool,
    edits: Box<Edits>,
    multigrid: Box<Multigrid>,
    vectors: Box<Vectors>,
    /// Preconditioner of the last solve; `None` after a change of the triangles or once the operator is forgotten.
    ready: Option<MixedPreconditioner>,
    /// Whether the matrix and the incomplete factor have been made of the operator that several solves share.
    same: Option<[bool; 2]>,
}

impl MixedSolver {
    /// Begins or ends a series of solves with one operator and one set of free axes, which share its numbers.
    pub fn share(&mut self, is_same: bool) {
        self.same = is_same.then_some([false; 2]);
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
    fn set_up(&mut self, operator: &Operator, kind: MixedPreconditioner, shift: f32) {
        let corners = &operator.triangles.corners;
        match kind {
            MixedPreconditioner::BlockJacobi => self.jacobi.factor(&self.partition, &self.matrix),
            MixedPreconditioner::IncompleteCholesky => {
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
            MixedPreconditioner::Multigrid => {
                let mesh = (operator.vertices, operator.triangles, operator.topology);
                self.multigrid.set_up(&self.partition, &self.order, mesh, &self.matrix);
            }
        }
        self.put_away_neighbours();
        self.ready = Some(kind);
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

    /// Whether the data that depends on the triangles is of these: no edit since has left others.
    fn is_of(&self, corners: &[[u32; 3]], topology: &Topology) -> bool {
        let Self { partition, order, followed, .. } = self;
        let is_sized = partition.triangle_count() == corners.len() && order.vertex.len() == topology.incident.len();
        let mut changed = edits::changed(partition, corners, (&topology.log, *followed), &order.vertex);
        is_sized && (*followed == topology.log.now() || changed.next().is_none())
    }

    /// Updates the data that depends on the triangles where they have changed: a tear changes few of them. An order that is rebuilt
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
    use glam::DVec3;

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
        let body = simulation.spawn(Membrane::new("sheet", mesh, Material::allard_2009())).unwrap();
        let mut solver = MixedSolver::default();
        let is_found = [4.3, 14.3].map(|y| {
            let mut tables = simulation.world().query_one::<(&Vertices, &Triangles, &Topology)>(body.entity());
            solver.follow(tables.get().unwrap(), false);
            drop(tables);
            simulation.cut(body, &[DVec3::new(9.0, y, 0.0), DVec3::new(11.0, y + 0.3, 0.0)]).unwrap();
            solver.adjacency.is_found()
        });
        assert!(is_found == [true, false] && solver.edits.have_been());
    }
}

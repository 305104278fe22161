//! Multigrid: one V-cycle over coarser and coarser levels (Brandt 1977), none of which needs a grid or a chart of the surface.
//!
//! Coarse nodes are vertices of the mesh ([`coarsen`]), weights come from the rest shape and from distances along edges
//! ([`interpolation`]), operators are PᵀAP ([`galerkin`]), smoothing is one Gauss–Seidel sweep before and its adjoint after
//! ([`level`]). What a tear parts has no edge in common, and so no weights and no blocks: every side has nodes of its own, on all
//! levels.
//!
//! The cycle is that of the operator it was made for, all levels of it: it stays symmetric and positive however far the body
//! has moved on, and is made anew when that costs less than the iterations it would save.

mod coarsen;
mod coarsest;
mod galerkin;
mod interpolation;
mod level;

use super::cg::{Precondition, Vectors};
use super::empty;
use super::matrix::{Matrix, dot};
use super::order::Order;
use super::partition::Partition;
use crate::storage::{Topology, Triangles, Vertices};
use crate::systems::parallel;
use coarsen::Coarsening;
use coarsest::Coarsest;
use galerkin::Support;
use glam::{DVec2, DVec3};
use interpolation::{Parts, Place};
use level::Level;

/// Nodes of the coarsest level at the most: its dense factor then takes less than a millisecond.
const MOST_COARSEST: usize = 40;

/// A coarser level with more than this part of its nodes is not worth having: pieces that hang together by themselves.
const LEAST_GAIN: f64 = 0.7;

/// What one level hands to the next.
#[derive(Debug, Default)]
struct Transfer {
    coarsening: Coarsening,
    parts: Vec<Parts>,
    support: Support,
}

/// The levels, the finest first.
#[derive(Debug, Default)]
pub struct Multigrid {
    levels: Vec<Level>,
    /// From every level to the next.
    transfers: Vec<Transfer>,
    coarsest: Coarsest,
    places: Vec<Place>,
    is_boundary: Vec<bool>,
    state: State,
    /// Fewest iterations that a solve has taken since the numbers were taken, and by how many all others have exceeded it.
    fewest: u32,
    excess: u32,
}

/// What there is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum State {
    /// Nothing that could be used.
    #[default]
    Empty,
    /// Numbers of an earlier operator.
    Earlier,
    /// Those of the present one.
    Present,
}

/// To take the operator's numbers anew costs as much as so many iterations (5 to 8 from 5,000 to 150,000 triangles).
const RENEWAL: u32 = 8;

impl Multigrid {
    /// The triangles have changed.
    pub fn forget(&mut self) {
        self.state = State::Empty;
    }

    /// Before a solve: levels where there are none, and numbers where those of an earlier operator no longer serve.
    pub fn prepare(
        &mut self,
        partition: &Partition,
        order: &Order,
        mesh: (&Vertices, &Triangles, &Topology),
        matrix: &Matrix,
    ) {
        if self.state == State::Empty {
            self.rebuild(partition, order, mesh);
            self.assemble(partition, matrix);
        } else if self.excess >= RENEWAL || self.levels[0].free.iter().zip(&matrix.own).any(|(f, own)| *f != own[3]) {
            self.assemble(partition, matrix);
        }
    }

    /// Iterations of a round at the most: with more, numbers of an earlier operator are worse than new ones.
    pub fn most(&self) -> u32 {
        if self.state == State::Present { u32::MAX } else { 2 * self.fewest + RENEWAL }
    }

    /// After a solve.
    pub fn has_served(&mut self, iterations: u32) {
        // What is served from a good guess takes none: it tells nothing.
        if iterations == 0 {
            return;
        }
        self.state = State::Earlier;
        self.excess += iterations.saturating_sub(self.fewest);
        self.fewest = self.fewest.min(iterations);
    }

    /// The next solve takes the operator's numbers anew.
    pub fn expire(&mut self) {
        self.excess = RENEWAL;
    }

    /// Finds levels, weights and patterns anew.
    fn rebuild(
        &mut self,
        partition: &Partition,
        order: &Order,
        (vertices, triangles, topology): (&Vertices, &Triangles, &Topology),
    ) {
        let corners = &triangles.corners;
        let n = order.vertex.len();
        if self.levels.is_empty() {
            self.levels.push(Level::default());
        }
        self.levels[0].pattern.rebuild(partition, order, corners, topology);
        empty(&mut self.places, n);
        self.places.resize(n, Place::default());
        parallel::for_rows(&mut self.places, |row, place| {
            let v = order.vertex[row];
            let normal = |&entry: &u32| {
                let [a, b, c] = corners[entry as usize / 3].map(|v| vertices.rest_position[v as usize]);
                (b - a).cross(c - a)
            };
            let normal: DVec3 = topology.incident[v as usize].iter().map(normal).sum();
            *place = Place { position: vertices.rest_position[v as usize], normal: normal.normalize_or(DVec3::Z) };
        });
        empty(&mut self.is_boundary, n);
        self.is_boundary.extend(order.vertex.iter().map(|&v| topology.is_boundary_vertex(v)));
        let mut count = 1;
        loop {
            let fine = &self.levels[count - 1];
            let rows = fine.pattern.row_count();
            if rows <= MOST_COARSEST {
                break;
            }
            if self.transfers.len() < count {
                self.transfers.push(Transfer::default());
                self.levels.push(Level::default());
            }
            let Transfer { coarsening, parts, support } = &mut self.transfers[count - 1];
            let (fine, coarse) = self.levels.split_at_mut(count);
            let fine = &fine[count - 1].pattern;
            coarsening.rebuild(fine, &self.is_boundary);
            let nodes = coarsening.row.len();
            if nodes as f64 > LEAST_GAIN * rows as f64 {
                break;
            }
            interpolation::rebuild(parts, fine, &self.places, &coarsening.node);
            support.rebuild(parts, nodes);
            galerkin::rebuild_pattern(&mut coarse[0].pattern, fine, parts, support, nodes);
            for (node, &row) in coarsening.row.iter().enumerate() {
                self.places[node] = self.places[row as usize];
                self.is_boundary[node] = self.is_boundary[row as usize];
            }
            self.places.truncate(nodes);
            self.is_boundary.truncate(nodes);
            count += 1;
        }
        self.levels.truncate(count);
        self.transfers.truncate(count - 1);
    }

    /// Takes the operator's numbers.
    pub fn assemble(&mut self, partition: &Partition, matrix: &Matrix) {
        let Level { pattern, diagonal, lower, free, .. } = &mut self.levels[0];
        pattern.gather(partition, matrix, diagonal, lower);
        empty(free, matrix.own.len());
        free.extend(matrix.own.iter().map(|own| own[3]));
        self.levels[0].finish();
        for (i, Transfer { coarsening, parts, support }) in self.transfers.iter().enumerate() {
            let (fine, coarse) = self.levels.split_at_mut(i + 1);
            let (fine, coarse) = (&fine[i], &mut coarse[0]);
            galerkin::free_axes(&mut coarse.free, &fine.free, &coarsening.row);
            galerkin::assemble(coarse, fine, parts, support);
            coarse.finish();
        }
        (self.state, self.fewest, self.excess) = (State::Present, u32::MAX, 0);
        if let Some(last) = self.levels.last()
            && last.pattern.row_count() <= MOST_COARSEST
        {
            self.coarsest.factor(last);
        }
    }

    /// The answer of the levels from `first` on.
    fn descend_from(&mut self, first: usize) {
        let last = self.levels.len() - 1;
        for i in first..last {
            let (fine, coarse) = self.levels.split_at_mut(i + 1);
            smooth_down(&mut fine[i]);
            fine[i].restrict(&fine[i].x, &self.transfers[i].parts, &mut coarse[0].r);
        }
        let coarsest = &mut self.levels[last];
        if coarsest.pattern.row_count() <= MOST_COARSEST {
            self.coarsest.solve(&coarsest.r, &mut coarsest.x);
        } else {
            // Many pieces: no level is coarser. A symmetric sweep.
            smooth_down(coarsest);
            smooth_up(coarsest);
        }
        for i in (first..last).rev() {
            let (fine, coarse) = self.levels.split_at_mut(i + 1);
            level::prolong(&mut fine[i].x, &self.transfers[i].parts, &coarse[0].x);
            smooth_up(&mut fine[i]);
        }
    }
}

fn smooth_down(level: &mut Level) {
    let (mut x, r) = (std::mem::take(&mut level.x), std::mem::take(&mut level.r));
    level.forward(&mut x, |row, _| r[row]);
    (level.x, level.r) = (x, r);
}

fn smooth_up(level: &mut Level) {
    let (mut x, r) = (std::mem::take(&mut level.x), std::mem::take(&mut level.r));
    level.backward(&mut x, |row| r[row], |_, _| ());
    (level.x, level.r) = (x, r);
}

impl Precondition for Multigrid {
    fn descend(&mut self, alpha: f32, vectors: &mut Vectors) -> DVec2 {
        let Vectors { xr, p, q, z, .. } = vectors;
        let mut rr = 0.0;
        let mut rz = 0.0;
        self.levels[0].forward(z, |row, _| {
            let [x, r] = &mut xr[row];
            *x += p[row] * alpha;
            *r -= q[row] * alpha;
            rr += dot(*r, *r);
            *r
        });
        if self.levels.len() > 1 {
            let (fine, coarse) = self.levels.split_at_mut(1);
            fine[0].restrict(z, &self.transfers[0].parts, &mut coarse[0].r);
            self.descend_from(1);
            level::prolong(z, &self.transfers[0].parts, &self.levels[1].x);
        }
        self.levels[0].backward(z, |row| xr[row][1], |row, z| rz += dot(xr[row][1], z));
        DVec2::new(rr, rz)
    }

    fn ascend(&mut self, beta: f32, vectors: &mut Vectors) {
        let Vectors { p, z, .. } = vectors;
        parallel::for_rows(p, |row, p| *p = z[row] + *p * beta);
    }
}

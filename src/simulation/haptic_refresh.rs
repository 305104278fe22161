//! Models at a part of a step's cost, from data that the step's own solve has left.
//!
//! The operator A + K_g of the last solve and its preconditioner serve the tool as well: the response is then the motion within
//! one step. The answers U of the last models are the guess; each model improves one of the three in turn, by a few iterations, and
//! takes the best that all three together can do. With K = A + K_g and B = Uᵀ·K_g·E that is S = Eᵀ·K_g·E − Bᵀ·(Uᵀ·K·U)⁻¹·B
//! (Rayleigh, Ritz): the least energy among all their combinations. So it is symmetric, positive semidefinite, and between the
//! exact stiffness and the tool's own springs, however old the answers are.

use super::Simulation;
use super::haptic_feed::HapticModel;
use super::haptics::{Coupling, HapticError, Haptics, ToolSpring, positive};
use crate::components::SolverScratch;
use crate::storage::{BodyId, Topology, Triangles, VertexKey, Vertices};
use crate::systems::solver::{CgError, MixedSolver};
use glam::{DMat3, DVec3};

/// Iterations of a model at the most.
const MOST_MODEL_ITERATIONS: u32 = 3;

/// Estimated error of the stiffness, as part of it, from which on no more are spent: a hand feels some per cent, and the estimate of so few
/// iterations is no more than a guess.
const FELT: f64 = 2e-3;

/// A direction in which the answers have less than this part of the energy of the others counts as none.
const LEAST_ENERGY: f64 = 1e-9;

type Query<'a> = (&'a Vertices, &'a Triangles, &'a Topology, &'a SolverScratch, &'a mut MixedSolver);

impl Haptics {
    /// The model that follows the last one of the same tool on the same body, at a part of its cost. It is for motions within a
    /// step of the simulation, whatever the horizon. In three cases it has the stiffness of the last model and the present force:
    /// - after edits since the last solve, as at the end of a step that tears;
    /// - where that solve took nothing;
    /// - where that solve was in double precision.
    ///
    /// All is [made anew](Self::model) for another tool or other vertices, and for tools that the steps do not know or that hold by
    /// pins.
    ///
    /// # Errors
    /// As [`model`](Self::model).
    pub fn refresh(
        &mut self,
        simulation: &mut Simulation,
        body: BodyId,
        coupling: &Coupling,
    ) -> Result<HapticModel, HapticError> {
        let Coupling::Springs { springs, is_in_steps: true } = coupling else {
            return self.model(simulation, body, coupling);
        };
        let held = springs.iter().map(|spring| spring.vertex);
        let Some(last) = self.last.filter(|_| self.body == Some(body) && held.eq(self.held.iter().copied())) else {
            return self.model(simulation, body, coupling);
        };
        simulation.validate_dirty()?;
        let found = simulation.world.query_one_mut::<Query>(body.entity()).map_err(|_| HapticError::NoSuchBody)?;
        let (vertices, triangles, topology, scratch, mixed) = found;
        let (position, force) = self.take_springs(vertices, springs)?;
        let mut stiffness = last;
        self.work = 0;
        if mixed.has_operator_of(triangles, topology) && scratch.free.len() == vertices.len() {
            self.follow(vertices, triangles, topology);
            let improved = simulation.pool.run(|| self.improve(scratch, mixed, last));
            match improved {
                Ok(improved) if improved.is_finite() => stiffness = improved,
                _ => return self.model(simulation, body, coupling),
            }
        }
        if !force.is_finite() {
            return Err(HapticError::NoAnswer("a value that is not finite".to_owned()));
        }
        self.last = Some(stiffness);
        Ok(HapticModel { time: simulation.report.time, position, force, stiffness })
    }

    /// Work of the last model, in iterations and products of the body's operator: no more than six for one that
    /// [`refresh`](Self::refresh) has not had to make anew.
    pub fn work(&self) -> u32 {
        self.work
    }

    /// Notes whose vertices the answers are.
    pub(super) fn note(&mut self, body: BodyId, vertices: &[VertexKey], coupling: &Coupling, stiffness: DMat3) {
        (self.body, self.last) = (Some(body), Some(stiffness));
        self.keys.clear();
        self.keys.extend_from_slice(vertices);
        self.held.clear();
        if let Coupling::Springs { springs, .. } = coupling {
            self.held.extend(springs.iter().map(|ToolSpring { vertex, .. }| vertex));
        }
    }

    /// Brings the answers to the vertices as they are: new ones begin with the mean of their neighbours'.
    fn follow(&mut self, vertices: &Vertices, triangles: &Triangles, topology: &Topology) {
        if self.keys == vertices.keys() {
            return;
        }
        let mut row_before = vec![None; vertices.len()];
        for (before, &key) in self.keys.iter().enumerate() {
            if let Some(row) = vertices.row(key) {
                row_before[row as usize] = Some(before);
            }
        }
        for answer in &mut self.answers {
            let old = |v: usize| row_before[v].and_then(|before| answer.get(before)).copied();
            let of_neighbours = |v: usize| {
                let around = topology.incident[v].iter().flat_map(|&entry| triangles.corners[entry as usize / 3]);
                let (sum, count) = around
                    .filter_map(|w| old(w as usize))
                    .fold((DVec3::ZERO, 0_u32), |(sum, count), u| (sum + u, count + 1));
                sum / f64::from(count.max(1))
            };
            *answer = (0..vertices.len()).map(|v| old(v).unwrap_or_else(|| of_neighbours(v))).collect();
        }
        self.keys.clear();
        self.keys.extend_from_slice(vertices.keys());
    }

    /// Improves one of the answers and gives the stiffness \[N/mm\] that all of them make together; `last` is that of the last model.
    fn improve(&mut self, scratch: &SolverScratch, mixed: &mut MixedSolver, last: DMat3) -> Result<DMat3, CgError> {
        let Self { answers, forces, springs, turn, work, scratch: own, .. } = self;
        let (free, residual) = (&scratch.free, &mut own.residual);
        for (u, force) in answers.iter_mut().zip(forces.iter_mut()) {
            u.iter_mut().enumerate().for_each(|(v, u)| *u = if u.is_finite() { *u * free[v] } else { DVec3::ZERO });
            mixed.product(u, force);
            *work += 1;
        }
        let axis = *turn % 3;
        *turn = (axis + 1) % 3;
        let (u, force) = (&mut answers[axis], &mut forces[axis]);
        residual.clear();
        residual.extend(force.iter().map(|force| -*force));
        for &(v, stiffness) in &*springs {
            residual[v][axis] += stiffness * free[v][axis];
        }
        let taken = mixed.correct((FELT * last.col(axis)[axis], MOST_MODEL_ITERATIONS), residual, u)?;
        *work += taken;
        force.iter_mut().zip(&*residual).for_each(|(force, r)| *force = -*r);
        for &(v, stiffness) in &*springs {
            force[v][axis] += stiffness * free[v][axis];
        }
        Ok(self.least())
    }

    /// The stiffness of the best that the answers can do together.
    fn least(&self) -> DMat3 {
        let total: f64 = self.springs.iter().map(|(_, k)| k).sum();
        let inside = |i: usize, j: usize| -> f64 {
            self.answers[i].iter().zip(&self.forces[j]).map(|(u, force)| u.dot(*force)).sum()
        };
        let of_springs =
            |i: usize, j: usize| -> f64 { self.springs.iter().map(|&(v, k)| k * self.answers[i][v][j]).sum() };
        let matrix = |of: &dyn Fn(usize, usize) -> f64| {
            DMat3::from_cols_array_2d(&[0, 1, 2].map(|j| [0, 1, 2].map(|i| of(i, j))))
        };
        let energies = matrix(&|i, j| 0.5 * (inside(i, j) + inside(j, i)));
        let works = matrix(&of_springs);
        let least = LEAST_ENERGY * (energies.x_axis.x + energies.y_axis.y + energies.z_axis.z);
        let stiffness = if least > 0.0 {
            let raised = energies + DMat3::from_diagonal(DVec3::splat(least));
            DMat3::from_diagonal(DVec3::splat(total)) - works.transpose() * raised.inverse() * works
        } else {
            DMat3::from_diagonal(DVec3::splat(total))
        };
        positive((stiffness + stiffness.transpose()) * 0.5)
    }
}

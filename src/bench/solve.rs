//! One linear solve by itself, from a state of a scene: what the ladder of solvers is judged by.

use super::BenchError;
use super::clock::Stopwatch;
use super::errors::norm_sq;
use super::trace::nodal_stress;
use crate::components::{Frames, Increment, SolverScratch};
use crate::math::Sym2;
use crate::schedule::{STEP, Stage, System};
use crate::settings::{LinearParams, Precision, Preconditioner, Settings};
use crate::simulation::Simulation;
use crate::storage::{Topology, Triangles, Vertices};
use crate::systems::StepContext;
use crate::systems::linear::{Factor, InnerSolver};
use crate::systems::parallel::Pool;
use glam::DVec3;
use hecs::Entity;

/// A way to solve.
#[derive(Clone, Copy, Debug)]
pub struct Way {
    /// Name in tables.
    pub name: &'static str,
    pub preconditioner: Preconditioner,
    pub precision: Precision,
    /// Triangles of the largest body that it is measured on: beyond, minutes and many GB.
    pub most_triangles: usize,
}

/// All ways, from the plainest.
pub const WAYS: &[Way] = &[
    way("block Jacobi, double", Preconditioner::BlockJacobi, Precision::Double, 200_000),
    way("block Jacobi", Preconditioner::BlockJacobi, Precision::Mixed, usize::MAX),
    way("incomplete Cholesky", Preconditioner::IncompleteCholesky, Precision::Mixed, usize::MAX),
    way("Cholesky", Preconditioner::Cholesky, Precision::Mixed, 200_000),
];

const fn way(name: &'static str, preconditioner: Preconditioner, precision: Precision, most_triangles: usize) -> Way {
    Way { name, preconditioner, precision, most_triangles }
}

/// What a solve came to.
#[derive(Clone, Debug)]
pub struct Solved {
    /// Time of the solve alone, one thread \[ms\].
    pub ms: f64,
    pub iterations: u32,
    pub residual: f64,
}

/// A body on the brink of a solve: the step has begun and everything up to the solve is done.
pub struct Isolated {
    simulation: Simulation,
    body: Entity,
    pool: Pool,
    dt: f64,
    start: Vertices,
}

impl Isolated {
    /// The solve of a step of `dt` \[ms\] from the state that the simulation is in.
    pub fn new(simulation: Simulation, body: Entity, dt: f64) -> Result<Self, BenchError> {
        let pool = Pool::new(1, false).map_err(BenchError::State)?;
        let gone = |_| BenchError::State("the body is gone".to_owned());
        let start = Vertices::clone(&*simulation.world().get::<&Vertices>(body).map_err(gone)?);
        Ok(Self { simulation, body, pool, dt, start })
    }

    /// Forgets what earlier solves have left to be used again.
    pub fn forget(&mut self) {
        // The body lives: it was found when this was made.
        let _ = self.simulation.world_mut().insert(self.body, (Factor::default(), InnerSolver::default()));
    }

    /// Solves from a first guess of zero, with what earlier solves have left.
    pub fn solve(&mut self, way: &Way, linear: LinearParams) -> Solved {
        let Self { simulation, body, pool, dt, start } = self;
        let settings =
            Settings { linear, preconditioner: way.preconditioner, precision: way.precision, ..Settings::default() };
        let step = StepContext::of_step(&settings, *dt, simulation.time() + *dt);
        let world = simulation.world_mut();
        if let Ok((vertices, increment)) = world.query_one_mut::<(&mut Vertices, &mut Increment)>(*body) {
            vertices.position.copy_from_slice(&start.position);
            vertices.velocity.copy_from_slice(&start.velocity);
            increment.displacement.fill(DVec3::ZERO);
        }
        let is_before = |system: &&System| {
            matches!(system.stage, Stage::Begin | Stage::Iterate)
                && system.name != "refine"
                && !system.name.starts_with("energy: ")
        };
        let systems = || STEP.iter().filter(is_before);
        let ms = pool.run(|| {
            systems().take_while(|system| system.name != "solve").for_each(|system| {
                (system.run)(world, &step);
            });
            let mut ms = 0.0;
            for system in systems().skip_while(|system| system.name != "solve") {
                let watch = Stopwatch::start();
                (system.run)(world, &step);
                ms += if system.name == "solve" { watch.elapsed().thread } else { 0.0 };
            }
            ms
        });
        let scratch = world.get::<&SolverScratch>(*body);
        let (iterations, residual) = scratch.map_or((0, f64::NAN), |s| (s.iterations, s.linear_residual));
        Solved { ms, iterations, residual }
    }

    /// Stress at the vertices inside after the last solve \[MPa\].
    pub fn stress(&mut self) -> Vec<Sym2> {
        // The body lives.
        let _ = self.simulation.refresh(self.body);
        let mut query = self.simulation.world().query_one::<(&Triangles, &Topology, &Frames)>(self.body);
        let Ok((triangles, topology, frames)) = query.get() else { return Vec::new() };
        let mut stress = nodal_stress(triangles, topology, frames);
        for (v, stress) in stress.iter_mut().enumerate() {
            if topology.is_boundary_vertex(v as u32) {
                *stress = Sym2::default();
            }
        }
        stress
    }
}

/// Rms of the differences over rms of the reference.
pub fn relative(found: &[Sym2], exact: &[Sym2]) -> f64 {
    let off: f64 = found.iter().zip(exact).map(|(a, b)| norm_sq(*a - *b)).sum();
    (off / exact.iter().map(|s| norm_sq(*s)).sum::<f64>()).sqrt()
}

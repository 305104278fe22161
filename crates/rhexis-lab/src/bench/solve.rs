//! One linear solve by itself, from a state of a scene: what the ladder of solvers is judged by.

use super::BenchError;
use super::clock::Stopwatch;
use super::errors::norm_sq;
use super::trace::nodal_stress;
use glam::DVec3;
use rhexis::components::{Frames, Increment, SolveResult};
use rhexis::math::Sym2;
use rhexis::schedule::{STEP, Stage, System};
use rhexis::settings::{Advanced, LinearParams, Precision, Preconditioner, Settings};
use rhexis::simulation::Simulation;
use rhexis::storage::{BodyId, Topology, Triangles, Vertices};
use rhexis::systems::StepContext;
use rhexis::systems::parallel::Pool;
use rhexis::systems::solver::{Factor, MixedSolver};

/// A way to solve.
#[derive(Clone, Copy, Debug)]
pub(super) struct Way {
    /// Name in tables.
    pub name: &'static str,
    pub preconditioner: Preconditioner,
    pub precision: Precision,
    /// Triangles of the largest body that it is measured on: beyond, minutes and many GB.
    pub most_triangles: usize,
}

/// All ways, from the plainest.
pub(super) const WAYS: &[Way] = &[
    way("block Jacobi, double", Preconditioner::BlockJacobi, Precision::Double, 200_000),
    way("block Jacobi", Preconditioner::BlockJacobi, Precision::Mixed, usize::MAX),
    way("incomplete Cholesky", Preconditioner::IncompleteCholesky, Precision::Mixed, usize::MAX),
    way("multigrid", Preconditioner::Multigrid, Precision::Mixed, usize::MAX),
    way("Cholesky", Preconditioner::Cholesky, Precision::Mixed, 200_000),
];

const fn way(name: &'static str, preconditioner: Preconditioner, precision: Precision, most_triangles: usize) -> Way {
    Way { name, preconditioner, precision, most_triangles }
}

/// What a solve came to.
#[derive(Clone, Debug)]
pub(super) struct Solved {
    /// Time of the solve alone, one thread \[ms\].
    pub ms: f64,
    pub iterations: u32,
    pub residual: f64,
}

/// A body on the brink of a solve: the step has begun and everything up to the solve is done.
pub(super) struct Isolated {
    simulation: Simulation,
    body: BodyId,
    dt: f64,
    start: Vertices,
}

impl Isolated {
    /// The solve of a step of `dt` \[ms\] from the state that the simulation is in.
    pub(super) fn new(simulation: Simulation, body: BodyId, dt: f64) -> Result<Self, BenchError> {
        let start = one::<Vertices>(&simulation, body)?;
        Ok(Self { simulation, body, dt, start })
    }

    /// Forgets what earlier solves have left to be used again.
    pub(super) fn forget(&mut self) {
        // The body lives: it was found when this was made.
        let _ = self.simulation.world_mut().insert(self.body.entity(), (Factor::default(), MixedSolver::default()));
    }

    /// Solves from a first guess of zero, with what earlier solves have left.
    pub(super) fn solve(&mut self, way: &Way, linear: LinearParams) -> Result<Solved, BenchError> {
        let Self { simulation, body, dt, start } = self;
        if let Ok((vertices, increment)) =
            simulation.world_mut().query_one_mut::<(&mut Vertices, &mut Increment)>(body.entity())
        {
            vertices.position.copy_from_slice(&start.position);
            vertices.velocity.copy_from_slice(&start.velocity);
            increment.displacement.fill(DVec3::ZERO);
        }
        solve(simulation, *body, *dt, &way.settings(linear))
    }

    /// Stress at the vertices inside after the last solve \[MPa\].
    pub(super) fn stress(&mut self) -> Vec<Sym2> {
        stress(&mut self.simulation, self.body)
    }
}

impl Way {
    fn settings(&self, linear: LinearParams) -> Settings {
        Settings {
            budget: None,
            advanced: Advanced {
                linear,
                preconditioner: self.preconditioner,
                precision: self.precision,
                ..Advanced::default()
            },
            ..Settings::default()
        }
    }
}

/// Error of the solve of a simulation's next step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct StepError {
    /// Of stress at interior vertices, relative.
    pub stress: f64,
    /// Largest distance of a vertex \[mm\].
    pub position: f64,
}

impl StepError {
    /// Solves the next step, from the same state and the same guess, as the simulation's settings say and as exactly as can be,
    /// and puts everything back. A step that is nearly a static problem forgets what was before: what the steps so far have left
    /// undone is in this error.
    pub(super) fn of(simulation: &mut Simulation, body: BodyId, dt: f64) -> Result<Self, BenchError> {
        let settings = *simulation.settings();
        let (found, found_positions) = tried(simulation, body, dt, &settings)?;
        let kept = simulation.world_mut().remove::<(Factor, MixedSolver)>(body.entity()).map_err(gone)?;
        simulation.world_mut().insert(body.entity(), (Factor::default(), MixedSolver::default())).map_err(gone)?;
        let tight = LinearParams::by_residual(1e-10, 100_000);
        let exact = tried(
            simulation,
            body,
            dt,
            &Settings {
                budget: None,
                advanced: Advanced { preconditioner: Preconditioner::Cholesky, linear: tight, ..settings.advanced },
                ..settings
            },
        );
        simulation.world_mut().insert(body.entity(), kept).map_err(gone)?;
        let (exact, exact_positions) = exact?;
        let distances = found_positions.iter().zip(&exact_positions).map(|(a, b)| a.distance(*b));
        Ok(Self { stress: relative(&found, &exact), position: distances.fold(0.0, f64::max) })
    }
}

/// Stress and positions after the solve of the next step; the state is then as it was.
fn tried(
    simulation: &mut Simulation,
    body: BodyId,
    dt: f64,
    settings: &Settings,
) -> Result<(Vec<Sym2>, Vec<DVec3>), BenchError> {
    let start = (one::<Vertices>(simulation, body)?, one::<Increment>(simulation, body)?);
    solve(simulation, body, dt, settings)?;
    let found = (stress(simulation, body), one::<Vertices>(simulation, body)?.position);
    simulation.world_mut().insert(body.entity(), start).map_err(gone)?;
    Ok(found)
}

/// The systems of a step up to the one that moves the body, on one thread; neither refines nor tears it.
fn solve(simulation: &mut Simulation, body: BodyId, dt: f64, settings: &Settings) -> Result<Solved, BenchError> {
    let step = StepContext::of_step(settings, dt, simulation.time() + dt);
    let pool = Pool::new(1, settings.portable_instructions).map_err(BenchError::State)?;
    let world = simulation.world_mut();
    let is_run = |system: &&System| {
        matches!(system.stage, Stage::Begin | Stage::Evaluate | Stage::Solve)
            && system.name != "refine"
            && !system.name.starts_with("energy audit: ")
    };
    let ms = pool.run(|| {
        let mut ms = 0.0;
        for system in STEP.iter().filter(is_run) {
            let watch = Stopwatch::start();
            (system.run)(world, &step);
            if system.name == "solve" {
                ms = watch.elapsed().thread;
            }
        }
        ms
    });
    let result = world.get::<&SolveResult>(body.entity()).map_err(gone)?;
    Ok(Solved { ms, iterations: result.iterations, residual: result.linear_residual })
}

/// Stress at the vertices inside \[MPa\], zero on the boundary.
fn stress(simulation: &mut Simulation, body: BodyId) -> Vec<Sym2> {
    // The body lives: it was stepped just now.
    let _ = simulation.refresh(body);
    let mut query = simulation.world().query_one::<(&Triangles, &Topology, &Frames)>(body.entity());
    let Ok((triangles, topology, frames)) = query.get() else { return Vec::new() };
    let mut stress = nodal_stress(triangles, topology, frames);
    for (v, stress) in stress.iter_mut().enumerate() {
        if topology.is_boundary_vertex(v as u32) {
            *stress = Sym2::default();
        }
    }
    stress
}

fn one<T: hecs::Component + Clone>(simulation: &Simulation, body: BodyId) -> Result<T, BenchError> {
    simulation.world().get::<&T>(body.entity()).map(|component| T::clone(&component)).map_err(gone)
}

fn gone(error: impl std::fmt::Display) -> BenchError {
    BenchError::State(format!("a body of the benchmark: {error}"))
}

/// Rms of the differences over rms of the reference.
pub(super) fn relative(found: &[Sym2], exact: &[Sym2]) -> f64 {
    let off: f64 = found.iter().zip(exact).map(|(a, b)| norm_sq(*a - *b)).sum();
    (off / exact.iter().map(|s| norm_sq(*s)).sum::<f64>()).sqrt()
}

//! Runs a sheet by a soft body of rapier: `rhexis-peer-rapier PROBLEM OUT SOLVER SUBSTEPS NUMBER`.
//!
//! `PROBLEM` is a text of numbers (`problem` in `engines/rapier.py`); `OUT` gets the processor time of every step and the positions after
//! every compared one. `SOLVER` is `fem`, where `NUMBER` is the number of conjugate-gradient iterations, or `constraints`, where it is
//! the number of Gauss–Seidel sweeps beside the first.

use cpu_time::ProcessTime;
use rapier2d::prelude::*;
use std::error::Error;
use std::fs;
use std::str::{FromStr, SplitAsciiWhitespace};

/// The scene on one mesh.
struct Problem {
    points: Vec<Vector>,
    masses: Vec<Real>,
    triangles: Vec<[u32; 3]>,
    held: Vec<u32>,
    driven: Vec<u32>,
    young: Real,
    poisson: Real,
    dt: Real,
    hand: Vec<Real>,
    /// Steps after which positions are compared, counted from 1.
    samples: Vec<usize>,
}

/// Reads numbers one after another.
struct Words<'a>(SplitAsciiWhitespace<'a>);

impl Words<'_> {
    fn next<T: FromStr<Err: Error + 'static>>(&mut self) -> Result<T, Box<dyn Error>> {
        Ok(self.0.next().ok_or("the problem ends early")?.parse()?)
    }

    /// A list after its length.
    fn list<T: FromStr<Err: Error + 'static>>(&mut self) -> Result<Vec<T>, Box<dyn Error>> {
        let count: usize = self.next()?;
        (0..count).map(|_| self.next()).collect()
    }
}

impl Problem {
    fn read(text: &str) -> Result<Self, Box<dyn Error>> {
        let mut words = Words(text.split_ascii_whitespace());
        Ok(Self {
            points: words.list()?.as_chunks().0.iter().map(|&[x, y]| Vector::new(x, y)).collect(),
            masses: words.list()?,
            triangles: words.list()?.as_chunks().0.to_vec(),
            held: words.list()?,
            driven: words.list()?,
            young: words.next()?,
            poisson: words.next()?,
            dt: words.next()?,
            hand: words.list()?,
            samples: words.list()?,
        })
    }
}

/// Processor times of all steps \[s\], and positions after the compared ones.
fn run(problem: &Problem, is_fem: bool, substeps: usize, number: usize) -> (Vec<f64>, Vec<f64>) {
    let material = SoftBodyMaterial {
        young_modulus: problem.young,
        poisson_ratio: problem.poisson,
        // Implicit Euler steps damp by themselves; the sweeps of constraints need the critical damping.
        elastic_damping_ratio: if is_fem { 0.0 } else { 1.0 },
        ..Default::default()
    };
    let builder = SoftBodyBuilder::new(problem.points.clone())
        .masses(problem.masses.clone())
        .cells(problem.triangles.clone())
        .cell_model(SoftBodyCellModel::Corotational)
        .material(material)
        .solver(if is_fem { SoftBodySolver::Fem } else { SoftBodySolver::Constraints })
        .pinned_particles(problem.held.iter().chain(&problem.driven).copied())
        .no_surface_collider()
        .gravity_scale(0.0)
        .additional_pgs_iterations(if is_fem { 0 } else { number })
        .can_sleep(false);
    let (mut bodies, mut colliders) = (RigidBodySet::new(), ColliderSet::new());
    let (mut soft_bodies, mut islands) = (SoftBodySet::new(), IslandManager::new());
    let (mut joints, mut multibody_joints) = (ImpulseJointSet::new(), MultibodyJointSet::new());
    let (mut broad_phase, mut narrow_phase) = (BroadPhaseBvh::new(), NarrowPhase::new());
    let (mut pipeline, mut ccd) = (PhysicsPipeline::new(), CCDSolver::new());
    let sheet = soft_bodies.insert(builder, &mut bodies, &mut colliders);

    let mut parameters = IntegrationParameters { num_solver_iterations: substeps, ..Default::default() };
    parameters.dt = problem.dt;
    parameters.soft_bodies.max_extra_substeps = 0;
    parameters.soft_bodies.fem.linear_tolerance = 1e-10;
    parameters.soft_bodies.fem.max_linear_iterations = number;
    parameters.soft_bodies.fem.max_dense_dofs = 0;

    let (mut seconds, mut positions) = (Vec::new(), Vec::new());
    for (step, &pull) in problem.hand.iter().enumerate() {
        let body = &mut soft_bodies[sheet];
        for &vertex in &problem.driven {
            let (vertex, place) = (vertex as usize, problem.points[vertex as usize] + Vector::new(pull, 0.0));
            // The solver `Fem` takes the particle's velocity for the motion, which a target alone sets a step later.
            body.set_particle_velocity(vertex, (place - body.particle_position(vertex)) / problem.dt);
            body.set_particle_kinematic_target(vertex, place);
        }
        let begin = ProcessTime::now();
        pipeline.step(
            Vector::ZERO,
            &parameters,
            &mut islands,
            &mut broad_phase,
            &mut narrow_phase,
            &mut bodies,
            &mut colliders,
            &mut joints,
            &mut multibody_joints,
            &mut soft_bodies,
            &mut ccd,
            &(),
            &(),
        );
        seconds.push(begin.elapsed().as_secs_f64());
        if problem.samples.contains(&(step + 1)) {
            positions.extend(soft_bodies[sheet].particle_positions().flat_map(|place| [place.x, place.y].map(f64::from)));
        }
    }
    (seconds, positions)
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [problem, out, solver, substeps, number] = arguments.as_slice() else {
        return Err("five arguments are due: PROBLEM OUT SOLVER SUBSTEPS NUMBER".into());
    };
    let is_fem = match solver.as_str() {
        "fem" => true,
        "constraints" => false,
        other => return Err(format!("{other} is neither fem nor constraints").into()),
    };
    let problem = Problem::read(&fs::read_to_string(problem)?)?;
    let (seconds, positions) = run(&problem, is_fem, substeps.parse()?, number.parse()?);
    let bytes: Vec<u8> = seconds.iter().chain(&positions).flat_map(|number| number.to_le_bytes()).collect();
    Ok(fs::write(out, bytes)?)
}

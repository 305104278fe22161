//! The simulation: bodies in a world, stepped on request. It owns no loop, no window and no global.

mod advance;
mod blade;
mod debug_lines;
mod error;
mod fixed_step;
mod frame;
mod haptic_feed;
mod haptics;
mod motion;
mod obstacles;
mod pin;
mod probe;
mod query;
mod record;
mod reorder;
mod sleep;
mod snapshot;
mod systems;
mod tear;
mod tools;
mod view;

pub use crate::components::Energies;
pub use debug_lines::{DebugKind, DebugLine, DebugLines};
pub use error::SimulationError;
#[cfg(feature = "snapshot")]
pub(crate) use error::check_settings;
pub use fixed_step::FixedStep;
pub use haptic_feed::{HapticModel, HapticReceiver, HapticSender, haptic_feed};
pub use haptics::{Coupling, HapticError, Haptics, ToolSpring};
pub use motion::MotionError;
pub use pin::{Pin, PinError};
pub use probe::TipAnswer;
pub use query::Hit;
pub use tear::{Cut, CutError};
pub use tools::{Grasp, ToolError};
pub use view::{BodyView, normals};

use crate::components::{
    Bending, Body, EnergyAudit, EnergyBalance, Frames, Holds, Planar, PreStretch, Reactions, Sleeping, SolverScratch,
    StiffeningFibres,
};
use crate::event::{Event, EventKind};
use crate::membrane::{BodyError, Membrane};
use crate::replay::{Input, Recorder};
use crate::report::{BodyReport, Fault, Report};
use crate::schedule::Schedule;
use crate::settings::{Integrator, Precision, Settings, Tangent};
use crate::storage::{Tips, Topology, Triangles, Vertices};
use crate::systems::kernels::membrane;
use crate::systems::linear::Folds;
use crate::systems::parallel::Pool;
use crate::systems::{Formula, StepContext, corotation};
use advance::{Aside, Running, advance, is_finite, iterate_and_account, restore};
use glam::DVec3;
use hecs::{Entity, World};

/// Bodies, obstacles and time.
pub struct Simulation {
    world: World,
    settings: Settings,
    pool: Pool,
    schedule: Schedule,
    report: Report,
    events: Vec<Event>,
    next_order: u32,
    recorder: Option<Recorder>,
    /// See [`Running`].
    spare: Vec<Aside>,
}

impl Simulation {
    /// An empty world at time zero.
    ///
    /// # Errors
    /// For a tolerance below zero or not finite (the stress tolerance may be infinite), for more than 1024 threads, and if the system grants no threads.
    pub fn new(settings: Settings) -> Result<Self, SimulationError> {
        error::check_settings(&settings)?;
        let pool = Pool::new(settings.threads, settings.portable_instructions).map_err(SimulationError::Threads)?;
        let (world, report, events) = (World::new(), Report::default(), Vec::new());
        let schedule = Schedule::default();
        Ok(Self { world, settings, pool, schedule, report, events, next_order: 0, recorder: None, spare: Vec::new() })
    }

    /// Puts a body into the world.
    ///
    /// # Errors
    /// If its mesh, material or components are refused; the world is unchanged then.
    pub fn spawn(&mut self, membrane: Membrane) -> Result<Entity, BodyError> {
        let mut components = membrane.build(self.next_order)?;
        self.next_order += 1;
        let body = self.world.spawn(components.build());
        self.note_spawned(body);
        Ok(body)
    }

    /// Takes a body, an obstacle or a tool out of the world.
    ///
    /// # Errors
    /// If there is none.
    pub fn despawn(&mut self, entity: Entity) -> Result<(), SimulationError> {
        self.note(|| Input::Despawn(entity));
        // Whatever forceps hold they let go of.
        let _ = self.release(entity);
        self.world.despawn(entity).map_err(|_| SimulationError::NoSuchBody)
    }

    /// The world, to look at.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The settings.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Changes how the next steps are solved: all settings but the threads and their instructions, which stay as they are.
    ///
    /// # Errors
    /// For a tolerance below zero or not finite (the stress tolerance may be infinite); nothing has changed then.
    pub fn set_settings(&mut self, settings: Settings) -> Result<(), SimulationError> {
        error::check_settings(&settings)?;
        self.note(|| Input::SetSettings(settings));
        let Settings { threads, portable_instructions, .. } = self.settings;
        self.settings = Settings { threads, portable_instructions, ..settings };
        Ok(())
    }

    /// Time reached \[ms\].
    pub fn time(&self) -> f64 {
        self.report.time
    }

    /// What the last step did.
    pub fn report(&self) -> &Report {
        &self.report
    }

    /// Number of threads that a step uses.
    pub fn thread_count(&self) -> usize {
        self.pool.thread_count()
    }

    /// Takes the events since the last call, in order.
    pub fn drain_events(&mut self) -> std::vec::Drain<'_, Event> {
        self.events.drain(..)
    }

    /// The bodies in order of spawning.
    pub fn bodies(&self) -> Vec<Entity> {
        let mut bodies: Vec<(u32, Entity)> =
            self.world.query::<(Entity, &Body)>().iter().map(|(e, b)| (b.order, e)).collect();
        bodies.sort_unstable_by_key(|&(order, _)| order);
        bodies.into_iter().map(|(_, entity)| entity).collect()
    }

    /// Moves the world on by `dt` \[ms\] as the [settings](Settings) say: by default linearly implicit backward Euler. A step that
    /// leaves a state which is not finite or has created energy is undone and retried in halves; if that fails too, the last good state
    /// stays and the report says so.
    ///
    /// # Errors
    /// For a `dt` that is not a positive finite number, and for a body with an [`EnergyAudit`] where the integrator is not backward
    /// Euler; nothing has changed then.
    pub fn step(&mut self, dt: f64) -> Result<&Report, SimulationError> {
        self.step_with(dt, &[])
    }

    /// A step whose solves stop where `stops` say, if anything, and not by the clock.
    fn step_with(&mut self, dt: f64, stops: &[Vec<u32>]) -> Result<&Report, SimulationError> {
        self.note(|| Input::Step { dt, stops: Vec::new() });
        if !(dt > 0.0 && (self.report.time + dt).is_finite()) {
            return Err(SimulationError::TimeStep(dt));
        }
        if self.settings.integrator != Integrator::BackwardEuler
            && let Some((body, _)) = self.world.query_mut::<(&Body, &EnergyAudit)>().into_iter().next()
        {
            return Err(SimulationError::AuditOfAnotherIntegrator { body: body.name.clone() });
        }
        // As many as in the step before.
        let rows = self.report.bodies.iter().filter(|body| !body.is_asleep).map(|body| body.triangle_count).sum();
        self.begin_report();
        self.begin_stops(stops);
        let Self { world, settings, pool, schedule, report, spare, .. } = self;
        let (time, mut running) = (report.time, Running { schedule, report, spare });
        let done = pool.run_step(rows, || advance(world, settings, time, dt, &mut running));
        self.report.time += done;
        self.finish_report();
        self.report.has_failed = self.report.bodies.iter().any(|body| body.fault.is_some());
        self.note_stops();
        self.rest_obstacles();
        self.note_unfinished_tears();
        self.collect_events();
        if self.report.has_failed {
            let (step, time) = (self.report.step, self.report.time);
            let failed = |(body, fault): (Entity, Fault)| {
                let reason = format!("no part of the step of {dt} ms led on to a sound state: {fault}");
                Event { step, time, body, kind: EventKind::StepFailed { reason } }
            };
            let faults = self.report.bodies.iter().filter_map(|body| Some((body.body, body.fault?)));
            self.events.extend(faults.map(failed));
        }
        Ok(&self.report)
    }

    /// Moves time on by `dt` \[ms\] and finds the static equilibrium there by Newton's method with the exact tangent, to
    /// `tolerance`: the largest free nodal imbalance over the largest corner force, or to what rounding allows.
    ///
    /// # Errors
    /// For a `dt` or a tolerance that is negative or not finite, and where no equilibrium is found; the state is then the one
    /// before, and time has not moved.
    pub fn settle(&mut self, dt: f64, tolerance: f64) -> Result<&Report, SimulationError> {
        self.note(|| Input::Settle { dt, tolerance });
        self.find_equilibrium(dt, tolerance)
    }

    fn find_equilibrium(&mut self, dt: f64, tolerance: f64) -> Result<&Report, SimulationError> {
        if !(dt >= 0.0 && (self.report.time + dt).is_finite()) {
            return Err(SimulationError::TimeStep(dt));
        }
        error::check_tolerance("the tolerance", tolerance)?;
        self.begin_report();
        let iterations = self.settings.static_iterations.max(2);
        let (time, preconditioner) = (self.report.time + dt, self.settings.preconditioner);
        let step = StepContext::of_static_solve(dt, time, tolerance, iterations, preconditioner);
        let Self { world, pool, schedule, report, spare, .. } = self;
        let mut running = Running { schedule, report, spare };
        pool.run(|| iterate_and_account(world, &step, &mut running));
        self.finish_report();
        let is_finite = is_finite(&mut self.world);
        let failed = self.report.bodies.iter().filter(|b| !(b.is_converged && is_finite));
        let worst = failed.map(|b| (b.imbalance, b.newton_iterations));
        if let Some((imbalance, iterations)) = worst.max_by(|a, b| a.0.total_cmp(&b.0)) {
            restore(&mut self.world);
            self.report.has_failed = true;
            return Err(SimulationError::NoEquilibrium { time: step.time, imbalance, iterations });
        }
        self.report.time = step.time;
        self.rest_obstacles();
        self.collect_events();
        Ok(&self.report)
    }

    /// Moves time on by `dt` \[ms\] and answers the loads and prescribed motion there linearly: one increment with the exact
    /// tangent of the present state, without inertia. From rest this is the solution of linear elasticity on the mesh.
    ///
    /// # Errors
    /// For a `dt` that is negative or not finite, and where the linear solve does not reach a residual of 1e-13; the state is
    /// then the one before, and time has not moved.
    pub fn linear_response(&mut self, dt: f64) -> Result<&Report, SimulationError> {
        self.note(|| Input::LinearResponse { dt });
        if !(dt >= 0.0 && (self.report.time + dt).is_finite()) {
            return Err(SimulationError::TimeStep(dt));
        }
        self.begin_report();
        let linear = crate::settings::LinearParams::by_residual(1e-13, 50_000);
        let step = StepContext {
            dt: if dt > 0.0 { dt } else { 1.0 },
            time: self.report.time + dt,
            formula: Formula::BackwardEuler,
            is_static: true,
            is_resumed: false,
            is_last_resort: false,
            tangent: Tangent::Exact,
            linear,
            preconditioner: self.settings.preconditioner,
            precision: Precision::Double,
            newton_iterations: 1,
            newton_tolerance: 0.0,
        };
        let Self { world, pool, schedule, report, spare, .. } = self;
        let mut running = Running { schedule, report, spare };
        pool.run(|| iterate_and_account(world, &step, &mut running));
        self.finish_report();
        let residual = self.report.bodies.iter().map(|b| b.residual).max_by(f64::total_cmp).unwrap_or(0.0);
        let has_failed = residual.is_nan() || residual > linear.tolerance;
        if has_failed || !is_finite(&mut self.world) {
            restore(&mut self.world);
            self.report.has_failed = true;
            return Err(SimulationError::NoLinearAnswer { time: step.time, residual });
        }
        self.report.time = step.time;
        Ok(&self.report)
    }

    /// Energies of a body now.
    ///
    /// # Errors
    /// If there is no such body.
    pub fn energies(&mut self, body: Entity) -> Result<Energies, SimulationError> {
        self.refresh(body)?;
        type Query<'a> = (
            (&'a Vertices, &'a Triangles, &'a Topology, &'a Frames),
            (Option<&'a PreStretch>, Option<&'a StiffeningFibres>),
            (Option<&'a Bending>, Option<&'a Folds>),
        );
        let mut query = self.world.query_one::<Query>(body);
        let ((vertices, triangles, topology, frames), (pre_stretch, fibres), (bending, folds)) =
            query.get().map_err(|_| SimulationError::NoSuchBody)?;
        let law = (frames.is_planar(), PreStretch::unstretched(pre_stretch), fibres);
        let elastic = frames.states().enumerate().map(|(t, state)| {
            let twice = membrane::twice_energy(&state, &triangles.stiffness[t], law);
            0.5 * triangles.rest[t].area * triangles.thickness[t] * twice
        });
        let kinetic = vertices.velocity.iter().zip(&vertices.mass).map(|(v, m)| 0.5 * m * v.length_squared());
        let body = (vertices, triangles, topology);
        let bent = bending.map_or(0.0, |bending| Folds::energy_at(body, bending, folds, &vertices.position));
        Ok(Energies { elastic: elastic.sum::<f64>() + bent, kinetic: kinetic.sum() })
    }

    /// The energy balance of a body since its first step; `None` for one without an [`EnergyAudit`].
    ///
    /// # Errors
    /// If there is no such body.
    pub fn energy_balance(&mut self, body: Entity) -> Result<Option<EnergyBalance>, SimulationError> {
        let energies = self.energies(body)?;
        Ok(self.world.get::<&EnergyAudit>(body).ok().map(|audit| audit.balance(energies)))
    }

    /// Sum of the forces \[N\] that a body's holds exert on it, one per hold, from the last step; zero before the first.
    ///
    /// # Errors
    /// If there is no such body.
    pub fn reactions(&self, body: Entity) -> Result<Vec<(String, DVec3)>, SimulationError> {
        let mut query = self.world.query_one::<(&Body, Option<(&Holds, &Reactions)>)>(body);
        let (_, held) = query.get().map_err(|_| SimulationError::NoSuchBody)?;
        let Some((holds, reactions)) = held else { return Ok(Vec::new()) };
        let sum = |group: usize| reactions.groups.get(group).map_or(DVec3::ZERO, |forces| forces.iter().sum());
        Ok(holds.groups.iter().enumerate().map(|(group, hold)| (hold.name.clone(), sum(group))).collect())
    }

    /// Brings [`Frames`] up to the current positions: stresses for whoever looks between steps.
    ///
    /// # Errors
    /// If there is no such body.
    pub fn refresh(&mut self, body: Entity) -> Result<(), SimulationError> {
        type Query<'a> = (
            (&'a Vertices, &'a Triangles, &'a mut Frames),
            (Option<&'a Planar>, Option<&'a PreStretch>, Option<&'a StiffeningFibres>),
        );
        let found = self.world.query_one_mut::<Query>(body).map_err(|_| SimulationError::NoSuchBody)?;
        let ((vertices, triangles, frames), (planar, pre_stretch, fibres)) = found;
        self.pool.run(|| corotation::evaluate(vertices, triangles, frames, planar.is_some(), pre_stretch, fibres));
        Ok(())
    }

    fn begin_report(&mut self) {
        self.schedule.reset_reports(&mut self.report.systems);
        self.report.rolled_back = 0;
        self.report.has_failed = false;
    }

    fn finish_report(&mut self) {
        self.report.step += 1;
        let Self { world, report, .. } = self;
        report.bodies.clear();
        type Query<'a> =
            (Entity, (&'a Vertices, &'a Triangles, Option<&'a Tips>), &'a SolverScratch, Option<&'a Sleeping>);
        for (body, (vertices, triangles, tips), scratch, sleeping) in &mut world.query::<Query>().with::<&Body>() {
            report.bodies.push(BodyReport {
                body,
                vertex_count: vertices.len(),
                triangle_count: triangles.len(),
                tip_count: tips.map_or(0, Tips::len),
                iterations: scratch.iterations,
                newton_iterations: scratch.newton_iterations,
                residual: scratch.linear_residual,
                stress_error: scratch.stress_error,
                is_late: scratch.is_late,
                imbalance: scratch.imbalance,
                is_converged: scratch.is_converged,
                fell_back: scratch.fell_back,
                is_tear_cut_short: false,
                is_held_back: scratch.is_held_back,
                fault: scratch.fault,
                is_asleep: sleeping.is_some_and(Sleeping::is_asleep),
            });
        }
        report.bodies.sort_unstable_by_key(|report| order(world, report.body));
    }
}

/// A body's place in the order of spawning.
fn order(world: &World, body: Entity) -> u32 {
    world.get::<&Body>(body).map_or(u32::MAX, |about| about.order)
}

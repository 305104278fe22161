//! The simulation: bodies in a world, stepped on request. It owns no loop, no window and no global.

mod advice;
mod apply_force;
mod bed;
mod blade;
mod compartment;
mod debug_lines;
mod dirty;
mod doubts;
mod equilibrium;
mod error;
mod fixed_step;
mod frame;
mod haptic_blend;
mod haptic_feed;
mod haptic_refresh;
mod haptics;
mod inspect;
mod material;
mod material_force;
mod measure;
mod motion;
mod obstacles;
mod pin;
mod probe;
mod query;
mod record;
mod reorder;
mod reporting;
mod section;
mod set;
mod sleep;
mod snapshot;
mod solid_frames;
mod systems;
mod tear;
mod tools;
mod view;

#[doc(hidden)]
pub use crate::components::{Energies, Grasp};
pub use crate::registry::{Parameter, Rejected};
pub use crate::systems::fracture::TearRefusal;
pub use apply_force::ForceError;
pub use bed::Bed;
pub use debug_lines::{DebugKind, DebugLine, DebugLines};
pub use doubts::{Doubt, DoubtKind};
pub use error::{SimulationError, SpawnError};
pub use fixed_step::FixedStep;
pub use haptic_blend::HapticBlend;
pub use haptic_feed::{HapticModel, HapticReceiver, HapticSender, haptic_feed};
pub use haptics::{Coupling, HapticError, Haptics, ToolSpring};
pub use inspect::{Fragments, Tip};
pub use material_force::TipForce;
pub use motion::MotionError;
pub use obstacles::Solid;
pub use pin::{Pin, PinError};
pub use probe::Reading;
pub use query::Hit;
pub use section::Section;
pub use set::SetError;
pub use tear::{Cut, CutError};
pub use tools::ToolError;
pub use view::{BodyView, normals};

use crate::components::{Body, EnergyAudit};
use crate::event::{Event, EventKind};
use crate::membrane::Membrane;
use crate::replay::{Input, Recorder};
use crate::report::{Fault, Report};
use crate::settings::{Integrator, Settings};
use crate::storage::BodyId;
use crate::systems::StepContext;
use crate::systems::parallel::Pool;
use crate::systems::step::retry::advance;
use crate::systems::step::run::{Excluded, Running};
use crate::systems::step::schedule::Schedule;
use dirty::Dirty;
use hecs::{Entity, World};
use reporting::order;

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
    dirty: Dirty,
    /// See [`Running`].
    spare: Vec<Excluded>,
}

impl Simulation {
    /// An empty world at time zero.
    ///
    /// # Errors
    /// For a tolerance below zero or not finite (the stress tolerance may be infinite), for more than 1024 threads, and if the system grants no threads.
    ///
    /// # Examples
    /// ```
    /// use rhexis::prelude::*;
    ///
    /// let simulation = Simulation::new(Settings::new(Accuracy::Game))?;
    /// assert_eq!(simulation.time(), 0.0);
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn new(settings: Settings) -> Result<Self, SimulationError> {
        settings.validate()?;
        let pool = Pool::new(settings.threads, settings.portable_instructions).map_err(SimulationError::Threads)?;
        Ok(Self::with_pool(settings, pool))
    }

    fn with_pool(settings: Settings, pool: Pool) -> Self {
        let (world, report, events) = (World::new(), Report::default(), Vec::new());
        let (schedule, dirty, spare) = (Schedule::default(), Dirty::default(), Vec::new());
        Self { world, settings, pool, schedule, report, events, next_order: 0, recorder: None, dirty, spare }
    }

    /// Puts a body into the world.
    ///
    /// # Errors
    /// If its mesh, material or components are refused; the world is unchanged then.
    ///
    /// # Examples
    /// ```
    /// use rhexis::prelude::*;
    ///
    /// let mut simulation = Simulation::new(Settings::default())?;
    /// let mesh = generate::disc(5.0, 200)?;
    /// let body = simulation.spawn(Membrane::new("capsule", mesh, Material::allard_2009()).with(Tearing::default()))?;
    /// assert_eq!(simulation.bodies(), [body]);
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn spawn(&mut self, membrane: Membrane) -> Result<BodyId, SpawnError> {
        let name = membrane.name.clone();
        let mut components = membrane.build(self.next_order).map_err(|source| SpawnError { name, source })?;
        self.next_order += 1;
        let body = self.world.spawn(components.build()).into();
        self.note_spawned(body);
        Ok(body)
    }

    /// Takes a body, an obstacle or a tool out of the world.
    ///
    /// # Errors
    /// If there is none.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// simulation.despawn(body)?;
    /// assert!(simulation.bodies().is_empty());
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn despawn(&mut self, entity: impl Into<Entity>) -> Result<(), SimulationError> {
        let entity = entity.into();
        self.note(|| Input::Despawn(entity));
        // Whatever forceps hold they let go of.
        let _ = self.release(entity.into());
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
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// simulation.set_settings(Settings { budget: Some(200), ..*simulation.settings() })?;
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn set_settings(&mut self, settings: Settings) -> Result<(), SimulationError> {
        settings.validate()?;
        self.note(|| Input::SetSettings(settings));
        let Settings { threads, portable_instructions, .. } = self.settings;
        self.settings = Settings { threads, portable_instructions, ..settings };
        Ok(())
    }

    /// Time reached \[ms\].
    pub fn time(&self) -> f64 {
        self.report.time
    }

    /// Report of the last step.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// simulation.step(5.0)?;
    /// assert_eq!((simulation.report().step, simulation.report().time), (1, 5.0));
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn report(&self) -> &Report {
        &self.report
    }

    /// Number of threads that a step uses.
    pub fn thread_count(&self) -> usize {
        self.pool.thread_count()
    }

    /// Takes the events since the last call, in order.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// simulation.cut(body, &[DVec3::new(0.0, 5.0, 0.0), DVec3::new(4.0, 5.0, 0.0)])?;
    /// let mut events = simulation.drain_events();
    /// assert!(events.any(|event| matches!(event.kind, EventKind::Cut { .. })));
    /// # drop(events);
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn drain_events(&mut self) -> std::vec::Drain<'_, Event> {
        self.events.drain(..)
    }

    /// The bodies in order of spawning.
    pub fn bodies(&self) -> Vec<BodyId> {
        let mut bodies: Vec<(u32, Entity)> =
            self.world.query::<(Entity, &Body)>().iter().map(|(e, b)| (b.order, e)).collect();
        bodies.sort_unstable_by_key(|&(order, _)| order);
        bodies.into_iter().map(|(_, entity)| entity.into()).collect()
    }

    /// Moves the world on by `dt` \[ms\] as the [settings](Settings) say: by default linearly implicit backward Euler. A step that
    /// leaves a state which is not finite or has created energy is undone and retried in halves; if that fails too, the last good state
    /// stays and the report says so.
    ///
    /// # Errors
    /// For a `dt` that is not a positive finite number, and for a body with an [`EnergyAudit`] where the integrator is not backward
    /// Euler; nothing has changed then.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// let report = simulation.step(5.0)?;
    /// println!("{} iterations", report.bodies[0].iterations);
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn step(&mut self, dt: f64) -> Result<&Report, SimulationError> {
        self.step_with(dt, &[])
    }

    /// A step whose solves stop where `stops` say, if anything, and not by the clock.
    fn step_with(&mut self, dt: f64, stops: &[Vec<u32>]) -> Result<&Report, SimulationError> {
        self.note(|| Input::Step { dt, stops: Vec::new() });
        if !(dt > 0.0 && (self.report.time + dt).is_finite()) {
            return Err(SimulationError::TimeStep(dt));
        }
        if self.settings.advanced.integrator != Integrator::BackwardEuler
            && let Some((body, _)) = self.world.query_mut::<(&Body, &EnergyAudit)>().into_iter().next()
        {
            return Err(SimulationError::AuditOfAnotherIntegrator { body: body.name.clone() });
        }
        self.validate_dirty()?;
        // As many as in the step before.
        let rows = self.report.bodies.iter().filter(|body| !body.is_asleep).map(|body| body.triangle_count).sum();
        self.begin_report();
        self.begin_stops(stops);
        let Self { world, settings, pool, schedule, report, spare, .. } = self;
        let (time, mut running) = (report.time, Running { schedule, report, spare });
        let done = pool.run_step(rows, || advance(world, settings, time, dt, &mut running));
        let step = StepContext::of_step(&self.settings, dt, self.report.time + dt);
        self.check_callers(&step)?;
        self.report.time += done;
        self.finish_report();
        self.report.has_failed = self.report.bodies.iter().any(|body| body.fault.is_some());
        self.note_stops();
        self.rest_obstacles();
        self.use_forces_up();
        self.note_unfinished_tears();
        self.collect_events();
        if self.report.has_failed {
            let (step, time) = (self.report.step, self.report.time);
            let failed = |(body, fault): (BodyId, Fault)| {
                let reason = format!("no part of the step of {dt} ms led on to a sound state: {fault}");
                Event { step, time, body, kind: EventKind::StepFailed { reason } }
            };
            let faults: Vec<_> = self.report.bodies.iter().filter_map(|body| Some((body.body, body.fault?))).collect();
            self.events.extend(faults.iter().copied().map(failed));
            for (body, _) in faults {
                // A body of the report exists.
                let _ = self.refresh(body);
            }
        }
        Ok(&self.report)
    }
}

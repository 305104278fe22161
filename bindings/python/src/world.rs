//! Worlds: made, stepped.

use crate::component;
use crate::entity::{BodyRef, Entity};
use crate::error::{Answer, Failure, Kind, guarded, refused, unreadable};
use crate::lent::Loans;
use crate::report::Report;
use crate::saved::Snapshot;
use crate::toml_form::{given, patched};
use pyo3::exceptions::PyUserWarning;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rhexis::components::{Body, Obstacle};
use rhexis::event::Event;
use rhexis::hecs;
use rhexis::settings::{Accuracy, Settings};
use rhexis::simulation::{BodyView, Doubt, Simulation};
use rhexis::storage::{BodyId, ObstacleId};
use rhexis_scene::measures::TearCourse;
use rhexis_scene::schema::Mode;
use rhexis_scene::{Document, Instance};
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, TryLockError};

/// Simulation alone, or one that a scene drives.
pub(crate) enum Run {
    Bare(Box<Simulation>),
    Scene(Box<Instance>),
}

impl Run {
    fn simulation(&self) -> &Simulation {
        match self {
            Self::Bare(simulation) => simulation,
            Self::Scene(instance) => &instance.simulation,
        }
    }

    fn simulation_mut(&mut self) -> &mut Simulation {
        match self {
            Self::Bare(simulation) => simulation,
            Self::Scene(instance) => &mut instance.simulation,
        }
    }
}

/// A world behind its lock.
pub(crate) struct State {
    number: u64,
    pub(crate) run: Run,
    pub(crate) events: Vec<Event>,
    pub(crate) courses: Vec<TearCourse>,
    loans: Loans,
    /// Whether the likely slips were told.
    is_judged: bool,
}

impl Drop for State {
    fn drop(&mut self) {
        self.hand_over();
    }
}

impl State {
    pub(crate) fn simulation(&self) -> &Simulation {
        self.run.simulation()
    }

    pub(crate) fn simulation_mut(&mut self) -> &mut Simulation {
        self.run.simulation_mut()
    }

    fn hand_over(&mut self) {
        self.loans.hand_over(self.run.simulation().world());
    }

    fn scene(&self) -> Answer<&Instance> {
        match &self.run {
            Run::Scene(instance) => Ok(instance),
            Run::Bare(_) => Err(no_scene()),
        }
    }

    fn scene_mut(&mut self) -> Answer<&mut Instance> {
        match &mut self.run {
            Run::Scene(instance) => Ok(instance),
            Run::Bare(_) => Err(no_scene()),
        }
    }

    /// The entity of a handle, alive.
    pub(crate) fn entity(&self, handle: Entity) -> Answer<hecs::Entity> {
        let entity = handle.of(self.number)?;
        if self.simulation().world().contains(entity) {
            return Ok(entity);
        }
        Err(Failure::handle(format!("{entity:?} is destroyed, or was never made")))
    }

    /// The entity of a handle, or the body of a name.
    pub(crate) fn any(&self, given: &BodyRef) -> Answer<hecs::Entity> {
        match given {
            BodyRef::Entity(handle) => self.entity(*handle),
            BodyRef::Name(name) => self.named(name).map(BodyId::entity),
        }
    }

    /// The body that is meant; the only one where none is named.
    pub(crate) fn body(&self, given: Option<&BodyRef>) -> Answer<BodyId> {
        let Some(given) = given else {
            return match self.simulation().bodies()[..] {
                [body] => Ok(body),
                ref bodies => Err(Failure::input(format!("there are {} bodies: say which is meant", bodies.len()))),
            };
        };
        let entity = self.any(given)?;
        if self.simulation().world().satisfies::<&Body>(entity) {
            return Ok(entity.into());
        }
        Err(Failure::handle(format!("{entity:?} is no body")))
    }

    /// The obstacle of a handle.
    pub(crate) fn obstacle(&self, handle: Entity) -> Answer<ObstacleId> {
        let entity = self.entity(handle)?;
        if self.simulation().world().satisfies::<&Obstacle>(entity) {
            return Ok(entity.into());
        }
        Err(Failure::handle(format!("{handle:?} is no obstacle")))
    }

    pub(crate) fn name(&self, body: BodyId) -> Option<String> {
        self.simulation().world().get::<&Body>(body.entity()).ok().map(|body| body.name.clone())
    }

    fn named(&self, name: &str) -> Answer<BodyId> {
        let bodies = self.simulation().bodies();
        let found = bodies.iter().find(|&&body| self.name(body).is_some_and(|other| other == name));
        found.copied().ok_or_else(|| Failure::new(Kind::NotFound, format!("there is no body `{name}`")))
    }

    pub(crate) fn handle(&self, entity: impl Into<hecs::Entity>) -> Entity {
        Entity::new(self.number, entity.into())
    }

    /// Likely slips: of the scene, or of the simulation by a time step \[ms\].
    fn doubts(&self, dt: f64, duration: Option<f64>) -> Vec<Doubt> {
        match &self.run {
            Run::Scene(instance) => instance.doubts.clone(),
            Run::Bare(simulation) => simulation.doubts(dt, duration),
        }
    }

    /// Moves events of the engine to those of the world, past the courses that follow them.
    pub(crate) fn note_step(&mut self) {
        if self.courses.is_empty() {
            return;
        }
        let fresh: Vec<Event> = self.simulation_mut().drain_events().collect();
        let mut courses = std::mem::take(&mut self.courses);
        let simulation = self.simulation();
        courses.iter_mut().for_each(|course| course.note(simulation.world(), simulation.time(), &fresh));
        self.courses = courses;
        self.events.extend(fresh);
    }

    pub(crate) fn take_events(&mut self) -> Vec<Event> {
        let mut events = std::mem::take(&mut self.events);
        events.extend(self.simulation_mut().drain_events());
        events
    }

    /// Does steps until there were so many, or the last says that it was; looks for Ctrl-C between them.
    fn repeat(&mut self, count: u32, mut one: impl FnMut(&mut Self) -> Answer<(Report, bool)>) -> PyResult<Report> {
        for left in (0..count).rev() {
            let (report, is_last) = one(self)?;
            self.note_step();
            if left == 0 || is_last {
                return Ok(report);
            }
            Python::attach(|py| py.check_signals())?;
        }
        Err(Failure::input("a count of 0 steps: give 1 or more").into())
    }
}

fn no_scene() -> Failure {
    Failure::input("the world is not from a scene: call step with a time step")
}

/// World of the simulation: bodies, obstacles and tools, and their time.
#[pyclass(frozen, module = "rhexis")]
pub(crate) struct World {
    /// Process that has the world's threads.
    process: u32,
    state: Mutex<State>,
}

impl World {
    pub(crate) fn keep(run: Run) -> Self {
        static NUMBER: AtomicU64 = AtomicU64::new(1);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let (events, courses, loans) = (Vec::new(), Vec::new(), Loans::default());
        let process = std::process::id();
        Self { process, state: Mutex::new(State { number, run, events, courses, loans, is_judged: false }) }
    }

    fn lock(&self) -> Answer<MutexGuard<'_, State>> {
        // A fork has neither the threads nor whoever would give back a lock.
        if self.process != std::process::id() {
            let message = "the world belongs to the process before the fork: go on from a snapshot in a new one, or start processes by \"spawn\"";
            return Err(Failure::handle(message));
        }
        self.state.try_lock().map_err(|error| match error {
            TryLockError::WouldBlock => Failure::new(Kind::Busy, "another thread is in a call with this world"),
            TryLockError::Poisoned(_) => {
                let message = "the world has failed in an earlier call: go on from a snapshot in a new one";
                Failure::new(Kind::Poisoned, message)
            }
        })
    }

    /// The world to be changed: what arrays show of it is theirs first.
    fn changed(&self) -> Answer<MutexGuard<'_, State>> {
        let mut state = self.lock()?;
        state.hand_over();
        Ok(state)
    }

    /// Works on the world without the interpreter's lock.
    pub(crate) fn with<R: Send, E: From<Failure> + Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut State) -> Result<R, E> + Send,
    ) -> PyResult<R>
    where
        PyErr: From<E>,
    {
        Ok(py.detach(|| guarded(|| work(&mut *self.changed()?)))?)
    }

    /// Warns of likely slips before the first step.
    fn warn(&self, py: Python<'_>, dt: f64) -> PyResult<()> {
        let list = self.look_mut(|state| {
            let is_judged = std::mem::replace(&mut state.is_judged, true);
            Ok(if is_judged || !(dt >= 0.0) { Vec::new() } else { state.doubts(dt, None) })
        })?;
        let category = py.get_type::<PyUserWarning>();
        for doubt in list {
            PyErr::warn(py, &category, &std::ffi::CString::new(doubt.text).unwrap_or_default(), 1)?;
        }
        Ok(())
    }

    /// Looks at the world and makes objects of Python of it.
    pub(crate) fn look<R>(&self, work: impl FnOnce(&State) -> PyResult<R>) -> PyResult<R> {
        guarded(|| work(&*self.lock()?))
    }

    /// As `look`, where the engine brings something up to date first.
    pub(crate) fn look_mut<R>(&self, work: impl FnOnce(&mut State) -> PyResult<R>) -> PyResult<R> {
        guarded(|| work(&mut *self.changed()?))
    }

    /// Looks at the arrays of a body, and lends them.
    pub(crate) fn show<R>(
        &self,
        body: Option<BodyRef>,
        look: impl FnOnce(BodyId, &BodyView<'_>, &mut Loans) -> PyResult<R>,
    ) -> PyResult<R> {
        guarded(|| {
            let mut state = self.lock()?;
            let body = state.body(body.as_ref())?;
            let State { run, loans, .. } = &mut *state;
            let view = run.simulation_mut().view(body).map_err(refused)?;
            look(body, &view, loans)
        })
    }
}

fn of_accuracy(name: &str) -> Answer<Settings> {
    let accuracy = Accuracy::named(name).ok_or_else(|| {
        let names = Accuracy::ALL.map(Accuracy::name).join(", ");
        Failure::input(format!("there is no accuracy `{name}`: give one of {names}"))
    })?;
    Ok(Settings::new(accuracy))
}

fn of_document(py: Python<'_>, document: Answer<Document>, changes: Option<&Bound<'_, PyDict>>) -> PyResult<World> {
    let mut document = document?;
    for (key, value) in given("changes", None, changes)? {
        document.set(&format!("{key}={value}")).map_err(unreadable)?;
    }
    let make = || guarded(|| document.scene().and_then(|scene| scene.instantiate()).map_err(unreadable));
    Ok(World::keep(Run::Scene(Box::new(py.detach(make)?))))
}

#[pymethods]
impl World {
    #[new]
    #[pyo3(signature = (accuracy = "fast", *, threads = 0, budget = None, portable_instructions = false, settings = None))]
    fn new(
        accuracy: &str,
        threads: usize,
        budget: Option<u32>,
        portable_instructions: bool,
        settings: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let base = of_accuracy(accuracy)?;
        let budget = budget.map_or(base.budget, |budget| (budget > 0).then_some(budget));
        let base = Settings { threads, portable_instructions, budget, ..base };
        let settings = patched("settings", Some(&base), given("settings", settings, None)?)?;
        let simulation = guarded(|| Simulation::new(settings).map_err(refused))?;
        Ok(Self::keep(Run::Bare(Box::new(simulation))))
    }

    #[staticmethod]
    #[pyo3(signature = (text, origin = "scene", changes = None))]
    fn from_scene(py: Python<'_>, text: &str, origin: &str, changes: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        of_document(py, Ok(Document::new(text, origin)), changes)
    }

    #[staticmethod]
    #[pyo3(signature = (path, changes = None))]
    fn from_file(py: Python<'_>, path: PathBuf, changes: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        of_document(py, Document::load(&path).map_err(unreadable), changes)
    }

    #[staticmethod]
    #[pyo3(signature = (name, changes = None))]
    fn from_catalog(py: Python<'_>, name: &str, changes: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        of_document(py, Document::named(name).map_err(unreadable), changes)
    }

    #[staticmethod]
    fn from_snapshot(py: Python<'_>, snapshot: &Snapshot) -> PyResult<Self> {
        let make = || guarded(|| Simulation::from_snapshot(&snapshot.value).map_err(refused));
        Ok(Self::keep(Run::Bare(Box::new(py.detach(make)?))))
    }

    /// Likely slips in all that the world holds, as (kind, finding with its remedy), for steps of `dt` \[ms\] over a `duration` \[ms\]; of a scene's world
    /// those of its scene.
    #[pyo3(signature = (dt = 16.0, duration = None))]
    fn doubts(&self, dt: f64, duration: Option<f64>) -> PyResult<Vec<(&'static str, String)>> {
        self.look(|state| Ok(state.doubts(dt, duration).into_iter().map(|d| (d.kind.name(), d.text)).collect()))
    }

    /// Moves the world on by `count` steps of `dt` \[ms\]; a budget of iterations holds for these steps.
    #[pyo3(signature = (dt, count = 1, budget = None))]
    fn step(&self, py: Python<'_>, dt: f64, count: u32, budget: Option<u32>) -> PyResult<Report> {
        self.warn(py, dt)?;
        self.with(py, |state| {
            let before = budget.map(|budget| change_budget(state, Some(budget))).transpose()?;
            let done = state.repeat(count, |state| {
                let report = state.simulation_mut().step(dt).map_err(refused)?;
                Ok((Report::from(report), false))
            });
            let back = before.map_or(Ok(None), |before| change_budget(state, before));
            let report = done?;
            back?;
            Ok::<_, PyErr>(report)
        })
    }

    /// Does the next steps of a scene, until it is at its end where there are several.
    #[pyo3(signature = (count = 1))]
    fn advance(&self, py: Python<'_>, count: u32) -> PyResult<Report> {
        self.warn(py, 0.0)?;
        self.with(py, |state| {
            state.repeat(count, |state| {
                let instance = state.scene_mut()?;
                let report = Report::from(instance.advance().map_err(refused)?);
                Ok((report, instance.is_finished()))
            })
        })
    }

    /// Whether a scene is at its end.
    #[getter]
    fn is_finished(&self) -> PyResult<bool> {
        self.look(|state| Ok(state.scene()?.is_finished()))
    }

    /// How a scene is run: mode, time step \[ms\], steps at the most, steps done.
    #[getter]
    fn scene<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.look(|state| {
            let instance = state.scene()?;
            let told = PyDict::new(py);
            let mode = if instance.run.mode == Mode::Static { "static" } else { "dynamic" };
            told.set_item("mode", mode)?;
            told.set_item("dt", instance.run.dt)?;
            told.set_item("steps", instance.run.steps)?;
            told.set_item("step", instance.step())?;
            told.set_item("until_torn", instance.run.until_torn)?;
            told.set_item("until_ended", instance.run.until_ended)?;
            Ok(told)
        })
    }

    /// Moves time on by `dt` \[ms\] and finds the equilibrium there.
    #[pyo3(signature = (dt, tolerance = 1e-6))]
    fn settle(&self, py: Python<'_>, dt: f64, tolerance: f64) -> PyResult<Report> {
        self.with(py, |state| {
            let report = Report::from(state.simulation_mut().settle(dt, tolerance).map_err(refused)?);
            state.note_step();
            Ok::<_, Failure>(report)
        })
    }

    /// Time reached \[ms\].
    #[getter]
    fn time(&self) -> PyResult<f64> {
        self.look(|state| Ok(state.simulation().time()))
    }

    /// Bodies in order of spawning.
    #[getter]
    fn bodies(&self) -> PyResult<Vec<Entity>> {
        self.look(|state| Ok(state.simulation().bodies().into_iter().map(|body| state.handle(body)).collect()))
    }

    /// Obstacles.
    #[getter]
    fn obstacles(&self) -> PyResult<Vec<Entity>> {
        self.look(|state| Ok(state.simulation().obstacles().into_iter().map(|entity| state.handle(entity)).collect()))
    }

    /// Forceps and blades.
    #[getter]
    fn tools(&self) -> PyResult<Vec<Entity>> {
        self.look(|state| Ok(state.simulation().tools().into_iter().map(|entity| state.handle(entity)).collect()))
    }

    /// The body of a name.
    fn find(&self, name: &str) -> PyResult<Entity> {
        self.look(|state| Ok(state.handle(state.named(name)?)))
    }

    /// The name of a body.
    #[pyo3(signature = (body = None))]
    fn name(&self, body: Option<BodyRef>) -> PyResult<String> {
        self.look(|state| {
            let body = state.body(body.as_ref())?;
            Ok(state.name(body).unwrap_or_default())
        })
    }

    /// Takes a body, an obstacle or a tool out of the world.
    fn despawn(&self, py: Python<'_>, entity: BodyRef) -> PyResult<()> {
        self.with(py, |state| {
            let entity = state.any(&entity)?;
            state.courses.retain(|course| course.body().entity() != entity);
            state.simulation_mut().despawn(entity).map_err(refused)
        })
    }

    /// Judges all that the world has.
    fn validate(&self, py: Python<'_>) -> PyResult<()> {
        self.with(py, |state| state.simulation().validate().map_err(refused))
    }

    /// Hash of the whole state.
    fn hash(&self, py: Python<'_>) -> PyResult<u64> {
        self.with(py, |state| Ok::<_, Failure>(state.simulation().hash().0))
    }

    fn __repr__(&self) -> String {
        let told = self.look(|state| {
            let (simulation, number) = (state.simulation(), state.number);
            Ok(format!("<rhexis.World {number}: {} bodies, {} ms>", simulation.bodies().len(), simulation.time()))
        });
        told.unwrap_or_else(|_| "<rhexis.World: busy or failed>".to_owned())
    }
}

/// Changes the budget of iterations and returns what it was.
fn change_budget(state: &mut State, budget: Option<u32>) -> Answer<Option<u32>> {
    let simulation = state.simulation_mut();
    let before = simulation.settings().budget;
    let settings = Settings { budget, ..*simulation.settings() };
    simulation.set_settings(settings).map_err(refused)?;
    Ok(before)
}

/// Gives a new body its components; it is taken out again where one is refused.
pub(crate) fn equip(state: &mut State, body: BodyId, components: Vec<(String, toml::Table)>) -> Answer<()> {
    for (name, values) in components {
        let set = component::entry(&name).and_then(|entry| (entry.set)(state.simulation_mut(), body.entity(), values));
        if let Err(failure) = set {
            // It was spawned just now.
            let _ = state.simulation_mut().despawn(body);
            return Err(failure);
        }
    }
    Ok(())
}

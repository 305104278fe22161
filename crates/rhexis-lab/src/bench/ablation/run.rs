//! One run of a row: counts, time, states and outcome.

use super::super::clock::Stopwatch;
use super::super::solve::StepError;
use super::super::trace::{State, Trace, instantiate};
use super::super::{BenchError, Depth};
use super::cases::{Case, Source};
use super::game::Game;
use super::rows::Row;
use rhexis::components::{Grips, Reactions};
use rhexis::event::{Event, EventKind};
use rhexis::report::Report;
use rhexis::settings::{Advanced, LinearParams, Settings};
use rhexis::simulation::Simulation;
use rhexis::snapshot::Snapshot;
use rhexis::storage::BodyId;
use rhexis::storage::TipKey;
use rhexis_scene::Instance;
use rhexis_scene::measures::TearCourse;

/// Relative residual of the reference's solves.
const TIGHT: f64 = 1e-9;
/// Maximum iterations of one of them.
const MOST_ITERATIONS: u32 = 100_000;

/// Sums over the steps of a run.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Counts {
    pub steps: u64,
    pub iterations: u64,
    /// Linear solves of bodies.
    pub solves: u64,
    /// Work as a budget counts it.
    pub work: u64,
    /// Steps or parts of steps that were undone.
    pub undone: u64,
    /// Attempts with Newton corrections.
    pub corrected: u64,
    /// Parts with local relaxation.
    pub relaxed: u64,
    /// Parts with a limited increment.
    pub limited: u64,
    /// Steps that were given up.
    pub failed: u64,
    pub advances: u64,
    pub grasps: u64,
    pub slips: u64,
    /// Pieces that came free.
    pub pieces: u64,
}

/// Results of a run.
pub(super) struct Measured {
    pub counts: Counts,
    /// Processor time of the steps on their thread, and of all threads \[ms\].
    pub ms: f64,
    pub process_ms: f64,
    /// Diameter of the opening \[mm\]; NaN without one.
    pub opening: f64,
    /// Root mean square of the force of jaws, or else of the last hold \[mN\].
    pub force: f64,
    pub trace: Trace,
}

/// The state in which all rows of a case begin.
pub(super) struct Start<'a> {
    case: &'a Case,
    until: f64,
    settings: Settings,
    at: Beginning,
}

enum Beginning {
    Scene {
        scene: &'static str,
        sets: Vec<String>,
        snapshot: Box<Snapshot>,
        progress: (u64, bool),
        course: Option<Box<TearCourse>>,
    },
    Game,
}

/// A simulation with the script that drives it.
enum Host {
    Scene(Box<Instance>, Option<Box<TearCourse>>),
    Game(Box<Game>),
}

impl Host {
    fn simulation(&mut self) -> &mut Simulation {
        match self {
            Self::Scene(instance, _) => &mut instance.simulation,
            Self::Game(game) => &mut game.simulation,
        }
    }

    fn body(&self) -> BodyId {
        match self {
            Self::Scene(instance, _) => instance.bodies[0],
            Self::Game(game) => game.cloth,
        }
    }

    fn dt(&self) -> f64 {
        match self {
            Self::Scene(instance, _) => instance.run.dt,
            Self::Game(_) => Game::FRAME,
        }
    }

    fn is_finished(&self) -> bool {
        matches!(self, Self::Scene(instance, _) if instance.is_finished())
    }

    /// Moves the hand.
    fn play(&mut self) -> Result<(), BenchError> {
        match self {
            Self::Scene(..) => Ok(()),
            Self::Game(game) => game.play(),
        }
    }

    fn advance(&mut self) -> Result<&Report, BenchError> {
        Ok(match self {
            Self::Scene(instance, _) => instance.advance()?,
            Self::Game(game) => game.simulation.step(Game::FRAME)?,
        })
    }

    /// Takes the events of the step in.
    fn events(&mut self) -> Result<Vec<Event>, BenchError> {
        let events: Vec<Event> = self.simulation().drain_events().collect();
        match self {
            Self::Scene(instance, Some(course)) => {
                course.note(instance.simulation.world(), instance.simulation.time(), &events);
            }
            Self::Scene(_, None) => {}
            Self::Game(game) => game.look_again()?,
        }
        Ok(events)
    }

    /// Force of jaws, or else of the last hold \[N\].
    fn force(&mut self) -> f64 {
        let body = self.body();
        let world = self.simulation().world();
        if let Ok(grips) = world.get::<&Grips>(body.entity()) {
            return grips.pinches.iter().map(|pinch| pinch.force.length()).sum();
        }
        let last = world
            .get::<&Reactions>(body.entity())
            .ok()
            .and_then(|reactions| Some(reactions.groups.last()?.iter().sum()));
        last.map_or(0.0, |force: glam::DVec3| force.length())
    }
}

impl<'a> Start<'a> {
    pub(super) fn of(case: &'a Case, depth: Depth) -> Result<Self, BenchError> {
        let until = case.until[usize::from(depth == Depth::Quick)];
        let (scene, sets) = match &case.source {
            Source::Game(settings) => {
                let settings = Settings { threads: 1, ..settings() };
                return Ok(Self { case, until, settings, at: Beginning::Game });
            }
            Source::Catalog(scene, sets) => (*scene, sets.iter().map(|&set| set.to_owned()).collect::<Vec<String>>()),
        };
        let mut instance = instantiate(scene, &sets)?;
        let mut course = TearCourse::new(instance.simulation.world(), instance.bodies[0], 0.0).map(Box::new);
        while instance.simulation.time() < case.from - 1e-6 && !instance.is_finished() {
            instance.advance()?;
            let events: Vec<Event> = instance.simulation.drain_events().collect();
            if let Some(course) = &mut course {
                course.note(instance.simulation.world(), instance.simulation.time(), &events);
            }
        }
        let (snapshot, progress) = (Box::new(instance.simulation.snapshot()), instance.progress());
        let settings = *instance.simulation.settings();
        Ok(Self { case, until, settings, at: Beginning::Scene { scene, sets, snapshot, progress, course } })
    }

    pub(super) fn from(&self) -> f64 {
        self.case.from
    }

    pub(super) fn until(&self) -> f64 {
        self.until
    }

    /// Whether a row changes the settings of the scene.
    pub(super) fn is_changed_by(&self, row: &Row) -> bool {
        row.may_sleep || row.settings(&self.settings) != self.settings
    }

    fn host(&self) -> Result<Host, BenchError> {
        Ok(match &self.at {
            Beginning::Game => Host::Game(Box::new(Game::new(self.settings)?)),
            Beginning::Scene { scene, sets, snapshot, progress, course } => {
                let mut instance = instantiate(scene, sets)?;
                instance.resume(snapshot, *progress).map_err(|error| BenchError::State(error.to_string()))?;
                instance.simulation.drain_events();
                Host::Scene(Box::new(instance), course.clone())
            }
        })
    }

    /// The run with tight solves and everything on.
    pub(super) fn reference(&self) -> Result<Measured, BenchError> {
        let mut host = self.host()?;
        let linear = LinearParams::by_residual(TIGHT, MOST_ITERATIONS);
        let set = *host.simulation().settings();
        let advanced = Advanced { linear, ..set.advanced };
        host.simulation().set_settings(Settings {
            budget: None,
            position_tolerance: f64::INFINITY,
            advanced,
            ..set
        })?;
        self.measure(host, true, false)
    }

    /// The run of a row; the first of its rounds keeps states.
    pub(super) fn run(&self, row: &Row, is_first: bool) -> Result<Measured, BenchError> {
        let mut host = self.host()?;
        let body = host.body();
        row.apply(host.simulation(), body)?;
        self.measure(host, is_first, is_first && self.case.is_chaotic)
    }

    fn measure(&self, mut host: Host, keeps_states: bool, judges_steps: bool) -> Result<Measured, BenchError> {
        let (body, dt) = (host.body(), host.dt());
        let (mut counts, mut trace) = (Counts::default(), Trace::default());
        let (mut ms, mut process_ms, mut squares) = (0.0, 0.0, 0.0);
        let mut tips: Vec<TipKey> = Vec::new();
        while host.simulation().time() < self.until - 1e-6 && !host.is_finished() {
            host.play()?;
            let after = host.simulation().time() + dt;
            let is_kept = (after / self.case.every).floor() > ((after - dt) / self.case.every).floor();
            if judges_steps && is_kept {
                trace.step_errors.push(step_error(host.simulation(), body, dt)?);
            }
            let watch = Stopwatch::start();
            let report = host.advance()?;
            let elapsed = watch.elapsed();
            (ms, process_ms) = (ms + elapsed.thread, process_ms + elapsed.process);
            counts.add(report);
            let force = host.force();
            squares += force * force;
            for event in host.events()? {
                counts.note(&event.kind);
                if let EventKind::Advanced { tip, from, to, .. } = event.kind {
                    let place = tips.iter().position(|known| *known == tip).unwrap_or_else(|| {
                        tips.push(tip);
                        trace.paths.push(vec![from.truncate()]);
                        tips.len() - 1
                    });
                    trace.paths[place].push(to.truncate());
                }
            }
            if keeps_states && is_kept {
                trace.states.extend(State::of(host.simulation(), body));
            }
        }
        let grips = host.simulation().world().get::<&Grips>(body.entity()).map_or(0, |grips| grips.grasp_count);
        counts.grasps = u64::from(grips);
        let opening = match &host {
            Host::Scene(_, Some(course)) => course.figures().opening.map_or(f64::NAN, |opening| opening.diameter),
            _ => f64::NAN,
        };
        let force = 1e3 * (squares / counts.steps.max(1) as f64).sqrt();
        Ok(Measured { counts, ms, process_ms, opening, force, trace })
    }
}

/// Error of the next step's solve, in a copy of the simulation: the run itself stays as it is.
fn step_error(simulation: &Simulation, body: BodyId, dt: f64) -> Result<StepError, BenchError> {
    let place = simulation.bodies().iter().position(|known| *known == body);
    let copied = Simulation::from_snapshot(&simulation.snapshot());
    let mut copy = copied.map_err(|error| BenchError::State(error.to_string()))?;
    // A snapshot leaves the ablated part out.
    copy.set_settings(*simulation.settings())?;
    let body = place.and_then(|place| copy.bodies().get(place).copied());
    let body = body.ok_or_else(|| BenchError::State("the body of the benchmark is not in its snapshot".to_owned()))?;
    StepError::of(&mut copy, body, dt)
}

impl Counts {
    fn add(&mut self, report: &Report) {
        self.steps += 1;
        self.undone += u64::from(report.rolled_back);
        self.failed += u64::from(report.has_failed);
        let solves = report.systems.iter().filter(|system| system.name == "solve");
        self.solves += solves.map(|system| system.bodies as u64).sum::<u64>();
        for body in &report.bodies {
            self.iterations += u64::from(body.iterations);
            self.work += u64::from(body.work);
            self.corrected += u64::from(body.guard.corrections());
            self.relaxed += u64::from(body.guard.relaxations());
            self.limited += u64::from(body.guard.limitations());
        }
    }

    fn note(&mut self, kind: &EventKind) {
        match kind {
            EventKind::Advanced { .. } => self.advances += 1,
            EventKind::Slipped { .. } => self.slips += 1,
            EventKind::FragmentFreed { .. } => self.pieces += 1,
            _ => {}
        }
    }
}

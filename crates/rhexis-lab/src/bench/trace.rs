//! One run of a scene: the time of every step, and what the tissue looked like at some of them.

use super::BenchError;
use super::clock::{Elapsed, Stopwatch, median};
use super::solve::StepError;
use glam::{DVec2, DVec3};
use rhexis::components::{Frames, Grips, Reactions};
use rhexis::event::EventKind;
use rhexis::math::Sym2;
use rhexis::simulation::Simulation;
use rhexis::storage::{BodyId, TipKey, Topology, Triangles, Vertices};
use rhexis_scene::{Document, Instance};
use std::time::Instant;

/// Rounds at the most: with so many one has met a core that no neighbour shares, if any can.
pub(super) const ROUNDS: usize = 25;

/// What is run, and what of it is measured.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    /// Name of the scene in the catalog.
    pub scene: &'static str,
    /// What is set in it, as with `rhexis run --set`.
    pub sets: Vec<String>,
    /// What is set in it from `from` on, of how steps are solved: runs that are compared begin in the same state.
    pub solver: Vec<String>,
    /// Steps up to this time are neither timed nor compared \[ms\].
    pub from: f64,
    /// No state is kept after this time \[ms\]: slack tissue is chaotic, and after some hundred steps runs part whatever their
    /// tolerance.
    pub compared_until: f64,
    /// The run ends here \[ms\].
    pub until: f64,
    /// Time between states that are kept \[ms\].
    pub every: f64,
    /// Whether single steps are judged, each against its own exact solution, because runs part whatever their tolerance.
    pub is_chaotic: bool,
}

/// What a run came to.
#[derive(Clone, Debug, Default)]
pub(super) struct Trace {
    /// States, by time.
    pub states: Vec<State>,
    /// Errors of single steps, where the plan asks for them.
    pub step_errors: Vec<StepError>,
    /// Ways of the tips, as seen along z, in the order in which they first moved \[mm\].
    pub paths: Vec<Vec<DVec2>>,
    /// Time of every step after the start: the least of all rounds. Rounds do the same work, bit for bit; what one took longer than
    /// another was other programs.
    pub step_ms: Vec<f64>,
    /// Time of every step by all threads of the program together \[ms\], the least of all rounds.
    pub process_ms: Vec<f64>,
    /// Whether a tip moved on in the step.
    pub has_torn: Vec<bool>,
    /// Mean linear iterations of a step.
    pub iterations: f64,
    /// Triangles at the start.
    pub triangle_count: usize,
    /// How far the medians of the rounds lie apart, over the least of them; NaN for one round.
    pub noise: f64,
}

/// The tissue at one moment.
#[derive(Clone, Debug)]
pub(super) struct State {
    /// \[ms\]
    pub time: f64,
    /// Corners of the triangles.
    pub corners: Vec<[u32; 3]>,
    /// Rest positions \[mm\].
    pub rest: Vec<DVec3>,
    /// Positions \[mm\].
    pub positions: Vec<DVec3>,
    /// Biot stress in the axes of the fibre \[MPa\], the mean of the triangles around each vertex by rest area.
    pub stress: Vec<Sym2>,
    /// Whether the vertex lies off every boundary.
    pub is_inside: Vec<bool>,
    /// Forces of holds and forceps \[N\].
    pub forces: Vec<DVec3>,
}

/// A plan that is run again and again for its times.
pub(super) struct Rounds {
    /// The plan.
    plan: Plan,
    /// What it has come to.
    pub trace: Trace,
    /// Medians of the rounds \[ms\].
    medians: Vec<f64>,
    /// Time that the rounds have taken \[s\].
    spent: f64,
}

impl Rounds {
    /// The first round, which keeps the states.
    pub(super) fn begin(plan: Plan) -> Result<Self, BenchError> {
        let start = Instant::now();
        let trace = Trace { noise: f64::NAN, ..run(&plan, true)? };
        let medians = vec![median(&trace.step_ms)];
        Ok(Self { plan, trace, medians, spent: start.elapsed().as_secs_f64() })
    }

    /// Whether another is due while `seconds` have not passed in its own.
    fn is_due(&self, seconds: f64) -> bool {
        self.spent < seconds && self.medians.len() < ROUNDS
    }

    /// One more.
    fn again(&mut self) -> Result<(), BenchError> {
        let (start, Self { plan, trace, medians, spent }) = (Instant::now(), self);
        let again = run(plan, false)?;
        medians.push(median(&again.step_ms));
        for (least, again) in trace.step_ms.iter_mut().zip(&again.step_ms) {
            *least = least.min(*again);
        }
        for (least, again) in trace.process_ms.iter_mut().zip(&again.process_ms) {
            *least = least.min(*again);
        }
        let (least, most) = medians.iter().fold((f64::INFINITY, 0.0_f64), |(l, m), x| (l.min(*x), m.max(*x)));
        trace.noise = most / least - 1.0;
        *spent += start.elapsed().as_secs_f64();
        Ok(())
    }
}

/// Runs what is compared in turns, each for so long and [`ROUNDS`] times at the most: a core that is slow for a while is so for all. Says
/// of each when it is `done`.
pub(super) fn in_turns(runs: &mut [Rounds], seconds: f64, done: impl Fn()) -> Result<(), BenchError> {
    let mut due: Vec<&mut Rounds> = runs.iter_mut().collect();
    while !due.is_empty() {
        due.retain(|run| {
            let is_due = run.is_due(seconds);
            if !is_due {
                done();
            }
            is_due
        });
        due.iter_mut().try_for_each(|run| run.again())?;
    }
    Ok(())
}

impl Trace {
    /// Runs the plan, again and again while `seconds` have not passed, but at most [`ROUNDS`] times, for its times.
    pub(super) fn record(plan: &Plan, seconds: f64) -> Result<Self, BenchError> {
        let mut rounds = Rounds::begin(plan.clone())?;
        while rounds.is_due(seconds) {
            rounds.again()?;
        }
        Ok(rounds.trace)
    }
}

fn run(plan: &Plan, keeps_states: bool) -> Result<Trace, BenchError> {
    let mut instance = instantiate(plan.scene, &plan.sets)?;
    let body = instance.bodies[0];
    let is_alone = instance.simulation.thread_count() == 1;
    let both: Vec<String> = plan.sets.iter().chain(&plan.solver).cloned().collect();
    let solver = *instantiate(plan.scene, &both)?.simulation.settings();
    let mut is_switched = false;
    let mut trace = Trace { triangle_count: triangle_count(&instance.simulation, body), ..Trace::default() };
    let mut tips: Vec<TipKey> = Vec::new();
    let mut iterations = 0;
    while instance.simulation.time() < plan.until - 1e-6 && !instance.is_finished() {
        if !is_switched && instance.simulation.time() >= plan.from - 1e-6 {
            instance.simulation.set_settings(solver)?;
            is_switched = true;
        }
        let is_kept = |time: f64| {
            let phase = (time / plan.every).round() * plan.every - time;
            keeps_states && phase.abs() < 1e-6 && time < plan.compared_until + 1e-6
        };
        let (now, dt) = (instance.simulation.time(), instance.run.dt);
        if plan.is_chaotic && now >= plan.from - 1e-6 && is_kept(now + dt) {
            trace.step_errors.push(StepError::of(&mut instance.simulation, body, dt)?);
        }
        let watch = Stopwatch::start();
        let report = instance.advance()?;
        let elapsed = watch.elapsed();
        if report.has_failed {
            return Err(BenchError::State(format!("{}: a step failed at {} ms", plan.scene, report.time)));
        }
        let (time, of_step) = (report.time, report.bodies.iter().map(|body| body.iterations).sum::<u32>());
        let mut has_torn = false;
        for event in instance.simulation.drain_events() {
            if let EventKind::Advanced { tip, from, to, .. } = event.kind {
                has_torn = true;
                let place = tips.iter().position(|known| *known == tip).unwrap_or_else(|| {
                    tips.push(tip);
                    trace.paths.push(vec![from.truncate()]);
                    tips.len() - 1
                });
                trace.paths[place].push(to.truncate());
            }
        }
        if time <= plan.from + 1e-6 {
            continue;
        }
        let Elapsed { wall, thread, process } = elapsed;
        trace.step_ms.push(if is_alone { thread } else { wall });
        trace.process_ms.push(process);
        trace.has_torn.push(has_torn);
        iterations += of_step;
        if is_kept(time) {
            trace.states.extend(State::of(&mut instance.simulation, body));
        }
    }
    trace.iterations = f64::from(iterations) / trace.step_ms.len().max(1) as f64;
    Ok(trace)
}

/// A scene of the catalog with some values changed, on one thread unless they say otherwise.
pub(super) fn instantiate(scene: &str, sets: &[String]) -> Result<Instance, BenchError> {
    let mut document = Document::named(scene)?;
    document.set("run.threads=1")?;
    sets.iter().try_for_each(|assignment| document.set(assignment))?;
    Ok(document.scene()?.instantiate()?)
}

/// Triangles of a body.
pub(super) fn triangle_count(simulation: &Simulation, body: BodyId) -> usize {
    simulation.world().get::<&Triangles>(body.entity()).map_or(0, |triangles| triangles.len())
}

impl State {
    pub(super) fn of(simulation: &mut Simulation, body: BodyId) -> Option<Self> {
        simulation.refresh(body).ok()?;
        let time = simulation.time();
        let world = simulation.world();
        let mut query = world.query_one::<(&Vertices, &Triangles, &Topology, &Frames)>(body.entity());
        let (vertices, triangles, topology, frames) = query.get().ok()?;
        let mut forces = Vec::new();
        if let Ok(reactions) = world.get::<&Reactions>(body.entity()) {
            forces.extend(reactions.groups.iter().map(|group| group.iter().sum::<DVec3>()));
        }
        if let Ok(grips) = world.get::<&Grips>(body.entity()) {
            forces.extend(grips.pinches.iter().map(|pinch| pinch.force));
        }
        Some(Self {
            time,
            corners: triangles.corners.clone(),
            rest: vertices.rest_position.clone(),
            positions: vertices.position.clone(),
            stress: nodal_stress(triangles, topology, frames),
            is_inside: (0..vertices.len() as u32).map(|v| !topology.is_boundary_vertex(v)).collect(),
            forces,
        })
    }
}

/// Biot stress in the axes of the fibre per vertex \[MPa\], weighted by rest area.
pub(super) fn nodal_stress(triangles: &Triangles, topology: &Topology, frames: &Frames) -> Vec<Sym2> {
    let mean = |around: &[u32]| {
        let (mut sum, mut area) = (Sym2::default(), 0.0);
        for &entry in around {
            let t = entry as usize / 3;
            sum += frames.state(t).stress * triangles.rest[t].area;
            area += triangles.rest[t].area;
        }
        if area > 0.0 { sum * (1.0 / area) } else { sum }
    };
    topology.incident.iter().map(|around| mean(around)).collect()
}

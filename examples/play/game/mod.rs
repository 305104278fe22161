//! The game: frames of a player's input, steps, events, saves, loads and resets, and a renderer that follows.

mod level;
mod mouse;
mod renderer;
mod summary;

use cpu_time::ThreadTime;
use level::Level;
pub use level::SIZE;
use mouse::Mouse;
use renderer::Renderer;
use rhexis::event::EventKind;
use rhexis::settings::Settings;
use rhexis::simulation::{FixedStep, Simulation};
use rhexis::snapshot::{Snapshot, StateHash};
pub use summary::Summary;

pub type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// One picture, and one step of the simulation \[ms\].
const FRAME: f64 = 1000.0 / 60.0;

/// Frames, 60 per second, in which the player saves, loads, and restarts the level.
const SAVES: (u64, u64) = (180, 90);
const LOADS: (u64, u64) = (240, 239);
const RESETS: (u64, u64) = (900, 899);

fn is_due(frame: u64, (every, at): (u64, u64)) -> bool {
    frame % every == at
}

/// A saved state of simulation and host.
struct Kept {
    bytes: Vec<u8>,
    hash: StateHash,
    level: Level,
    renderer: Renderer,
}

impl Kept {
    /// The renderer takes the changes in first: its copy is then the mesh that is saved.
    fn of(simulation: &mut Simulation, level: &Level, renderer: &mut Renderer) -> Result<Self> {
        for body in simulation.bodies() {
            renderer.follow(simulation, body)?;
        }
        let (bytes, hash) = (simulation.snapshot().to_bytes()?, simulation.hash());
        Ok(Self { bytes, hash, level: level.clone(), renderer: renderer.clone() })
    }

    fn restore(&self, simulation: &mut Simulation, level: &mut Level, renderer: &mut Renderer) -> Result<()> {
        simulation.restore(&Snapshot::from_bytes(&self.bytes)?)?;
        assert_eq!(simulation.hash(), self.hash, "the state is the one that was kept");
        (*level, *renderer) = (self.level.clone(), self.renderer.clone());
        // All is new now; changes of later steps are listed once that has been read.
        for body in simulation.bodies() {
            renderer.follow(simulation, body)?;
        }
        Ok(())
    }
}

/// Plays for some seconds. `allocations` counts those of the process so far.
pub fn play(seconds: f64, seed: u64, settings: Settings, allocations: fn() -> usize) -> Result<(Summary, StateHash)> {
    let mut simulation = Simulation::new(settings)?;
    let mut renderer = Renderer::default();
    let mut level = Level::new(&mut simulation, &mut renderer)?;
    let mut mouse = Mouse::new(&mut simulation, seed)?;
    let start = Kept::of(&mut simulation, &level, &mut renderer)?;
    let mut saved: Option<Kept> = None;
    let mut clock = FixedStep::new(FRAME, 2)?;
    let mut summary = Summary::default();

    for frame in 0..(seconds * 1000.0 / FRAME) as u64 {
        mouse.play(&mut simulation, level.cloth, clock.dt(), &mut summary)?;
        if mouse.wants_another() {
            let what = level.toggle_second(&mut simulation, &mut renderer)?;
            summary.count(what);
        }
        if is_due(frame, SAVES) {
            saved = Some(Kept::of(&mut simulation, &level, &mut renderer)?);
            summary.count("saved");
        }
        if let Some(kept) = saved.as_ref().filter(|_| is_due(frame, LOADS)) {
            kept.restore(&mut simulation, &mut level, &mut renderer)?;
            mouse.look_again(&simulation)?;
            summary.count("loaded");
        }
        if is_due(frame, RESETS) {
            start.restore(&mut simulation, &mut level, &mut renderer)?;
            mouse.look_again(&simulation)?;
            saved = None;
            summary.count("reset");
        }

        let (begin, before) = (ThreadTime::now(), allocations());
        let (mut rolled_back, mut corrected, mut is_limited, mut work) = (0, 0, false, 0);
        for _ in 0..clock.steps_after(FRAME)? {
            let report = simulation.step(clock.dt())?;
            rolled_back += report.rolled_back;
            work += report.bodies.iter().map(|body| body.work).sum::<u32>();
            corrected += report.bodies.iter().map(|body| body.guard.corrections()).sum::<u32>();
            is_limited |= report.bodies.iter().any(|body| body.any_substep_limited);
            report.bodies.iter().for_each(|body| summary.add_guard(&body.guard));
            if report.has_failed {
                summary.count("step failed");
            }
        }
        let (time, after) = (begin.elapsed(), allocations());

        let mut is_quiet = rolled_back == 0 && corrected == 0;
        for event in simulation.drain_events() {
            is_quiet = false;
            summary.count(match event.kind {
                EventKind::Advanced { .. } => "tears advanced",
                EventKind::FragmentFreed { .. } => "pieces freed",
                EventKind::Slipped { .. } => "slipped",
                _ => "other events",
            });
        }
        mouse.look_again(&simulation)?;
        if let Some(ahead) = mouse.hand_ahead(&simulation)? {
            summary.add_held(ahead);
        }
        for body in simulation.bodies() {
            let changes = renderer.draw(&mut simulation, &clock, body)?;
            renderer.check(&mut simulation, body, frame)?;
            is_quiet &= changes == 0;
        }
        let guarded = [corrected > 0, rolled_back > 0, is_limited];
        summary.add_frame((time, work), guarded, is_quiet.then_some(after - before));
    }
    Ok((summary, simulation.hash()))
}

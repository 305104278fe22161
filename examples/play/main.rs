//! Minutes of a game about tearing cloth, as an engine or a trainer that embeds the crate would play them: a mouse that draws, tears and
//! cuts a domed sheet hung on two corners, a second sheet that comes and goes, saves, loads and resets of the level, and a
//! renderer whose copy of every mesh follows what has changed.
//!
//! `cargo run --release -p rhexis --features direct --example play -- --seconds 600 --seed 1`
//!
//! It brings its own meshes, so `snapshot` is all it needs. `--accuracy fast|haptic|game|accurate|static` takes those settings, `--corrections N` solves steps further before they are undone, `--iterations N` limits the solver's iterations, `--tolerance X` sets the relative
//! residual at which a solve ends. At the end it prints times, rolled back frames, allocations and a hash that every run with the
//! same arguments has. After each frame it asserts that the renderer's copy is the mesh, after each load and reset that the
//! state is the one that was kept.

mod level;
mod mouse;
mod renderer;
mod summary;

use cpu_time::ThreadTime;
use level::{Level, SIZE};
use mouse::Mouse;
use renderer::Renderer;
use rhexis::event::EventKind;
use rhexis::settings::{Accuracy, Settings};
use rhexis::simulation::{FixedStep, Simulation};
use rhexis::snapshot::Snapshot;
use stats_alloc::{INSTRUMENTED_SYSTEM, StatsAlloc};
use std::alloc::System;
use summary::Summary;

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// One picture, and one step of the simulation \[ms\].
const FRAME: f64 = 1000.0 / 60.0;

/// When, in frames of 60 per second, the player saves, loads what was saved, and begins the level anew.
const SAVES: (u64, u64) = (180, 90);
const LOADS: (u64, u64) = (240, 239);
const RESETS: (u64, u64) = (900, 899);

fn is_due(frame: u64, (every, at): (u64, u64)) -> bool {
    frame % every == at
}

struct Options {
    seconds: f64,
    seed: u64,
    settings: Settings,
}

impl Options {
    fn read() -> Result<Self> {
        let mut options = Self { seconds: 20.0, seed: 1, settings: Settings { threads: 1, ..Settings::default() } };
        let mut words = std::env::args().skip(1);
        while let Some(word) = words.next() {
            let value = words.next().ok_or_else(|| format!("{word} wants a value"))?;
            match word.as_str() {
                "--accuracy" => {
                    let accuracy = Accuracy::named(&value);
                    let accuracy =
                        accuracy.ok_or_else(|| format!("{value}: fast, haptic, game, accurate or static"))?;
                    options.settings = Settings { threads: 1, ..Settings::new(accuracy) };
                }
                "--seconds" => options.seconds = value.parse()?,
                "--seed" => options.seed = value.parse()?,
                "--iterations" => options.settings.advanced.linear.iterations = value.parse()?,
                "--corrections" => options.settings.advanced.newton_corrections = value.parse()?,
                "--budget" => options.settings.budget = Some(value.parse()?),
                "--tolerance" => options.settings.advanced.linear.tolerance = value.parse()?,
                _ => {
                    let known = "--seconds, --seed, --accuracy, --iterations, --corrections, --budget and --tolerance are known";
                    return Err(format!("{word}: {known}").into());
                }
            }
        }
        Ok(options)
    }
}

/// A state to go back to, with what is the host's own.
struct Kept {
    bytes: Vec<u8>,
    hash: rhexis::snapshot::StateHash,
    level: Level,
    renderer: Renderer,
}

impl Kept {
    /// The renderer first takes in what has changed: what it keeps is then of the mesh that is saved.
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
        // All is new now, and what steps change from here on is listed only when that has been read.
        for body in simulation.bodies() {
            renderer.follow(simulation, body)?;
        }
        Ok(())
    }
}

fn main() -> Result<()> {
    let Options { seconds, seed, settings } = Options::read()?;
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

        let (begin, before) = (ThreadTime::now(), ALLOCATOR.stats());
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
        let (time, after) = (begin.elapsed(), ALLOCATOR.stats());

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
        for body in simulation.bodies() {
            let changes = renderer.draw(&mut simulation, &clock, body)?;
            renderer.check(&mut simulation, body, frame)?;
            is_quiet &= changes == 0;
        }
        let allocations = (after.allocations + after.reallocations) - (before.allocations + before.reallocations);
        summary.add_frame((time, work), [corrected > 0, rolled_back > 0, is_limited], is_quiet.then_some(allocations));
    }
    println!("{seconds} s, seed {seed}, a sheet of {SIZE} mm\n{summary}\nhash {}", simulation.hash());
    Ok(())
}

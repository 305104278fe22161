//! Minutes of a game about tearing cloth, as an engine or a trainer that embeds the crate would play them: a mouse that draws, tears and
//! cuts a domed sheet hung on two corners, a second sheet that comes and goes, saves, loads and resets of the level, and a
//! renderer whose copy of every mesh follows what has changed.
//!
//! `cargo run --release -p rhexis --features direct --example play -- --seconds 600 --seed 1`
//!
//! It brings its own meshes, so `snapshot` is all it needs. `--accuracy fast|haptic|game|accurate|static` takes those settings, `--corrections N` solves steps further before they are undone, `--iterations N` limits the solver's iterations, `--tolerance X` sets the relative
//! residual at which a solve ends. At the end it prints times, rolled back frames, grasps and slips, how far the hand was ahead of its jaws,
//! allocations and a hash that every run with the same arguments has. After each frame it asserts that the renderer's copy is the mesh,
//! after each load and reset that the state is the one that was kept.

mod game;

use game::{Result, SIZE};
use rhexis::settings::{Accuracy, Settings};
use stats_alloc::{INSTRUMENTED_SYSTEM, StatsAlloc};
use std::alloc::System;

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

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

fn allocations() -> usize {
    let stats = ALLOCATOR.stats();
    stats.allocations + stats.reallocations
}

fn main() -> Result<()> {
    let Options { seconds, seed, settings } = Options::read()?;
    let (summary, hash) = game::play(seconds, seed, settings, allocations)?;
    println!("{seconds} s, seed {seed}, a sheet of {SIZE} mm\n{summary}\nhash {hash}");
    Ok(())
}

//! The stability map: where the default, the accurate and the textbook step stay stable, over time step, stiffness ratio, compression,
//! rotation speed and quality of the mesh.
//!
//! One scene serves all: a square sheet is pressed together along x, its two ends held at their places along x, and spins about that axis.
//! The ends slide freely across it, so that nothing does work on the body: whatever it gains the step has made. It starts flat, with a
//! little noise, and buckles; compression and centrifugal tension stay as long as the run. Every case is judged by what a caller would see.

mod course;
mod drift;
mod map;
mod sheet;

pub use course::{Course, Grade};
pub use drift::drift;
pub use map::{draw, printed};
pub use sheet::Quality;

use crate::bench::{BenchError, Context, Depth, Table};
use rhexis::settings::{Accuracy, Advanced, Precision, Preconditioner, Settings};

/// How steps are solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// [`Settings::default`].
    Default,
    /// [`Accuracy::Accurate`].
    Accurate,
    /// The default step, solved as in a textbook: double precision, block Jacobi, plain instructions.
    Textbook,
}

impl Mode {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Default, Self::Accurate, Self::Textbook];

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Default => "default",
            Self::Accurate => "accurate",
            Self::Textbook => "textbook",
        }
    }

    /// Its settings, on one thread.
    pub fn settings(self) -> Settings {
        let settings = match self {
            Self::Default => Settings::default(),
            Self::Accurate => Settings::new(Accuracy::Accurate),
            Self::Textbook => Settings {
                portable_instructions: true,
                advanced: Advanced {
                    preconditioner: Preconditioner::BlockJacobi,
                    precision: Precision::Double,
                    ..Advanced::default()
                },
                ..Settings::default()
            },
        };
        Settings { threads: 1, ..settings }
    }
}

/// One point of the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Case {
    /// How steps are solved.
    pub mode: Mode,
    /// Time step \[ms\].
    pub dt: f64,
    /// E_F/E_T.
    pub ratio: f64,
    /// By what part of its length the sheet is pressed together.
    pub compression: f64,
    /// Rotation speed \[rad/ms\].
    pub spin: f64,
    /// The mesh.
    pub quality: Quality,
}

/// What is swept: every value of one axis with every value of the others.
#[derive(Clone, Debug, PartialEq)]
pub struct Axes {
    /// Time steps \[ms\].
    pub dt: Vec<f64>,
    /// E_F/E_T.
    pub ratio: Vec<f64>,
    /// Parts of the length by which the sheet is pressed together.
    pub compression: Vec<f64>,
    /// Rotation speeds \[rad/ms\].
    pub spin: Vec<f64>,
    /// Meshes.
    pub quality: Vec<Quality>,
}

impl Axes {
    /// The ends of most axes, for a look whether everything works.
    pub fn quick() -> Self {
        Self {
            dt: vec![0.1, 10.0],
            ratio: vec![10.0],
            compression: vec![0.2],
            spin: vec![0.0, 0.1],
            quality: vec![Quality::Even, Quality::Slivers],
        }
    }

    /// Decades of time step and stiffness ratio; compression up to half the length; rotation up to 100 rad/s.
    pub fn usual() -> Self {
        Self {
            dt: vec![0.01, 0.1, 1.0, 10.0, 100.0],
            ratio: vec![1.0, 10.0, 100.0, 1e4],
            compression: vec![0.0, 0.2, 0.5],
            spin: vec![0.0, 0.01, 0.1],
            quality: vec![Quality::Even, Quality::Jittered, Quality::Slivers],
        }
    }

    /// The cases of a mode, time step by time step, then rotation, ratio, compression, mesh.
    pub fn cases(&self, mode: Mode) -> Vec<Case> {
        let mut cases = Vec::new();
        for &quality in &self.quality {
            for &compression in &self.compression {
                for &ratio in &self.ratio {
                    for &spin in &self.spin {
                        cases.extend(self.dt.iter().map(|&dt| Case { mode, dt, ratio, compression, spin, quality }));
                    }
                }
            }
        }
        cases
    }
}

/// The map of a mode.
#[derive(Clone, Debug)]
pub struct Map {
    /// How steps are solved.
    pub mode: Mode,
    /// In the order of [`Axes::cases`].
    pub courses: Vec<(Case, Course)>,
}

/// Steps of every case unless given otherwise.
const fn steps(depth: Depth) -> u64 {
    match depth {
        Depth::Quick => 30,
        Depth::Usual => 300,
        Depth::Full => 100_000,
    }
}

/// Runs all cases for so many steps, or as many as the depth says, and gives the maps.
///
/// # Errors
/// If the scene is refused, which would be a mistake in it.
pub fn sweep(context: &Context, steps_asked: Option<u64>) -> Result<(Axes, Vec<Map>, u64), BenchError> {
    let axes = if context.depth == Depth::Quick { Axes::quick() } else { Axes::usual() };
    let steps = steps_asked.unwrap_or(steps(context.depth));
    context.progress.set_length((Mode::ALL.len() * axes.cases(Mode::Default).len()) as u64);
    let mut maps = Vec::new();
    for mode in Mode::ALL {
        let mut courses = Vec::new();
        for case in axes.cases(mode) {
            context.progress.set_message(format!("{}, {} ms", mode.name(), case.dt));
            courses.push((case, course::run(&case, steps)?));
            context.progress.inc(1);
        }
        maps.push(Map { mode, courses });
    }
    Ok((axes, maps, steps))
}

/// Every case with its grade and figures, as a table of this name.
pub fn table(name: &str, context: &Context, maps: &[Map], steps: u64) -> Table {
    let keys = ["mode", "mesh", "compression", "stiffness_ratio", "spin_rad_per_ms", "dt_ms"];
    let figures = ["grade", "steps", "retried", "held_back", "failed", "largest_gain", "energy_left", "spin_left"];
    let mut table = Table::new(name, context, &keys, &figures);
    table.remark(format!(
        "{steps} steps; a sheet pressed together along x that spins about x, on which nothing does work"
    ));
    table.remark("retried, held_back, failed: steps. largest_gain: energy above that at the start, over it and that of a strain of 1 %");
    table.remark(
        "energy_left: at the end over the start. spin_left: angular momentum about x at the end over the start",
    );
    for (case, course) in maps.iter().flat_map(|map| &map.courses) {
        let Case { mode, dt, ratio, compression, spin, quality } = case;
        let [dt, ratio, compression, spin] = [dt, ratio, compression, spin].map(|value| value.to_string());
        let keys = [mode.name(), quality.name(), &compression, &ratio, &spin, &dt, course.grade().name()];
        let Course { steps, retried, held_back, failed, largest_gain, energy_left, spin_left, .. } = course;
        let counts = [steps, retried, held_back, failed].map(|&count| count as f64);
        table.add(&keys, &[&counts[..], &[*largest_gain, *energy_left, *spin_left]].concat());
    }
    table
}

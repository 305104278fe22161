//! Benchmarks at equal error: what a setting costs and what it buys, measured on the scenes of the catalog.
//!
//! A time by itself says little: a solver that stops early is fast and wrong. Every table here has the time of a step and the
//! error that the run has come to, accumulated over its steps against the same run solved tightly, beside each other. Times
//! are processor time of the stepping thread, so that other programs disturb them less. Every table begins with the speed of
//! the machine, measured in the same run: by it times of two machines are compared.

mod ablation;
mod clock;
mod compare;
mod equal_error;
mod errors;
mod front;
mod ladder;
mod plot;
mod solve;
mod sweep;
mod systems;
mod table;
mod targets;
mod textbook;
mod trace;
mod work_precision;
mod yardstick;

pub use ablation::ablation;
pub(crate) use clock::{Stopwatch, median, quantile};
pub use compare::compare;
pub use ladder::ladder;
pub use systems::{SIZES, systems};
pub use table::Table;
pub(crate) use table::make;
pub use targets::targets;
pub use textbook::textbook;
pub use work_precision::{SCENES, work_precision};
pub use yardstick::Yardsticks;

use indicatif::ProgressBar;
use rhexis::simulation::SimulationError;
use rhexis_scene::SceneError;
use rhexis_scene::output::OutputError;
use std::path::PathBuf;

/// How much a benchmark measures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Depth {
    /// The smallest meshes and few steps, enough to see that everything works: seconds.
    Quick,
    /// What a change is judged by: minutes.
    #[default]
    Usual,
    /// The largest meshes too: an hour and some GB.
    Full,
}

/// Arguments of every benchmark.
pub struct Context {
    /// Directory for tables and plots, made with the first of them.
    pub directory: PathBuf,
    /// How much is measured.
    pub depth: Depth,
    /// The machine's speed.
    pub yardsticks: Yardsticks,
    /// Where a benchmark says what it is at.
    pub progress: ProgressBar,
}

impl Context {
    /// Measures the machine's speed, and says nothing of what it is at.
    pub fn quiet(directory: PathBuf, depth: Depth) -> Self {
        Self { directory, depth, yardsticks: Yardsticks::measure(), progress: ProgressBar::hidden() }
    }

    /// Begins a part of the work with so many pieces.
    fn begin(&self, pieces: usize) {
        self.progress.set_length(pieces as u64);
        self.progress.set_position(0);
    }

    /// Says what is measured now.
    fn now(&self, what: impl Into<String>) {
        self.progress.set_message(what.into());
    }

    /// A piece is done.
    fn done(&self) {
        self.progress.inc(1);
    }
}

/// Why a benchmark could not be run.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    /// The scene, with what the benchmark sets in it.
    #[error("{0}")]
    Scene(#[from] SceneError),
    /// The run.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// A file that cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A directory that cannot be made, a file that cannot be read, a table that is none.
    #[error("{}: {what}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong, and how to mend it.
        what: String,
    },
    /// A name that is none of those there are.
    #[error("{0}")]
    Unknown(String),
    /// A scene that does not come to what is to be measured.
    #[error("{0}")]
    State(String),
}

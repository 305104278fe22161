//! `rhexis bench`.

use super::{Stop, outputs, say::say};
use clap::{Args, Subcommand};
use indicatif::{ProgressBar, ProgressStyle};
use rhexis_lab::bench::{self, BenchError, Context, Depth, SIZES, Table, Yardsticks};
use std::path::PathBuf;
use std::time::Duration;

pub(super) const EXAMPLES: &str = "\
Examples:
  rhexis bench work-precision fig2-haptic
  rhexis bench targets --full
  rhexis bench systems --sizes 1500,150000 --threads 1,2
  rhexis bench ablation --scene fig2-haptic --only multigrid
  rhexis bench compare benches/results/targets.csv out/bench/targets.csv

Every table is printed and written as CSV, with the machine's speed in its head; work-precision also draws SVG and PNG.
Close other programs, and compare ratios within one run.";

/// What is measured.
#[derive(Subcommand)]
pub(super) enum Bench {
    /// Error against time over meshes, solvers, tolerances, time steps and integrators.
    WorkPrecision {
        /// Only these cases [default: fig2-static, fig2-dynamic, fig2-haptic, capsulorhexis, cook, fig2-tear].
        #[arg(value_name = "CASE")]
        cases: Vec<String>,
        #[command(flatten)]
        how: How,
    },
    /// Time of every system, of a split and of a whole step; memory and allocations.
    Systems {
        /// Triangles of the squares [default: 1500,15000; 150000 and 1500000 with --full].
        #[arg(long, value_delimiter = ',', value_name = "N", value_parser = clap::value_parser!(u32).range(50..=10_000_000))]
        sizes: Vec<u32>,
        /// Numbers of threads.
        #[arg(long, value_delimiter = ',', value_name = "N", default_value = "1,2", value_parser = clap::value_parser!(u16).range(1..=1024))]
        threads: Vec<u16>,
        #[command(flatten)]
        how: How,
    },
    /// Against double precision, block Jacobi and plain instructions at the same error.
    Textbook(How),
    /// The two states that decide which solver is used: a flat taut sheet, a torn slack capsule.
    Ladder(How),
    /// The times that the engine aims at, scaled to a core of stated speed, with verdicts. A miss is no failure.
    Targets {
        /// Only the cases with this in their names, as `haptic` [default: all].
        #[arg(value_name = "NAME")]
        names: Vec<String>,
        #[command(flatten)]
        how: How,
    },
    /// Preconditioners, remedies and speed paths, each left out by itself: work, time, error and outcome.
    Ablation {
        /// Only this scene; may be repeated [default: capsulorhexis, fig2-tear, play, play-game, fig2-haptic].
        #[arg(long = "scene", value_name = "SCENE")]
        scenes: Vec<String>,
        /// Only the rows with this in their names, as `multigrid`; may be repeated [default: all].
        #[arg(long, value_name = "ROW")]
        only: Vec<String>,
        #[command(flatten)]
        how: How,
    },
    /// Two results of one benchmark beside each other, scaled by the speed of their machines.
    Compare {
        /// The earlier result (.csv).
        before: PathBuf,
        /// The later one.
        after: PathBuf,
    },
}

/// How much is measured, and where it goes.
#[derive(Args)]
pub(super) struct How {
    /// Directory for tables and plots [default: out/bench; out/stability for the stability map].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// The smallest meshes and few steps: seconds.
    #[arg(long, conflicts_with = "full")]
    quick: bool,
    /// The largest meshes too: an hour and some GB.
    #[arg(long)]
    full: bool,
}

impl From<BenchError> for Stop {
    fn from(error: BenchError) -> Self {
        match error {
            BenchError::Unknown(what) => Self::Usage(what),
            BenchError::Scene(error) => Self::Scene(error),
            error => Self::Failed(error.to_string()),
        }
    }
}

/// Measures, prints the tables and writes them.
pub(super) fn bench(what: &Bench) -> Result<(), Stop> {
    match what {
        Bench::WorkPrecision { cases, how } => measure(how, |context| bench::work_precision(context, cases)),
        Bench::Systems { sizes, threads, how } => {
            let threads: Vec<usize> = threads.iter().map(|&count| count.into()).collect();
            let sizes: Vec<usize> = sizes.iter().map(|&size| size as usize).collect();
            measure(how, |context| {
                let standard = match context.depth {
                    Depth::Quick => &SIZES[..1],
                    Depth::Usual => &SIZES[..2],
                    Depth::Full => &SIZES[..],
                };
                bench::systems(context, if sizes.is_empty() { standard } else { &sizes }, &threads)
            })
        }
        Bench::Textbook(how) => measure(how, bench::textbook),
        Bench::Ladder(how) => measure(how, bench::ladder),
        Bench::Targets { names, how } => measure(how, |context| bench::targets(context, names)),
        Bench::Ablation { scenes, only, how } => measure(how, |context| bench::ablation(context, scenes, only)),
        Bench::Compare { before, after } => say(bench::compare(before, after)?.printed().trim_end()),
    }
}

fn measure(how: &How, run: impl FnOnce(&Context) -> Result<Vec<Table>, BenchError>) -> Result<(), Stop> {
    let context = context(how, "out/bench")?;
    let tables = run(&context);
    context.progress.finish_and_clear();
    for table in tables? {
        let path = table.write(&context.directory)?;
        say(&format!("{}→ {}\n", table.printed(), path.display()))?;
    }
    Ok(())
}

/// Arguments of a measurement, its progress begun and the machine's speed printed; without `--out` it writes into `directory`.
pub(super) fn context(how: &How, directory: &str) -> Result<Context, Stop> {
    let depth = match (how.quick, how.full) {
        (true, _) => Depth::Quick,
        (_, true) => Depth::Full,
        _ => Depth::Usual,
    };
    let directory = outputs::directory(how.out.as_deref(), directory)?;
    let yardsticks = Yardsticks::measure();
    let Yardsticks { fma_gflops, triad_gbs } = yardsticks;
    say(&format!("one core: {fma_gflops:.0} GFLOP/s of f32 FMA, {triad_gbs:.1} GB/s of triad\n"))?;
    let progress = ProgressBar::new(0);
    if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos}/{len}  {elapsed}  {msg}") {
        progress.set_style(style);
    }
    progress.enable_steady_tick(Duration::from_millis(500));
    Ok(Context { directory, depth, yardsticks, progress })
}

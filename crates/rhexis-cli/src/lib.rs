//! The command line: `run`, `sweep`, `replay`, `render`, `plot`, `report`, `scenes`, `check`, `verify`, `stress`, `stability`, `soak`,
//! `view`, `bench`.
//!
//! Exit codes: 0 done, 1 refused, failed or not all written, 2 wrong usage, 130 interrupted. Errors go to standard error, results to
//! standard output; a reader that closes standard output early ends the program quietly. Ctrl-C and SIGTERM let `run`, `verify` and
//! `stress` end with what they have, a second one ends them at once, as the first does for the others: they write nothing before
//! they are done.

#![cfg_attr(not(test), warn(clippy::disallowed_methods, unreachable_pub))]
#![cfg_attr(not(test), warn(clippy::expect_used, clippy::panic, clippy::unreachable, clippy::unwrap_used))]

mod account;
mod bench;
mod caveats;
mod check;
mod checkpoint;
mod course;
mod dump;
mod files;
mod guard;
mod inputs;
mod interrupt;
mod journal;
mod kept;
mod lock;
mod moments;
#[allow(clippy::disallowed_methods, reason = "pictures, no part of a step")]
pub mod output;
mod outputs;
mod page;
#[allow(clippy::disallowed_methods, reason = "plots, no part of a step")]
mod plot;
mod progress;
#[allow(clippy::disallowed_methods, reason = "pictures, no part of a step")]
mod render;
mod replay;
mod report;
mod run;
mod say;
mod scenes;
mod series;
mod soak;
mod stability;
mod stress;
mod summary;
mod sweep;
mod tally;
mod timings;
mod verify;
mod view;

use clap::{Args, Parser, Subcommand};
use rhexis_scene::{Document, SceneError};
use std::path::PathBuf;
use std::process::ExitCode;

/// Tears fibre-reinforced soft-tissue membranes. Units: mm, g, ms, hence N and MPa.
#[derive(Parser)]
#[command(name = "rhexis", version, propagate_version = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Run a scene and write report, figures, ParaView frames and pictures.
    #[command(after_help = RUN_EXAMPLES)]
    Run(RunArgs),
    /// Run a scene over ranges, lists and random samples of its values, on all cores, into one table.
    #[command(after_help = sweep::EXAMPLES)]
    Sweep(sweep::SweepArgs),
    /// Repeat a recording and compare the hash of its end: exit code 0 if it is the same.
    #[command(after_help = "Examples:\n  rhexis run fig2-tear --record tear.rec\n  rhexis replay tear.rec")]
    Replay(ReplayArgs),
    /// Draw pictures, film strips and films of a run or of a scene.
    #[command(after_help = render::EXAMPLES)]
    Render(render::RenderArgs),
    /// Draw curves of one run or of several.
    #[command(after_help = plot::EXAMPLES)]
    Plot(plot::PlotArgs),
    /// Write a run as one HTML page: summary, notes, pictures, curves, figures.
    #[command(after_help = page::EXAMPLES)]
    Report(page::ReportArgs),
    /// List the scenes of the catalog, or print one to copy and change.
    #[command(after_help = "Examples:\n  rhexis scenes\n  rhexis scenes --show fig2 > mine.toml")]
    Scenes(ScenesArgs),
    /// Judge a scene without running it: reads its files, builds its meshes, makes its cuts.
    #[command(after_help = "Examples:\n  rhexis check mine.toml\n  rhexis check fig2 --set run.dt=5")]
    Check(SceneArgs),
    /// Compare the engine with independent computations; fails if a tolerance is missed.
    #[command(after_help = VERIFY_EXAMPLES)]
    Verify(VerifyArgs),
    /// Run hostile random tools on random scenes; fails if anything breaks.
    #[command(after_help = STRESS_EXAMPLES)]
    Stress(StressArgs),
    /// Map where the default, the accurate and the textbook step stay stable; prints, draws and tabulates.
    #[command(after_help = STABILITY_EXAMPLES)]
    Stability(stability::StabilityArgs),
    /// Tear, reset and restart a capsulorhexis for minutes; fails if live memory or the time of a step grows.
    #[command(after_help = SOAK_EXAMPLES)]
    Soak(SoakArgs),
    /// Serve the page on which a scene or a mesh is torn in a browser; on the loopback address alone.
    #[command(after_help = VIEW_EXAMPLES)]
    View(view::ViewArgs),
    /// Measure run time against error.
    #[command(subcommand, after_help = bench::EXAMPLES)]
    Bench(bench::Bench),
}

const RUN_EXAMPLES: &str = "\
Examples:
  rhexis run capsulorhexis
  rhexis run fig2-tear --set bodies.0.fibres.degrees=60 --out out/sixty
  rhexis run mine.toml --steps 20 --timings
  rhexis run fig2 --set run.mode=static --json --quiet > report.json
  rhexis run capsulorhexis --snapshots 100      then, if it was killed:
  rhexis run capsulorhexis --snapshots 100 --resume

Ctrl-C ends it after the step, with report and state: --resume goes on.

Written into the output directory, as the run goes on:
  report.json    figures at the end: reactions [N], energies [mJ], tears, solver, times, caveats
  series.csv     one row per step
  events.jsonl   one tear event per line
  frames.pvd     ParaView frames (.vtu): displacement [mm], stress [MPa], fibre, criterion;
                 velocity [mm/ms] and force [N] with output.velocities, output.forces
  *.png          pictures of the first, some middle and the last state
  run.snapshot   the last state to resume from, with --snapshots
  run.lock       while it runs: a second run into the same directory is refused

Written into the directory of --dump, at the end:
  positions.csv  vertices now and at rest [mm]
  vertices.csv   mass [g], velocity [mm/ms], elastic force of the membrane now, sum of all forces but the holds' in the last solve [N]
  reactions.csv  forces of holds and grips [N]
  stresses.csv   Biot stress per triangle, in space [MPa]
  tips.csv       place, last direction, mean Biot stress over the disc [MPa], chosen direction (rest shape), criterion, decider with its reason";

const VERIFY_EXAMPLES: &str = "\
Examples:
  rhexis verify
  rhexis verify cook --json
  rhexis verify tear --out out/tear
  rhexis verify tear --quick

Plots of tear paths and curves are written into the output directory as SVG, PNG and CSV.";

const STRESS_EXAMPLES: &str = "\
Examples:
  rhexis stress
  rhexis stress --minutes 60 --seed 7 --json > stress.json
  rhexis stress --seed 7 --case 1234      that case alone, once more

A case that fails is saved as a recording, for `rhexis replay`.";

const STABILITY_EXAMPLES: &str = "\
Examples:
  rhexis stability --quick
  rhexis stability --out benches/results
  rhexis stability --full      100,000 steps per case: a day

stability.csv has a row per case; stability.svg and .png show the grades, stability-energy.svg and .png the energy that is left.";

const SOAK_EXAMPLES: &str = "\
Examples:
  rhexis soak
  rhexis soak --minutes 60 --json > soak.json
  rhexis soak --set bodies.0.mesh.cap.triangles=20000";

const VIEW_EXAMPLES: &str = "\
Examples:
  rhexis view
  rhexis view fig2-tear --set bodies.0.fibres.degrees=60
  rhexis view surface.obj
  rhexis view --build surface.obj

Nothing is built or fetched without --build. The page is the folder rhexis-page beside the program, or bindings/web/dist of its checkout.";

#[derive(Args)]
struct SceneArgs {
    /// Name of a catalog scene (see `rhexis scenes`) or path of a scene file.
    #[arg(value_name = "SCENE|FILE")]
    scene: String,
    /// Change a value of the scene: dotted path, arrays by index, value as in TOML. May be repeated.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
}

#[derive(Args)]
struct RunArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Output directory [default: out/<scene>].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Number of steps at the most, instead of the scene's.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(..=rhexis_scene::MOST_STEPS))]
    steps: Option<u64>,
    /// Threads, 0 for one per core; the results are the same bits for any number.
    #[arg(long, value_name = "N", value_parser = threads)]
    threads: Option<usize>,
    /// Print the systems of the step in order with their times; systems without work as skipped.
    #[arg(long)]
    timings: bool,
    /// Print only the report, as JSON, on standard output.
    #[arg(long)]
    json: bool,
    /// Also write the final state as CSV with 17 digits into DIR: positions [mm], reactions [N], stresses [MPa], vertices (velocities
    /// [mm/ms], forces [N]), tips (averaged stress, direction, criterion and what decides, also at rest).
    #[arg(long, value_name = "DIR")]
    dump: Option<PathBuf>,
    /// Every N steps keep the whole state in the output directory (run.snapshot), to resume from.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    snapshots: Option<u64>,
    /// Go on from the last snapshot in the output directory: the results are those of a run without a break.
    #[arg(long)]
    resume: bool,
    /// Record the run into FILE, for `rhexis replay`.
    #[arg(long, value_name = "FILE", conflicts_with = "resume")]
    record: Option<PathBuf>,
    /// No progress bar and no summary.
    #[arg(long)]
    quiet: bool,
}

#[derive(Args)]
struct ReplayArgs {
    /// A recording.
    #[arg(value_name = "FILE")]
    file: PathBuf,
}

#[derive(Args)]
struct ScenesArgs {
    /// Print this scene's file.
    #[arg(long, value_name = "NAME")]
    show: Option<String>,
}

#[derive(Args)]
struct VerifyArgs {
    /// Only this case, or this group of cases: `mechanics` or `tear` [default: all].
    #[arg(value_name = "CASE|GROUP")]
    case: Option<String>,
    /// Directory for plots [default: out/verify].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Coarse meshes only: seconds per case instead of minutes.
    #[arg(long)]
    quick: bool,
    /// Print the rows as JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Args)]
struct StressArgs {
    /// Run cases until there are so many steps [default: 20000].
    #[arg(long, value_name = "N", conflicts_with = "minutes")]
    steps: Option<u64>,
    /// Run cases for so long.
    #[arg(long, value_name = "M", value_parser = minutes)]
    minutes: Option<f64>,
    /// Seed of the cases; from 10,000 on most tears glide.
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Only the case with this number.
    #[arg(long, value_name = "K", conflicts_with_all = ["steps", "minutes"])]
    case: Option<u64>,
    /// Directory for recordings of failed cases [default: out/stress].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print the counts and the failures as JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Args)]
struct SoakArgs {
    /// Run for so long.
    #[arg(long, value_name = "M", value_parser = minutes, default_value = "10")]
    minutes: f64,
    /// Seed of the hand's errors.
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Change a value of the scene `capsulorhexis`: dotted path, arrays by index, value as in TOML. May be repeated.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Print the figures of every round as JSON.
    #[arg(long)]
    json: bool,
}

/// As many as a scene may ask for.
fn threads(text: &str) -> Result<usize, String> {
    let threads: usize = text.parse().map_err(|_| "not a whole number, zero or more".to_owned())?;
    (threads <= 1024).then_some(threads).ok_or_else(|| "it must be at most 1024; 0 is one per core".to_owned())
}

/// A year of minutes at the most.
fn minutes(text: &str) -> Result<f64, String> {
    let minutes: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    (minutes > 0.0 && minutes <= 525_600.0)
        .then_some(minutes)
        .ok_or_else(|| "it must be above 0 and at most 525600".to_owned())
}

/// Why a command ended early.
enum Stop {
    /// The scene was refused.
    Scene(SceneError),
    /// Something else went wrong.
    Failed(String),
    /// Wrong usage that the argument parser cannot see.
    Usage(String),
    /// Everything is said already; only the exit code is left.
    Silent,
    /// Nobody reads standard output any more.
    ClosedPipe,
    /// Somebody has asked it to end; what it had is written.
    Interrupted,
}

impl From<SceneError> for Stop {
    fn from(error: SceneError) -> Self {
        Self::Scene(error)
    }
}

/// Runs the program.
pub fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            let plain = error.to_string();
            if say::is_printable(&plain) {
                // The only failure here is that nobody reads it.
                let _ = error.print();
            } else {
                say::complain(plain.trim_end());
            }
            return ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2));
        }
    };
    let outcome = match cli.command {
        Command::Run(args) => run::run(&args),
        Command::Sweep(args) => sweep::sweep(&args),
        Command::Replay(args) => replay::replay(&args),
        Command::Render(args) => render::render(&args),
        Command::Plot(args) => plot::plot(&args),
        Command::Report(args) => page::page(&args),
        Command::Scenes(args) => scenes::scenes(&args),
        Command::Check(args) => check::check(&args),
        Command::Verify(args) => verify::verify(&args),
        Command::Stress(args) => stress::stress(&args),
        Command::Stability(args) => stability::stability(&args),
        Command::Soak(args) => soak::soak(&args),
        Command::View(args) => view::view(&args),
        Command::Bench(what) => bench::bench(&what),
    };
    match outcome {
        Ok(()) | Err(Stop::ClosedPipe) => ExitCode::SUCCESS,
        Err(Stop::Silent) => ExitCode::FAILURE,
        Err(Stop::Interrupted) => {
            say::complain("interrupted");
            ExitCode::from(interrupt::EXIT_CODE)
        }
        Err(Stop::Scene(error)) => {
            say::complain(&format!("error: {error}"));
            ExitCode::FAILURE
        }
        Err(Stop::Failed(what)) => {
            say::complain(&format!("error: {what}"));
            ExitCode::FAILURE
        }
        Err(Stop::Usage(what)) => {
            say::complain(&format!("error: {what}"));
            ExitCode::from(2)
        }
    }
}

/// The scene that the arguments name, with their changes made.
fn document(args: &SceneArgs) -> Result<Document, Stop> {
    let mut document = Document::open(&args.scene)?;
    args.set.iter().try_for_each(|assignment| document.set(assignment))?;
    Ok(document)
}

//! `rhexis stability`.

use super::bench::{How, context};
use super::{Stop, say::say};
use clap::Args;
use rhexis_lab::stability;

/// How far the map goes.
#[derive(Args)]
pub(super) struct StabilityArgs {
    /// Steps of every case [default: 300; 30 with --quick, 100000 with --full].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    steps: Option<u64>,
    /// Instead of the map a few cases for 100,000 steps each, or as many as `--steps` says: what is left of their energy and spin.
    #[arg(long, conflicts_with_all = ["quick", "full"])]
    drift: bool,
    #[command(flatten)]
    how: How,
}

/// Runs all cases, prints the map and draws it; or measures the drift.
pub(super) fn stability(args: &StabilityArgs) -> Result<(), Stop> {
    let context = context(&args.how, "out/stability")?;
    if args.drift {
        let outcome = stability::drift(&context, args.steps);
        context.progress.finish_and_clear();
        let (maps, steps) = outcome?;
        let table = stability::table("stability-drift", &context, &maps, steps);
        let path = table.write(&context.directory)?;
        return say(&format!("{}\n→ {}", table.printed(), path.display()));
    }
    let outcome = stability::sweep(&context, args.steps);
    context.progress.finish_and_clear();
    let (axes, maps, steps) = outcome?;
    let path = stability::table("stability", &context, &maps, steps).write(&context.directory)?;
    stability::draw(&context.directory, &axes, &maps, steps)?;
    say(&format!("{}\n→ {} and pictures beside it", stability::printed(&axes, &maps), path.display()))
}

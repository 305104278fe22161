//! `rhexis stability`.

use super::bench::{How, context};
use super::{Stop, say::say};
use crate::stability;
use clap::Args;

/// How far the map goes.
#[derive(Args)]
pub(super) struct StabilityArgs {
    /// Steps of every case [default: 300; 30 with --quick, 100000 with --full].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    steps: Option<u64>,
    #[command(flatten)]
    how: How,
}

/// Runs all cases, prints the map and draws it.
pub(super) fn stability(args: &StabilityArgs) -> Result<(), Stop> {
    let context = context(&args.how, "out/stability")?;
    let outcome = stability::sweep(&context, args.steps);
    context.progress.finish_and_clear();
    let (axes, maps, steps) = outcome?;
    let path = stability::table(&context, &maps, steps).write(&context.directory)?;
    stability::draw(&context.directory, &axes, &maps, steps)?;
    say(&format!("{}\n→ {} and pictures beside it", stability::printed(&axes, &maps), path.display()))
}

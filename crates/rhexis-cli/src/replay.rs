//! `rhexis replay`.

use super::{ReplayArgs, Stop, say::say};
use rhexis::replay::{Input, Recording};
use rhexis::snapshot::SnapshotError;
use std::time::Instant;

/// Repeats a recording and compares its end.
pub(super) fn replay(args: &ReplayArgs) -> Result<(), Stop> {
    let recording = Recording::load(&args.file).map_err(|error| {
        Stop::Failed(match error {
            // It has the file's name.
            SnapshotError::File { .. } => {
                format!("cannot read {error}; `rhexis run SCENE --record FILE` makes a recording")
            }
            error => format!("{}: {error}", args.file.display()),
        })
    })?;
    let start = Instant::now();
    let simulation = recording.replay().map_err(|error| Stop::Failed(error.to_string()))?;
    let is_step = |input: &&Input| matches!(input, Input::Step { .. });
    say(&format!(
        "{} inputs, {} of them steps, from {} to {} ms in {:.2} s: the same hash {}",
        recording.inputs().len(),
        recording.inputs().iter().filter(is_step).count(),
        recording.start().time(),
        simulation.time(),
        start.elapsed().as_secs_f64(),
        simulation.hash()
    ))
}

//! What many steps add up to: a few sheets that move for ever but for what the step takes away.

use super::{Case, Map, Mode, Quality, course};
use crate::bench::{BenchError, Context};

/// Steps of every case unless given otherwise.
const STEPS: u64 = 100_000;

/// Time steps \[ms\]: the waves of the first sheet are resolved by a hundred, ten and one of them.
const DT: [f64; 4] = [0.01, 0.1, 1.0, 10.0];

/// A sheet that spins as it is, one that buckles and goes on swinging and turning, and one of stiff fibres and a bad mesh.
fn cases(mode: Mode) -> impl Iterator<Item = Case> {
    let sheets =
        [(Quality::Even, 0.0, 10.0, 0.01), (Quality::Even, 0.2, 10.0, 0.01), (Quality::Slivers, 0.5, 1e4, 0.1)];
    sheets.into_iter().flat_map(move |(quality, compression, ratio, spin)| {
        DT.map(|dt| Case { mode, dt, ratio, compression, spin, quality })
    })
}

/// Runs the cases of all modes for so many steps, or a hundred thousand.
///
/// # Errors
/// If the scene is refused, which would be a mistake in it.
pub fn drift(context: &Context, steps_asked: Option<u64>) -> Result<(Vec<Map>, u64), BenchError> {
    let steps = steps_asked.unwrap_or(STEPS);
    context.progress.set_length(Mode::ALL.into_iter().flat_map(cases).count() as u64);
    let mut maps = Vec::new();
    for mode in Mode::ALL {
        let mut courses = Vec::new();
        for case in cases(mode) {
            context.progress.set_message(format!("{}, {} ms", mode.name(), case.dt));
            courses.push((case, course::run(&case, steps)?));
            context.progress.inc(1);
        }
        maps.push(Map { mode, courses });
    }
    Ok((maps, steps))
}

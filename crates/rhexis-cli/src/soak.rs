//! `rhexis soak`.

use super::{SoakArgs, Stop, say::say};
use indicatif::{ProgressBar, ProgressStyle};
use rhexis_lab::soak::{MOST_GROWTH, MOST_SLOWDOWN, Round, Soak, Verdict};
use serde::Serialize;
use std::time::{Duration, Instant};

#[derive(Serialize)]
struct Output<'a> {
    /// `None` where there were too few rounds to judge.
    passed: Option<bool>,
    seed: u64,
    seconds: f64,
    steps: u64,
    tears: u64,
    resets: u64,
    restarts: usize,
    verdict: Option<Verdict>,
    rounds: &'a [Round],
}

/// Runs rounds until time is up.
pub(super) fn soak(args: &SoakArgs) -> Result<(), Stop> {
    let (start, time) = (Instant::now(), Duration::from_secs_f64(60.0 * args.minutes));
    let progress = ProgressBar::new(time.as_secs());
    if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos}/{len} s  {msg}") {
        progress.set_style(style);
    }
    let mut soak = Soak::new(&args.set, args.seed)?;
    while soak.rounds().is_empty() || start.elapsed() < time {
        soak.round()?;
        progress.set_position(start.elapsed().as_secs());
        progress.set_message(format!("{} rounds", soak.rounds().len()));
    }
    progress.finish_and_clear();
    let rounds = soak.rounds();
    let sum = |of: fn(&Round) -> u64| rounds.iter().map(of).sum();
    let verdict = Verdict::of(rounds);
    let output = Output {
        passed: verdict.map(|verdict| verdict.passes()),
        seed: args.seed,
        seconds: start.elapsed().as_secs_f64(),
        steps: sum(|round| round.steps),
        tears: sum(|round| round.tears),
        resets: sum(|round| round.resets),
        restarts: rounds.iter().filter(|round| round.is_restart).count(),
        verdict,
        rounds,
    };
    if args.json {
        say(&serde_json::to_string_pretty(&output).map_err(|error| Stop::Failed(error.to_string()))?)?;
    } else {
        say(&summary(&output))?;
    }
    if output.passed == Some(false) { Err(Stop::Silent) } else { Ok(()) }
}

fn summary(output: &Output) -> String {
    let Output { seconds, steps, tears, resets, restarts, rounds, .. } = output;
    let mut text = format!(
        "{} rounds in {seconds:.0} s: {steps} steps, {tears} advances of tears, {resets} resets, {restarts} restarts\n",
        rounds.len()
    );
    if let Some(last) = rounds.last() {
        let mb = |bytes: u64| bytes as f64 * 1e-6;
        text += &format!("heap {:.4} MB in live bytes, resident {:.2} MB\n", mb(last.heap), mb(last.resident));
    }
    let Some(verdict) = &output.verdict else { return text + "too few rounds to judge; give it more minutes" };
    let percent = |part: f64| 100.0 * part;
    text += &format!(
        "from the first third of the rounds to the last: heap {:+.4} % (at most {}), time of a step {:+.2} % (at most {}); resident, not judged, {:+.3} %\n",
        percent(verdict.heap_growth),
        percent(MOST_GROWTH),
        percent(verdict.slowdown),
        percent(MOST_SLOWDOWN),
        percent(verdict.resident_growth)
    );
    text += if verdict.is_leaking { "THE HEAP RISES STEADILY: A LEAK\n" } else { "no steady rise of the heap\n" };
    text += if verdict.is_same { "every round ended in the same state" } else { "ROUNDS ENDED IN DIFFERENT STATES" };
    text + if verdict.passes() { "\npassed" } else { "\nFAILED" }
}

//! `rhexis stress`.

use super::interrupt::Interrupt;
use super::{Stop, StressArgs, outputs, say::complain, say::say};
use rhexis_lab::stress::{self, Counts, Failure, Outcome};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Steps without any other limit.
const STEPS: u64 = 20_000;

#[derive(Serialize)]
struct Output {
    passed: bool,
    seed: u64,
    seconds: f64,
    #[serde(flatten)]
    counts: Counts,
    /// How often each kind of failure.
    failures_by_kind: BTreeMap<stress::FailureKind, u64>,
    failures: Vec<Failed>,
}

#[derive(Serialize)]
struct Failed {
    #[serde(flatten)]
    failure: Failure,
    /// The file for `rhexis replay`.
    recording: Option<PathBuf>,
    /// That of a short one that fails the same way.
    short: Option<PathBuf>,
}

/// Runs cases until there are steps enough or time is up.
pub(super) fn stress(args: &StressArgs) -> Result<(), Stop> {
    let start = Instant::now();
    let least_steps = match (args.steps, args.minutes) {
        (Some(steps), _) => steps,
        (None, Some(_)) => u64::MAX,
        (None, None) => STEPS,
    };
    let most_time = args.minutes.map_or(Duration::MAX, |minutes| Duration::from_secs_f64(60.0 * minutes));
    let directory = outputs::directory(args.out.as_deref(), "out/stress")?;
    let interrupt = Interrupt::watch()?;
    let (mut counts, mut failures) = (Counts::default(), Vec::new());
    for case in args.case.map_or(0..=u64::MAX, |case| case..=case) {
        if counts.steps >= least_steps || start.elapsed() >= most_time || interrupt.is_asked() {
            break;
        }
        let outcome = stress::run(args.seed, case);
        counts.add(&outcome.counts);
        failures.extend(failed(outcome, &directory)?);
    }
    let mut failures_by_kind: BTreeMap<_, u64> = stress::FailureKind::ALL.map(|kind| (kind, 0)).into();
    failures.iter().for_each(|failed: &Failed| *failures_by_kind.entry(failed.failure.kind).or_default() += 1);
    let passed = failures.is_empty();
    let seconds = start.elapsed().as_secs_f64();
    let output = Output { passed, seed: args.seed, seconds, counts, failures_by_kind, failures };
    if args.json {
        say(&serde_json::to_string_pretty(&output).map_err(|error| Stop::Failed(error.to_string()))?)?;
    } else {
        say(&summary(&output))?;
    }
    match (passed, interrupt.is_asked()) {
        (_, true) => Err(Stop::Interrupted),
        (true, _) => Ok(()),
        (false, _) => Err(Stop::Silent),
    }
}

/// Tells of a case that has failed, and saves it.
fn failed(outcome: Outcome, directory: &Path) -> Result<Option<Failed>, Stop> {
    let Some(failure) = outcome.failure else { return Ok(None) };
    let Failure { seed, case, step, kind, what } = &failure;
    complain(&format!("failed: {kind:?} at step {step}: {what}\n  rhexis stress --seed {seed} --case {case}"));
    let save = |recording: rhexis::replay::Recording, what: &str| {
        let file = directory.join(format!("{seed}-{case}{what}.rec"));
        let cannot = |error: &dyn std::fmt::Display| Stop::Failed(format!("cannot write {}: {error}", file.display()));
        std::fs::create_dir_all(directory).map_err(|error| cannot(&error))?;
        recording.save(&file).map_err(|error| cannot(&error))?;
        complain(&format!("  rhexis replay {}", file.display()));
        Ok::<PathBuf, Stop>(file)
    };
    let recording = outcome.recording.map(|recording| save(recording, "")).transpose()?;
    let short = outcome.short.map(|recording| save(recording, "-short")).transpose()?;
    Ok(Some(Failed { failure, recording, short }))
}

fn summary(output: &Output) -> String {
    let Counts { cases, steps, tears, rollbacks, failed_steps, step_limited, slowest_step, slowest_case } =
        &output.counts;
    let mut lines = format!(
        "{cases} cases of seed {}, {steps} steps in {:.1} s: {tears} advances of tears, {rollbacks} rollbacks, {step_limited} steps limited, \
         {failed_steps} failed steps; the longest step {slowest_step:.0} ms (case {slowest_case})\n{} failures",
        output.seed,
        output.seconds,
        output.failures.len()
    );
    let found = output.failures_by_kind.iter().filter(|(_, count)| **count > 0);
    found.for_each(|(kind, count)| lines += &format!("\n  {kind:?}: {count}"));
    lines
}

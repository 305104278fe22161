//! The cases on all cores, with one progress bar.

use super::case::{Case, Runner};
use super::record::Record;
use crate::Stop;
use crate::journal::Journal;
use crate::say::complain;
use indicatif::{ProgressBar, ProgressStyle};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;
use std::time::Duration;

/// Runs cases on so many threads and adds their records to the file and to the others as they end.
///
/// # Errors
/// Where it was interrupted or something could not be written; what has ended until then is kept.
pub(super) fn run(
    runner: &Runner<'_>,
    cases: &[&Case],
    jobs: usize,
    records: &mut BTreeMap<String, Record>,
    journal: &mut Journal,
    is_quiet: bool,
) -> Result<(), Stop> {
    let bar = Bar::new(cases.len(), is_quiet);
    let (next, is_over) = (AtomicUsize::new(0), AtomicBool::new(false));
    let (sender, ended) = mpsc::channel();
    let mut outcome = Ok(());
    std::thread::scope(|scope| {
        for _ in 0..jobs.min(cases.len()) {
            let (sender, next, is_over) = (sender.clone(), &next, &is_over);
            scope.spawn(move || {
                while !is_over.load(Ordering::Relaxed) && !runner.interrupt.is_asked() {
                    let Some(case) = cases.get(next.fetch_add(1, Ordering::Relaxed)) else { break };
                    // The other end lives as long as this scope.
                    let _ = sender.send((*case, runner.run(case)));
                }
            });
        }
        drop(sender);
        for (case, result) in ended {
            let kept = result.and_then(|record| keep(runner, case, record, records, journal, &bar));
            if let Err(error) = kept {
                is_over.store(true, Ordering::Relaxed);
                // The first reason is the one to tell; an interruption is none where something else went wrong.
                if outcome.is_ok() || matches!(outcome, Err(Stop::Interrupted)) {
                    outcome = Err(error);
                }
            }
        }
    });
    bar.finish();
    if outcome.is_ok() && runner.interrupt.is_asked() && next.load(Ordering::Relaxed) < cases.len() {
        return Err(Stop::Interrupted);
    }
    outcome
}

fn keep(
    runner: &Runner<'_>,
    case: &Case,
    record: Record,
    records: &mut BTreeMap<String, Record>,
    journal: &mut Journal,
    bar: &Bar,
) -> Result<(), Stop> {
    let line = serde_json::to_string(&record).map_err(|error| Stop::Failed(error.to_string()))?;
    let written = journal.append(format!("{line}\n").as_bytes());
    let failed =
        |error: std::io::Error| Stop::Failed(format!("cannot write {}: {error}; make room", super::record::NAME));
    written.map_err(failed)?;
    // On the disk before the case counts as done.
    let _ = journal.mark();
    if !runner.plan.keep {
        let folder = runner.folder(case);
        if let Err(error) = std::fs::remove_dir_all(&folder)
            && error.kind() != std::io::ErrorKind::NotFound
        {
            bar.complain(&format!("warning: cannot remove {}: {error}", folder.display()));
        }
    }
    bar.advance(case, &record);
    records.insert(record.key.clone(), record);
    Ok(())
}

/// Cases done, failed, and the time left; nothing if standard error is no terminal.
struct Bar {
    bar: ProgressBar,
    failed: AtomicUsize,
}

impl Bar {
    fn new(cases: usize, is_quiet: bool) -> Self {
        let bar = if is_quiet { ProgressBar::hidden() } else { ProgressBar::new(cases as u64) };
        if let Ok(style) = ProgressStyle::with_template("{bar:30} case {pos}/{len}  {msg}  {eta} left") {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(500));
        Self { bar, failed: AtomicUsize::new(0) }
    }

    fn advance(&self, case: &Case, record: &Record) {
        let failed = self.failed.fetch_add(usize::from(record.has_failed()), Ordering::Relaxed);
        let failed = failed + usize::from(record.has_failed());
        self.bar.inc(1);
        let outcome = record.measure("outcome").and_then(|outcome| outcome.as_str()).unwrap_or(&record.end);
        self.bar.set_message(format!("last: {} {outcome}; {failed} failed", case.number));
    }

    fn complain(&self, what: &str) {
        self.bar.suspend(|| complain(what));
    }

    fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

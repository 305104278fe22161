//! `rhexis sweep`: a scene run over ranges, lists and random samples of its values, with one table.

mod case;
mod charts;
mod measures;
mod plan;
mod pool;
mod record;
mod table;
mod values;

use crate::interrupt::{self, Interrupt};
use crate::lock::Lock;
use crate::say::{complain, say};
use crate::{Stop, threads};
use case::{Case, Runner};
use clap::Args;
use plan::Plan;
use record::Record;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};

#[derive(Args)]
pub(super) struct SweepArgs {
    /// A sweep file (TOML).
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Output directory [default: out/<name of the file>].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Cases at a time, 0 for one per core; each runs on one thread, and the table has the same bytes for any number.
    #[arg(long, value_name = "N", default_value = "0", value_parser = threads)]
    jobs: usize,
    /// Change a value of the scene in all cases, as in `rhexis run`. May be repeated.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Run the cases again that have failed.
    #[arg(long)]
    retry_failed: bool,
    /// Every N steps keep the state of a case, to go on from after the program was killed.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    snapshots: Option<u64>,
    /// Print the cases with their values, and run none.
    #[arg(long, conflicts_with_all = ["case", "table"])]
    list: bool,
    /// Write table and plots from the cases that are done, and run none.
    #[arg(long, conflicts_with = "case")]
    table: bool,
    /// Run this case alone and print its record as JSON, a line of cases.jsonl; no table is written.
    #[arg(long, value_name = "N")]
    case: Option<u64>,
    /// End the case when standard input ends: for programs that start this one and may be killed.
    #[arg(long, requires = "case")]
    until_input_ends: bool,
    /// Print the list, or what was done, as JSON.
    #[arg(long)]
    json: bool,
    /// No progress bar and no summary.
    #[arg(long)]
    quiet: bool,
}

pub(super) const EXAMPLES: &str = "\
Example, as fibres.toml:
  scene = \"fig2-tear\"       # of the catalog, or a scene file beside this one
  samples = 4               # random samples of every combination
  seed = 1

  [set]                     # in all cases; keys as --set has them, in quotes
  \"run.dt\" = 10

  [vary]                    # every combination; \"a.b, c.d\" = [1, 2] gives both keys the same value
  \"bodies.0.fibres.degrees\" = [45, 60, 75]
  \"bodies.0.material.young_fibre\" = { from = 5, to = 20, count = 3 }   # or step = 5; scale = \"log\"

  [sample]                  # uniform, log_uniform, normal, integer, choice
  \"bodies.0.tearing.strength_along_fibres\" = { uniform = [0.04, 0.06] }

  rhexis sweep fibres.toml
  rhexis sweep fibres.toml --list
  rhexis sweep fibres.toml --case 7 --out out/seven

Ctrl-C ends it; the same command goes on, and runs no case again that is done, also after the file has got more values.

Written into the output directory:
  table.csv      one row per case: values, how it ended, measures of report.json; the same bytes on any number of cores
  times.csv      seconds of each case
  cases.jsonl    what is done, a line per case as it ends
  cases/         each case's own directory (report.json, series.csv, events.jsonl); gone with keep = false
  plots/         measures over each parameter, by outcome, as SVG and PNG";

/// Runs a sweep file, or what is asked of it.
pub(super) fn sweep(args: &SweepArgs) -> Result<(), Stop> {
    let plan = Plan::read(&args.file, &args.set)?;
    let stem = args.file.file_stem().unwrap_or_default();
    let folder = args.out.clone().unwrap_or_else(|| PathBuf::from("out").join(stem));
    if let Some(number) = args.case {
        return alone(args, &plan, &folder, number);
    }
    let cases = case::all(&plan)?;
    if args.list {
        return list(args, &plan, &folder, &cases);
    }
    let lock = Lock::take(&folder)?;
    let (mut records, mut journal) = record::open(lock.folder())?;
    let is_done =
        |case: &&Case| records.get(&case.key).is_some_and(|record| !args.retry_failed || !record.has_failed());
    let mut waiting: Vec<&Case> =
        if args.table { Vec::new() } else { cases.iter().filter(|case| !is_done(case)).collect() };
    // Two cases of one key are one run.
    let mut seen = std::collections::BTreeSet::new();
    waiting.retain(|case| seen.insert(&case.key));
    let interrupt = Interrupt::watch()?;
    interrupt::outlive_file_limits();
    let runner = Runner { plan: &plan, folder: folder.join("cases"), snapshots: args.snapshots, interrupt };
    let jobs = match args.jobs {
        0 => std::thread::available_parallelism().map_or(1, usize::from),
        jobs => jobs,
    };
    let outcome = pool::run(&runner, &waiting, jobs, &mut records, &mut journal, args.quiet);
    table::write(&folder, &plan, &cases, &records)?;
    let plots = charts::draw(&folder, &plan, &cases, &records)?;
    tell(args, &folder, &cases, &records, plots)?;
    outcome
}

/// What was done, at the end.
fn tell(
    args: &SweepArgs,
    folder: &Path,
    cases: &[Case],
    records: &BTreeMap<String, Record>,
    plots: usize,
) -> Result<(), Stop> {
    let done: Vec<(&Case, &Record)> = cases.iter().filter_map(|case| Some((case, records.get(&case.key)?))).collect();
    let failed: Vec<_> = done.iter().filter(|(_, record)| record.has_failed()).collect();
    if args.json {
        let told = json!({
            "cases": cases.len(), "done": done.len(), "failed": failed.len(), "plots": plots,
            "table": folder.join(table::NAMES[0]),
        });
        return say(&told.to_string());
    }
    if args.quiet {
        return Ok(());
    }
    for (case, record) in failed.iter().take(MOST_TOLD) {
        let reason = record.reason.as_deref().unwrap_or_default();
        complain(&format!("case {}: {}: {reason}", case.number, record.end));
    }
    if failed.len() > MOST_TOLD {
        complain(&format!("and {} more that failed: see the column `reason`", failed.len() - MOST_TOLD));
    }
    say(&format!("{} of {} cases done, {} failed", done.len(), cases.len(), failed.len()))?;
    say(&format!("{} and {plots} plots written to {}", table::NAMES[0], folder.display()))
}

/// Failed cases that are reported at the end.
const MOST_TOLD: usize = 10;

/// Runs one case and prints its record.
fn alone(args: &SweepArgs, plan: &Plan, folder: &Path, number: u64) -> Result<(), Stop> {
    let case = case::one(plan, number)?;
    let interrupt = Interrupt::watch()?;
    interrupt::outlive_file_limits();
    if args.until_input_ends {
        let asked = interrupt.clone();
        std::thread::spawn(move || {
            // An error of reading is an end as well.
            let _ = std::io::stdin().lock().read_to_end(&mut Vec::new());
            asked.ask();
        });
    }
    let runner = Runner { plan, folder: folder.join("cases"), snapshots: args.snapshots, interrupt };
    let record = runner.run(&case)?;
    say(&serde_json::to_string(&record).map_err(|error| Stop::Failed(error.to_string()))?)
}

/// Prints the cases, as CSV or JSON.
fn list(args: &SweepArgs, plan: &Plan, folder: &Path, cases: &[Case]) -> Result<(), Stop> {
    let records = record::read(folder)?;
    let names: Vec<&str> = plan.parameters().iter().map(|parameter| parameter.name.as_str()).collect();
    let is_done = |case: &Case| records.get(&case.key).is_some_and(|record| !args.retry_failed || !record.has_failed());
    if args.json {
        let told = |case: &Case| {
            let values =
                names.iter().zip(&case.values).map(|(name, value)| ((*name).to_owned(), json!(table::cell(value))));
            let values: Map<String, Value> = values.collect();
            json!({ "case": case.number, "key": case.key, "is_done": is_done(case), "values": values })
        };
        let told: Vec<Value> = cases.iter().map(told).collect();
        return say(&json!({ "scene": plan.scene, "out": folder, "parameters": names, "cases": told }).to_string());
    }
    let mut table = csv::Writer::from_writer(Vec::new());
    let header =
        ["case", "run", "done"].into_iter().chain(names.iter().copied()).map(str::to_owned).collect::<Vec<_>>();
    let rows = cases.iter().map(|case| {
        let first = [case.number.to_string(), case.key.clone(), is_done(case).to_string()];
        first.into_iter().chain(case.values.iter().map(|value| table::cell(value))).collect::<Vec<_>>()
    });
    let written = std::iter::once(header).chain(rows).try_for_each(|row| table.write_record(row));
    written.map_err(|error| Stop::Failed(error.to_string()))?;
    let bytes = table.into_inner().map_err(|error| Stop::Failed(error.to_string()))?;
    say(String::from_utf8_lossy(&bytes).trim_end())
}

//! One case: its key, its run on one thread, its record.

use super::plan::Plan;
use super::record::Record;
use crate::inputs::Inputs;
use crate::interrupt::Interrupt;
use crate::{RunArgs, SceneArgs, Stop, checkpoint, kept, run};
use rhexis::internal::fingerprint;
use rhexis_scene::{Document, Scene};
use serde_json::Value;
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

/// A case of a plan.
#[derive(Clone, Debug)]
pub(super) struct Case {
    /// Its number, from 0.
    pub number: u64,
    /// The values of the parameters as text of a scene file.
    pub values: Vec<String>,
    /// As [`Record::key`].
    pub key: String,
}

/// All cases of a plan.
///
/// # Errors
/// For a key or value that the schema refuses, and a file that cannot be read.
pub(super) fn all(plan: &Plan) -> Result<Vec<Case>, Stop> {
    let document = Document::open(&plan.scene)?;
    let mut files = Files::new();
    (0..plan.count()).map(|number| case(plan, &document, number, &mut files)).collect()
}

/// The case with this number.
///
/// # Errors
/// As [`all`], and where there is none.
pub(super) fn one(plan: &Plan, number: u64) -> Result<Case, Stop> {
    if number >= plan.count() {
        let what =
            format!("there is no case {number}: {} has the cases 0 to {}", plan.origin.display(), plan.count() - 1);
        return Err(Stop::Usage(what));
    }
    case(plan, &Document::open(&plan.scene)?, number, &mut Files::new())
}

/// Hashes of the files that scenes read: each is read once for all cases.
type Files = BTreeMap<Vec<PathBuf>, Vec<u64>>;

fn case(plan: &Plan, document: &Document, number: u64, files: &mut Files) -> Result<Case, Stop> {
    let values = plan.values(number);
    let scene = plan.scene(document, &values)?;
    Ok(Case { number, key: key(&scene, files), values })
}

fn key(scene: &Scene, files: &mut Files) -> String {
    // A mesh file that is not there is that case's own fault, which its run tells.
    let hashes = || Inputs::of(scene).hashes().unwrap_or_default();
    let files = files.entry(scene.data_files()).or_insert_with(hashes);
    let told = format!("{} {:016x} {files:x?}", env!("CARGO_PKG_VERSION"), scene.fingerprint());
    format!("{:016x}", fingerprint(told.as_bytes()))
}

/// How cases are run.
pub(super) struct Runner<'a> {
    pub plan: &'a Plan,
    /// Directory of the cases' own.
    pub folder: PathBuf,
    pub snapshots: Option<u64>,
    pub interrupt: Interrupt,
}

impl Runner<'_> {
    /// The directory of a case.
    pub(super) fn folder(&self, case: &Case) -> PathBuf {
        self.folder.join(&case.key)
    }

    /// Runs a case on one thread; a state that an interrupted run has left is gone on from.
    ///
    /// # Errors
    /// Where it was interrupted or could not be written: there is no record of it then.
    pub(super) fn run(&self, case: &Case) -> Result<Record, Stop> {
        let folder = self.folder(case);
        let outcome = catch_unwind(AssertUnwindSafe(|| self.attempt(case, &folder)));
        let error = match outcome {
            Ok(Ok(())) => None,
            Ok(Err(Stop::Scene(error))) => {
                let reason = error.to_string().replace("\n  help:", ";");
                return Ok(Record::without_report(&case.key, "refused", reason));
            }
            Ok(Err(error)) => Some(error),
            Err(_) => {
                let reason =
                    format!("the program broke off in this case: please report it with `--case {}`", case.number);
                return Ok(Record::without_report(&case.key, "broken", reason));
            }
        };
        let report = report(&folder)?;
        match error {
            // The report says so too, and why.
            Some(Stop::Failed(_)) if report["end"]["state"] == "failed" => {}
            Some(error) => return Err(error),
            None => {}
        }
        Ok(Record::of(&case.key, &folder, &report))
    }

    fn attempt(&self, case: &Case, folder: &Path) -> Result<(), Stop> {
        let has_state = folder.join(checkpoint::NAME).exists();
        if has_state {
            match run::run_until(&self.arguments(case, folder, true), Some(self.interrupt.clone())) {
                // Such as a state of a run that has had its last step.
                Err(Stop::Failed(_) | Stop::Scene(_)) => {}
                outcome => return outcome,
            }
        }
        // That of an earlier run would be taken for this one's.
        let _ = std::fs::remove_file(folder.join("report.json"));
        run::run_until(&self.arguments(case, folder, false), Some(self.interrupt.clone()))
    }

    fn arguments(&self, case: &Case, folder: &Path, resume: bool) -> RunArgs {
        RunArgs {
            scene: SceneArgs { scene: self.plan.scene.clone(), set: self.plan.assignments(&case.values) },
            out: Some(folder.to_owned()),
            steps: None,
            threads: Some(1),
            timings: false,
            json: false,
            dump: None,
            snapshots: self.snapshots,
            resume,
            record: None,
            quiet: true,
        }
    }
}

fn report(folder: &Path) -> Result<Value, Stop> {
    let path = folder.join("report.json");
    let failed = |what: &dyn std::fmt::Display| {
        Stop::Failed(format!("{}: {what}; make room, or choose another --out", path.display()))
    };
    let text = kept::text(&path).map_err(|error| failed(&error))?;
    serde_json::from_str(&text).map_err(|error| failed(&error))
}

//! The state of a run on its way, from which a killed one is resumed.

use super::Stop;
use super::files::Marks;
use super::inputs::Inputs;
use super::tally::Tally;
use rhexis::internal::bytes::{Kind, pack, read, replace, unpack};
use rhexis::snapshot::{Snapshot, SnapshotError};
use rhexis_scene::measures::{TearAccount, TearCourse};
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::time::Duration;

/// The file in the output directory; a new one takes the place of the last.
pub(super) const NAME: &str = "run.snapshot";

/// Version of the parts that are not the engine's, raised with their layout: 1 since a course has tool path and zonule load.
const VERSION: u16 = 1;

/// For inputs that are not those of the run.
const REMEDY: &str = "put it back as it was, or begin the run anew without --resume";

/// A run after some step.
#[derive(Deserialize, Serialize)]
pub(super) struct Checkpoint {
    pub version: OwnVersion,
    /// The scene's fingerprint, but for the number of steps and of threads.
    pub scene: u64,
    pub snapshot: Snapshot,
    /// Steps of the scene, and whether a tear has begun.
    pub progress: (u64, bool),
    pub tally: Tally,
    pub courses: Vec<TearCourse>,
    pub accounts: Vec<TearAccount>,
    pub marks: Marks,
    /// Steps in a row that had failed.
    pub failures: u32,
    /// Processor time in steps, and time since the start.
    pub times: [Duration; 2],
    /// Hashes of the mesh and fibre files that the scene reads, in their order.
    pub inputs: Vec<u64>,
}

/// A [`VERSION`] that is refused, before anything that follows it is read, where it is another.
#[derive(Clone, Deserialize, Serialize)]
#[serde(try_from = "u16", into = "u16")]
pub(super) struct OwnVersion;

impl From<OwnVersion> for u16 {
    fn from(_: OwnVersion) -> Self {
        VERSION
    }
}

impl TryFrom<u16> for OwnVersion {
    type Error = String;

    fn try_from(version: u16) -> Result<Self, String> {
        if version == VERSION { Ok(Self) } else { Err(format!("version {version}, not {VERSION}")) }
    }
}

impl From<SnapshotError> for Stop {
    fn from(error: SnapshotError) -> Self {
        Self::Failed(error.to_string())
    }
}

impl Checkpoint {
    /// Writes it into the output directory, whole or not at all.
    pub(crate) fn save(&self, folder: &Path) -> Result<(), SnapshotError> {
        replace(&folder.join(NAME), &pack(Kind::Run, self)?)
    }

    /// The last one of a run of this scene, which reads files that have not changed since.
    pub(crate) fn load(folder: &Path, scene: u64, inputs: &Inputs) -> Result<Self, Stop> {
        let path = folder.join(NAME);
        let named = |error: SnapshotError| {
            let remedy = match error {
                SnapshotError::Unreadable(_) => {
                    "; if another version of the program has written it, begin the run again without --resume"
                }
                _ => "",
            };
            Stop::Failed(format!("{}: {error}{remedy}", path.display()))
        };
        let checkpoint: Self = read(&path).and_then(|bytes| unpack(Kind::Run, &bytes)).map_err(named)?;
        if checkpoint.scene != scene {
            let path = path.display();
            let what = "is of another scene, or of one with other values (scene file, --set)";
            return Err(Stop::Failed(format!("{path} {what}; {REMEDY}")));
        }
        if let Some(file) = inputs.first_changed(&checkpoint.inputs)? {
            let file = file.display();
            return Err(Stop::Failed(format!(
                "{file} has changed since the run in {} began; {REMEDY}",
                path.display()
            )));
        }
        Ok(checkpoint)
    }
}

/// Refuses a directory without any.
pub(super) fn expect(folder: &Path) -> Result<(), Stop> {
    if folder.join(NAME).exists() {
        return Ok(());
    }
    let folder = folder.display();
    Err(Stop::Failed(format!("there is no run to resume in {folder}: begin one with --snapshots N")))
}

/// Takes away that of an earlier run.
pub(super) fn remove(folder: &Path) -> Result<(), Stop> {
    match std::fs::remove_file(folder.join(NAME)) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(Stop::Failed(format!("cannot remove {}: {error}", folder.join(NAME).display())))
        }
        _ => Ok(()),
    }
}

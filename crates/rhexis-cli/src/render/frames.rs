//! The frames that a run has written, read back: the list (`frames.pvd`) and the bodies (`.vtu`).

use super::Moment;
use crate::output::{VtuError, pvd::SOLIDS, read_solids, read_vtu};
use crate::{Stop, kept};
use std::path::{Path, PathBuf};

/// A moment of the list: its time \[ms\] and a file per body.
pub(super) struct Entry {
    pub time: f64,
    files: Vec<PathBuf>,
    solids: Option<PathBuf>,
}

/// The moments of a run's directory, in their order.
///
/// # Errors
/// Where it has none.
pub(super) fn entries(run: &Path) -> Result<Vec<Entry>, Stop> {
    let path = run.join("frames.pvd");
    let failed = |what: &dyn std::fmt::Display| {
        let help = "give a directory of `rhexis run --set output.frames=60`, or the scene itself";
        Stop::Failed(format!("{}: {what}; {help}", path.display()))
    };
    let text = kept::text(&path).map_err(|error| failed(&error))?;
    let mut entries: Vec<Entry> = Vec::new();
    for line in text.lines().filter(|line| line.trim_start().starts_with("<DataSet ")) {
        let word = |name: &str| line.split_once(&format!(" {name}=\""))?.1.split('"').next();
        let time = word("timestep").and_then(|time| time.parse().ok()).filter(|time: &f64| time.is_finite());
        let (Some(time), Some(file)) = (time, word("file")) else {
            return Err(failed(&"a frame without time or file"));
        };
        let is_solids = file.rsplit('-').nth(1) == Some(SOLIDS) && word("name") == Some(SOLIDS);
        let file = run.join(file.replace("&amp;", "&"));
        match entries.last_mut() {
            // A body may have that name: the solids come after all bodies.
            Some(last) if last.time == time && is_solids => last.solids = Some(file),
            Some(last) if last.time == time => last.files.push(file),
            _ => entries.push(Entry { time, files: vec![file], solids: None }),
        }
    }
    if entries.is_empty() { Err(failed(&"it lists no frames")) } else { Ok(entries) }
}

/// Reads a moment.
///
/// # Errors
/// For a file that cannot be read or is not one of a run.
pub(super) fn read(entry: &Entry) -> Result<Moment, Stop> {
    let help = "run the scene anew, or render it in place of the directory";
    let failed = |error: VtuError| Stop::Failed(format!("{error} ({help})"));
    let bodies = entry.files.iter().map(|file| read_vtu(file)).collect::<Result<Vec<_>, _>>().map_err(failed)?;
    let solids = entry.solids.as_deref().map_or(Ok(Vec::new()), read_solids).map_err(failed)?;
    Ok(Moment { time: entry.time, body: super::together(bodies), solids })
}

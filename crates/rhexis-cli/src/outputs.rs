//! What a run cannot write at its end, known before its first step.

use super::inputs::part_of;
use super::{RunArgs, Stop, dump, files};
use rhexis::internal::source;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// Makes the directories and tries every file that is written at the end.
///
/// # Errors
/// For what cannot be written, and for a recording in the place of another output.
pub(super) fn prepare(args: &RunArgs, out: &Path) -> Result<(), Stop> {
    try_whole(&out.join("report.json"), "another directory with --out")?;
    if let Some(folder) = &args.dump {
        dump::create(folder, "--dump")?;
        for name in dump::NAMES {
            let path = folder.join(name);
            try_open(&path).map_err(|error| refused(&path, error, "another directory with --dump"))?;
        }
    }
    let Some(record) = &args.record else { return Ok(()) };
    if let Some(folder) = record.parent() {
        dump::create(folder, "--record")?;
    }
    let choice = "another file with --record";
    let clash = |folder: &Path, is_own: &dyn Fn(&str) -> bool| {
        let name = record.file_name().unwrap_or_default().to_string_lossy();
        is_own(&name) && place(record.parent()) == place(Some(folder))
    };
    if clash(out, &files::is_own_name)
        || args.dump.as_ref().is_some_and(|dump| clash(dump, &|n| dump::NAMES.contains(&n)))
    {
        return Err(refused(record, "the run writes another file of that name there", choice));
    }
    try_whole(record, choice)
}

/// The directory for what a long command writes at its end: the one given, made now, or else this one, whose path must be free.
///
/// # Errors
/// Where nothing can be written there.
pub(super) fn directory(given: Option<&Path>, default: &str) -> Result<PathBuf, Stop> {
    let folder = given.unwrap_or(Path::new(default));
    if given.is_some() {
        dump::create(folder, "--out")?;
    } else if folder.exists() && !folder.is_dir() {
        return Err(refused(folder, "it is no directory", "another with --out"));
    }
    if folder.is_dir() {
        let probe = folder.join("rhexis.part");
        try_open(&probe).map_err(|error| refused(&probe, error, "another directory with --out"))?;
    }
    Ok(folder.to_owned())
}

/// Refuses to write a file, whose content begins with `head`, in the place of one that begins otherwise. Nothing is written yet.
///
/// # Errors
/// For such a file, and for anything but a regular file.
pub(super) fn spare(path: &Path, head: &[u8], kind: &str) -> Result<(), Stop> {
    let choice = "another file with --out";
    match source::open(path, u64::MAX) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        Err(error) => Err(refused(path, error, choice)),
        Ok((file, _)) => {
            let mut found = Vec::new();
            let read = file.take(head.len() as u64).read_to_end(&mut found);
            read.map_err(|error| refused(path, error, choice))?;
            if found == head {
                Ok(())
            } else {
                Err(refused(path, format!("a file that is no {kind} is there"), choice))
            }
        }
    }
}

/// A directory, however it is written.
fn place(folder: Option<&Path>) -> Option<PathBuf> {
    let folder = folder.filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    folder.canonicalize().ok()
}

fn refused(path: &Path, reason: impl std::fmt::Display, choice: &str) -> Stop {
    Stop::Failed(format!("cannot write {}: {reason}; choose {choice}", path.display()))
}

/// Tries a file that is written beside its place and renamed.
fn try_whole(path: &Path, choice: &str) -> Result<(), Stop> {
    let attempt = match fs::metadata(path) {
        _ if path.file_name().is_none() => Err(io::Error::other("the path names no file")),
        Ok(data) if data.is_dir() => Err(io::Error::other("it is a directory")),
        Ok(data) if !data.is_file() => Err(io::Error::other("not a regular file")),
        _ => try_open(&part_of(path)),
    };
    attempt.map_err(|error| refused(path, error, choice))
}

/// Opens a file for writing and leaves it as it was.
fn try_open(path: &Path) -> io::Result<()> {
    let was_there = path.symlink_metadata().is_ok();
    File::options().write(true).create(true).truncate(false).open(path)?;
    if was_there { Ok(()) } else { fs::remove_file(path) }
}

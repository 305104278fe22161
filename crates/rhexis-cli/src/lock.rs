//! One run at a time writes into an output directory: two would mix their rows.

use super::{Stop, say::complain};
use std::fs::{File, TryLockError};
use std::io::{Read, Seek, Write};
use std::path::{Path, PathBuf};

/// The file in the output directory, there while a run writes.
pub(super) const NAME: &str = "run.lock";

/// The right to write into a directory. The system takes it back when the program ends, however it ends; a file that a killed
/// one has left locks nothing.
pub(super) struct Lock {
    path: PathBuf,
    file: File,
}

impl Lock {
    /// The directory.
    pub(crate) fn folder(&self) -> &Path {
        self.path.parent().unwrap_or(Path::new(""))
    }

    /// Takes it for a directory, which is made where it is not there.
    ///
    /// # Errors
    /// While another process has it, and where the file cannot be written.
    pub(crate) fn take(folder: &Path) -> Result<Self, Stop> {
        let path = folder.join(NAME);
        let refused = |path: &Path, error| {
            let what = format!("cannot write {}: {error}", path.display());
            Stop::Failed(format!("{what}; make room, or choose another directory with --out"))
        };
        std::fs::create_dir_all(folder).map_err(|error| refused(folder, error))?;
        loop {
            let open = File::options().read(true).write(true).create(true).truncate(false).open(&path);
            let mut file = open.map_err(|error| refused(&path, error))?;
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => return Err(taken(folder, &mut file)),
                Err(TryLockError::Error(error)) => {
                    let folder = folder.display();
                    complain(&format!("warning: {folder} cannot be locked ({error}): start no second run into it"));
                    return Ok(Self { path, file });
                }
            }
            // Whoever had it before may have taken the file away in between: it would lock nothing.
            if is_there(&path, &file) {
                sign(&mut file);
                return Ok(Self { path, file });
            }
        }
    }

    /// Takes it anew where the directory was taken away and made anew.
    ///
    /// # Errors
    /// Where another process has been faster.
    pub(crate) fn renew(&mut self) -> Result<(), Stop> {
        if !is_there(&self.path, &self.file) {
            *self = Self::take(self.folder())?;
        }
        Ok(())
    }
}

/// Says who has it. Nobody needs to know: a full disk is no fault here.
fn sign(file: &mut File) {
    let name = format!("process {}\n", std::process::id());
    let _ = file.set_len(0).and_then(|()| file.write_all(name.as_bytes()));
}

/// Whether the path still leads to the open file.
#[cfg(unix)]
fn is_there(path: &Path, file: &File) -> bool {
    use std::os::unix::fs::MetadataExt;
    let place = |data: std::io::Result<std::fs::Metadata>| data.ok().map(|data| (data.dev(), data.ino()));
    let own = place(file.metadata());
    own.is_some() && own == place(std::fs::metadata(path))
}

/// Whether the path still leads to the open file: elsewhere such a file cannot be taken away.
#[cfg(not(unix))]
fn is_there(_: &Path, _: &File) -> bool {
    true
}

impl Drop for Lock {
    fn drop(&mut self) {
        // While it is locked: the next one sees that the file has gone.
        if cfg!(unix) && is_there(&self.path, &self.file) {
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

fn taken(folder: &Path, file: &mut File) -> Stop {
    let mut holder = String::new();
    // Where it cannot be read, or is not written yet.
    let _ = file.rewind().and_then(|()| file.take(64).read_to_string(&mut holder));
    let holder = holder.trim();
    let holder = if holder.is_empty() { "another process" } else { holder };
    let folder = folder.display();
    Stop::Failed(format!(
        "{folder} is in use: {holder} writes its run there; wait for its end, end it, or choose another directory with --out"
    ))
}

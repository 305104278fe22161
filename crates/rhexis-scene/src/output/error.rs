//! Why a file could not be written, and how to mend it.

use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why a file could not be written.
#[derive(Debug, Error)]
pub enum OutputError {
    /// The file system refused.
    #[error("cannot write {}: {source}; {}", path.display(), remedy(source, path))]
    Write {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
    /// What was to be written is not a body.
    #[error("cannot write {}: {what}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// What is wrong, and how to mend it.
        what: String,
    },
}

impl OutputError {
    /// What was to be written is wrong in this way.
    pub fn content(path: &Path, what: impl Into<String>) -> Self {
        Self::Content { path: path.to_owned(), what: what.into() }
    }

    /// The file system refused so.
    pub fn write(path: &Path, source: io::Error) -> Self {
        Self::Write { path: path.to_owned(), source }
    }
}

fn remedy(source: &io::Error, path: &Path) -> String {
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.display().to_string(),
        _ => ".".to_owned(),
    };
    match source.kind() {
        io::ErrorKind::NotFound => format!("create the directory {folder} first"),
        io::ErrorKind::NotADirectory => format!("{folder} runs through a file; choose another directory"),
        io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
            format!("{folder} is not writable; allow writing there or choose another directory")
        }
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
            "free some space, or write fewer frames".to_owned()
        }
        io::ErrorKind::IsADirectory => "a directory has this name; remove it or choose another name".to_owned(),
        _ => format!("check that {folder} can be written"),
    }
}

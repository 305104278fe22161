//! Why a file could not be written, and how to mend it.

use crate::components::Attributes;
use crate::frame::BodyFrame;
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
    pub(super) fn content(path: &Path, what: impl Into<String>) -> Self {
        Self::Content { path: path.to_owned(), what: what.into() }
    }

    pub(super) fn write(path: &Path, source: io::Error) -> Self {
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

/// Refuses a body whose arrays do not belong together, so that the writers may index freely.
pub(super) fn check_shape(path: &Path, body: &BodyFrame) -> Result<(), OutputError> {
    let (vertex_count, triangle_count) = (body.positions.len(), body.triangles.len());
    let lengths = [
        ("rest_positions", body.rest_positions.len(), vertex_count, false),
        ("stress", body.stress.len(), triangle_count, false),
        ("principal_stress", body.principal_stress.len(), triangle_count, false),
        ("fibres", body.fibres.len(), triangle_count, false),
        ("velocities", body.velocities.len(), vertex_count, true),
        ("forces", body.forces.len(), vertex_count, true),
        ("criterion", body.criterion.len(), triangle_count, true),
        ("attributes", body.attributes.as_ref().map_or(vertex_count, Attributes::len), vertex_count, false),
    ];
    for (name, found, wanted, is_optional) in lengths {
        if found != wanted && !(is_optional && found == 0) {
            return Err(OutputError::content(
                path,
                format!(
                    "body '{}' has {found} entries in `{name}` where {wanted} belong; fill the frame anew",
                    body.name
                ),
            ));
        }
    }
    match body.triangles.iter().position(|corners| corners.iter().any(|&v| v as usize >= vertex_count)) {
        None => Ok(()),
        Some(t) => Err(OutputError::content(
            path,
            format!(
                "triangle {t} of body '{}' has corners {:?} but there are {vertex_count} vertices; fill the frame anew",
                body.name, body.triangles[t]
            ),
        )),
    }
}

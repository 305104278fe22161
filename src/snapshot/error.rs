//! Why a snapshot or a recording is refused.

use crate::membrane::BodyError;
use crate::settings::OutOfRange;

/// Why a snapshot or a recording is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SnapshotError {
    /// The bytes begin otherwise.
    #[error("this is no {expected} of Rhexis")]
    AnotherFile {
        /// Expected kind of file: a snapshot or a recording.
        expected: &'static str,
    },
    /// Another version of the format.
    #[error("the format has version {found}, and this build reads versions {oldest} to {known}: take it anew")]
    Version {
        /// Of the bytes.
        found: u16,
        /// The oldest that this build reads.
        oldest: u16,
        /// The one that it writes.
        known: u16,
    },
    /// A recording or the state of a run, written with or without the feature `direct`, read the other way.
    #[error("it was written by a build {} the feature `direct`, and the last digits of this one differ: use such a build (snapshots are read by either)", if *.has_factors { "with" } else { "without" })]
    Build {
        /// Whether the build that wrote it has factors.
        has_factors: bool,
    },
    /// The bytes are not those that were written.
    #[error("the bytes are damaged: their checksum is another")]
    Damaged,
    /// The bytes cannot be read.
    #[error("the bytes cannot be read: {0}")]
    Unreadable(String),
    /// A body's mesh or components.
    #[error("body `{body}`: {source}")]
    Body {
        /// Name of the body.
        body: String,
        /// Cause of the rejection.
        source: BodyError,
    },
    /// The components of an obstacle or a tool.
    #[error("{owner}: {source}")]
    Component {
        /// Name of the obstacle or tool.
        owner: String,
        /// Cause of the rejection.
        source: BodyError,
    },
    /// Anything else that contradicts itself.
    #[error("{owner}: {what}")]
    Contradiction {
        /// Name of the owner.
        owner: String,
        /// Cause of the rejection.
        what: &'static str,
    },
    /// The settings.
    #[error(transparent)]
    Settings(#[from] OutOfRange),
    /// The threads could not be started.
    #[error("the threads could not be started: {0}")]
    Threads(String),
    /// A file cannot be read or written.
    #[error("{path}: {reason}")]
    File {
        /// Path of the file.
        path: String,
        /// Reason of the failure.
        reason: String,
    },
}

impl SnapshotError {
    pub(crate) fn contradiction(owner: impl Into<String>, what: &'static str) -> Self {
        Self::Contradiction { owner: owner.into(), what }
    }
}

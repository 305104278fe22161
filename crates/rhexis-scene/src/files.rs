//! The files that a scene mentions: in its folder, or given with its text.

use rhexis::internal::source;
use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Where a scene's files are found.
#[derive(Clone, Debug, Default)]
pub(super) struct Files {
    /// Where a relative path begins.
    pub folder: PathBuf,
    /// Contents by the path that the scene names them by; they go before the folder's.
    pub given: BTreeMap<PathBuf, Arc<Vec<u8>>>,
}

impl Files {
    /// The path of a file that the scene mentions, for reading and for messages; its name alone where its content is given.
    pub(super) fn path(&self, path: &Path) -> PathBuf {
        if self.given.contains_key(path) { path.to_owned() } else { self.folder.join(path) }
    }

    /// A content that was given.
    pub(super) fn given(&self, path: &Path) -> Option<Vec<u8>> {
        self.given.get(path).map(|bytes| bytes.to_vec())
    }

    /// The bytes of a file, `most` at the most.
    ///
    /// # Errors
    /// As the file system's.
    pub(super) fn read(&self, path: &Path, most: u64) -> io::Result<Vec<u8>> {
        self.given(path).map_or_else(|| source::read(&self.folder.join(path), most), Ok)
    }
}

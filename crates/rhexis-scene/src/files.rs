//! The files that a scene mentions: in its folder, or given with its text.

use super::mesh_file::MOST_BYTES;
use rhexis::internal::source::Sources;
use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Contents of a scene's files, each read once.
#[derive(Debug)]
pub(super) struct Files {
    /// Where a relative path begins.
    folder: PathBuf,
    /// Contents by the path that the scene names them by; they go before the folder's.
    given: BTreeMap<PathBuf, Arc<Vec<u8>>>,
    /// Contents of the folder, of [`MOST_BYTES`] together.
    sources: Sources,
}

impl Files {
    pub(super) fn new(folder: PathBuf, given: BTreeMap<PathBuf, Arc<Vec<u8>>>) -> Self {
        Self { folder, given, sources: Sources::new(MOST_BYTES) }
    }

    /// The path of a file that the scene mentions, for reading and for messages; its name alone where its content is given.
    pub(super) fn path(&self, path: &Path) -> PathBuf {
        if self.is_given(path) { path.to_owned() } else { self.folder.join(path) }
    }

    /// Whether the content was given with the scene's text.
    pub(super) fn is_given(&self, path: &Path) -> bool {
        self.given.contains_key(path)
    }

    /// The bytes of a file, `most` at the most.
    ///
    /// # Errors
    /// As the file system's, and where all files together are larger than [`MOST_BYTES`].
    pub(super) fn read(&self, path: &Path, most: u64) -> io::Result<Arc<Vec<u8>>> {
        let given = self.given.get(path).cloned();
        given.map_or_else(|| self.sources.read(&self.folder.join(path), most), Ok)
    }
}

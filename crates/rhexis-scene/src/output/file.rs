//! Writing a whole file at once.

use super::OutputError;
use std::fs;
use std::io;
use std::path::Path;

/// Writes `bytes` beside `path` and renames: the file is the old one or the new one, never half of it. What is neither file nor
/// directory is refused: renaming would put a file in its place.
pub fn replace(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    let Some(name) = path.file_name() else {
        let source = io::Error::new(io::ErrorKind::InvalidInput, "the path names no file");
        return Err(OutputError::write(path, source));
    };
    if fs::metadata(path).is_ok_and(|data| !data.is_file() && !data.is_dir()) {
        return Err(OutputError::write(path, io::Error::other("not a regular file")));
    }
    let mut part = name.to_owned();
    part.push(".part");
    let part = path.with_file_name(part);
    fs::write(&part, bytes).and_then(|()| fs::rename(&part, path)).map_err(|source| {
        // The first failure is the one to report; a leftover that cannot be removed either adds nothing to it.
        let _ = fs::remove_file(&part);
        OutputError::write(path, source)
    })
}

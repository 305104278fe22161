//! Files of a run or a sweep, read back.

use rhexis::internal::source;
use std::fs::File;
use std::io::{self, Read, Take};
use std::path::Path;

/// Maximum size of one file, and of the files of a page together \[bytes\].
pub(super) const MOST_BYTES: u64 = 1 << 30;

/// The text of a regular file.
///
/// # Errors
/// As [`source::read`], and for text that is not UTF-8.
pub(super) fn text(path: &Path) -> io::Result<String> {
    String::from_utf8(source::read(path, MOST_BYTES)?).map_err(io::Error::other)
}

/// A regular file to be read in pieces.
///
/// # Errors
/// As [`source::open`].
pub(super) fn open(path: &Path) -> io::Result<Take<File>> {
    let (file, size) = source::open(path, MOST_BYTES)?;
    Ok(file.take(size))
}

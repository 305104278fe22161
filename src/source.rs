//! Reading files that a user names: regular ones alone, and no more of them than is stated.
//!
//! A device or a pipe may never end, and a file may be larger than the memory: both are errors that name the reason, before anything of
//! their size is allocated.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

/// A regular file with its size, `most` bytes at the most.
///
/// # Errors
/// Where the system refuses, for a path that is no regular file, and for more bytes.
pub fn open(path: &Path, most: u64) -> io::Result<(File, u64)> {
    // Judged before it is opened: opening a pipe waits for somebody to write into it.
    if !fs::metadata(path)?.is_file() {
        return Err(io::Error::other("not a regular file"));
    }
    let file = File::open(path)?;
    let size = file.metadata()?.len();
    if size > most { Err(too_large(most)) } else { Ok((file, size)) }
}

/// The bytes of a regular file, `most` at the most.
///
/// # Errors
/// As [`open`].
pub fn read(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let (file, size) = open(path, most)?;
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(size as usize).map_err(|_| io::Error::from(io::ErrorKind::OutOfMemory))?;
    // It may grow meanwhile, and some that are said to be empty are not.
    file.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most { Err(too_large(most)) } else { Ok(bytes) }
}

fn too_large(most: u64) -> io::Error {
    io::Error::other(format!("it is larger than the {} MB that are read", most >> 20))
}

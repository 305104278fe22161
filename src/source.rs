//! Reading files that a user names: regular ones alone, and no more of them than is stated.
//!
//! A device or a pipe may never end, and a file may be larger than the memory: both are errors that name the reason, before anything of
//! their size is allocated.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Contents of regular files, each read once per path, whose sizes together stay within a limit.
#[derive(Debug)]
pub struct Sources {
    /// Maximum sum of the sizes \[bytes\].
    most: u64,
    contents: RefCell<BTreeMap<PathBuf, Arc<Vec<u8>>>>,
}

impl Sources {
    /// No file yet, of `most` bytes together.
    pub fn new(most: u64) -> Self {
        Self { most, contents: RefCell::default() }
    }

    /// The bytes of a file, `most` at the most.
    ///
    /// # Errors
    /// As [`open`]; for more bytes than the files before have left, too.
    pub fn read(&self, path: &Path, most: u64) -> io::Result<Arc<Vec<u8>>> {
        let mut contents = self.contents.borrow_mut();
        if let Some(content) = contents.get(path) {
            return Ok(content.clone());
        }
        let left = self.most - contents.values().map(|content| content.len() as u64).sum::<u64>();
        let (file, size) = open(path, most)?;
        if size > left {
            let most = self.most >> 20;
            return Err(io::Error::other(format!("the files together are larger than the {most} MB that are read")));
        }
        let content = Arc::new(all(file, size, most.min(left))?);
        contents.insert(path.to_owned(), content.clone());
        Ok(content)
    }
}

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
    all(file, size, most)
}

fn all(file: File, size: u64, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(size as usize).map_err(|_| io::Error::from(io::ErrorKind::OutOfMemory))?;
    // It may grow meanwhile, and some that are said to be empty are not.
    file.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most { Err(too_large(most)) } else { Ok(bytes) }
}

fn too_large(most: u64) -> io::Error {
    io::Error::other(format!("it is larger than the {} MB that are read", most >> 20))
}

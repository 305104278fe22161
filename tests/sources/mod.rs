//! The source files of the engine, for tests that read them.

use std::fs;
use std::path::{Path, PathBuf};

/// Files under a folder of the package whose name ends with `.extension`, in order.
///
/// # Panics
/// Without a file.
pub fn files(folder: &str, extension: &str) -> Vec<PathBuf> {
    let mut pending = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join(folder)];
    let mut files = Vec::new();
    while let Some(path) = pending.pop() {
        if path.is_dir() {
            pending.extend(fs::read_dir(&path).unwrap().map(|entry| entry.unwrap().path()));
        } else if path.extension().is_some_and(|e| e == extension) {
            files.push(path);
        }
    }
    files.sort();
    assert!(!files.is_empty(), "{folder} holds no file .{extension}");
    files
}

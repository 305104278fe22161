//! A text file that grows by lines and outlives what happens around it.
//!
//! Lines that cannot be written wait and are written with the next; a line is in the file whole or not at all. A file that is
//! taken away is made anew, with all that it had.

use std::fs::{self, File};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// More than this may not wait \[bytes\].
const MOST_WAITING: usize = 64 << 20;

/// The open file.
pub(super) struct Journal {
    path: PathBuf,
    file: File,
    /// Bytes in the file.
    length: u64,
    /// What could not be written yet.
    waiting: Vec<u8>,
}

/// What came of an attempt to write.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Written {
    /// Everything is in the file.
    All,
    /// So is it, in a new file: the old one had been taken away.
    Anew,
}

impl Journal {
    /// An empty file.
    pub(crate) fn create(path: &Path) -> io::Result<Self> {
        let file = File::options().read(true).write(true).create(true).truncate(true).open(path)?;
        Ok(Self { path: path.to_owned(), file, length: 0, waiting: Vec::new() })
    }

    /// Goes on with a file at its first `length` bytes; what follows them is taken away.
    pub(crate) fn resume(path: &Path, length: u64) -> io::Result<Self> {
        let mut file = File::options().read(true).write(true).open(path)?;
        if file.metadata()?.len() < length {
            return Err(io::Error::other("it is shorter than it was"));
        }
        file.set_len(length)?;
        file.seek(SeekFrom::End(0))?;
        Ok(Self { path: path.to_owned(), file, length, waiting: Vec::new() })
    }

    /// Adds lines and writes everything that waits.
    ///
    /// # Errors
    /// Where the system refuses; the lines wait then.
    pub(crate) fn append(&mut self, lines: &[u8]) -> io::Result<Written> {
        self.waiting.extend_from_slice(lines);
        self.write()
    }

    /// Writes everything that waits.
    ///
    /// # Errors
    /// Where the system refuses; it goes on waiting then.
    pub(crate) fn write(&mut self) -> io::Result<Written> {
        let written = if self.path.try_exists()? { Written::All } else { self.make_anew()? };
        self.file.write_all(&self.waiting).inspect_err(|_| {
            // Part of it may be there. Where that cannot be taken back, as on a device, it is overwritten at the next attempt.
            let _ = self.file.set_len(self.length).and_then(|()| self.file.seek(SeekFrom::Start(self.length)));
        })?;
        self.length += self.waiting.len() as u64;
        self.waiting.clear();
        Ok(written)
    }

    fn make_anew(&mut self) -> io::Result<Written> {
        if let Some(folder) = self.path.parent() {
            fs::create_dir_all(folder)?;
        }
        let mut file = File::options().read(true).write(true).create_new(true).open(&self.path)?;
        let copy = |old: &mut File, new: &mut File| {
            old.rewind()?;
            io::copy(&mut old.take(self.length), new)
        };
        if let Err(error) = copy(&mut self.file, &mut file) {
            // Or the next attempt would take the half for the whole.
            let _ = fs::remove_file(&self.path);
            return Err(error);
        }
        self.file = file;
        Ok(Written::Anew)
    }

    /// Bytes in the file, which are on the disk from here on; nothing while lines wait.
    pub(crate) fn mark(&self) -> Option<u64> {
        (self.waiting.is_empty() && self.file.sync_data().is_ok()).then_some(self.length)
    }

    /// Whether more waits than may.
    pub(crate) fn is_overfull(&self) -> bool {
        self.waiting.len() > MOST_WAITING
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    fn text(path: &Path) -> String {
        fs::read_to_string(path).unwrap()
    }

    #[test]
    fn lines_wait_while_the_disk_is_full() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rows");
        std::os::unix::fs::symlink("/dev/full", &path).unwrap();
        let mut journal = Journal::create(&path).unwrap();
        for line in ["1\n", "2\n"] {
            let error = journal.append(line.as_bytes()).unwrap_err();
            assert_eq!(error.kind(), io::ErrorKind::StorageFull);
            assert_eq!(journal.mark(), None);
        }
        fs::remove_file(&path).unwrap();
        assert_eq!(journal.append(b"3\n").unwrap(), Written::Anew);
        assert_eq!(text(&path), "1\n2\n3\n");
        assert_eq!(journal.mark(), Some(6));
    }

    #[test]
    fn a_file_that_was_taken_away_comes_back_whole() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out/rows");
        fs::create_dir(path.parent().unwrap()).unwrap();
        let mut journal = Journal::create(&path).unwrap();
        assert_eq!(journal.append(b"1\n").unwrap(), Written::All);
        fs::remove_dir_all(path.parent().unwrap()).unwrap();
        assert_eq!(journal.append(b"2\n").unwrap(), Written::Anew);
        assert_eq!(journal.append(b"3\n").unwrap(), Written::All);
        assert_eq!(text(&path), "1\n2\n3\n");
        // A file in the way of the directory: nothing to be done until it goes.
        fs::remove_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path.parent().unwrap(), "").unwrap();
        journal.append(b"4\n").unwrap_err();
        fs::remove_file(path.parent().unwrap()).unwrap();
        assert_eq!(journal.write().unwrap(), Written::Anew);
        assert_eq!(text(&path), "1\n2\n3\n4\n");
    }

    #[test]
    fn what_follows_the_mark_is_taken_away() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rows");
        fs::write(&path, "1\n2\n3,").unwrap();
        assert!(Journal::resume(&path, 7).is_err(), "shorter than its mark");
        Journal::resume(&path, 4).unwrap().append(b"3\n").unwrap();
        assert_eq!(text(&path), "1\n2\n3\n");
    }
}

//! Snapshots and recordings as bytes.
//!
//! A head of 28 bytes, little-endian: 8 bytes that name the kind, version of the format (u16), marks (u16: 1 the build has Cholesky
//! factors, 2 the body is compressed), length of the body before compression (u64), XXH3 of the body as it stands (u64). The
//! body is [postcard](https://postcard.jamesmunns.com)'s encoding, in an LZ4 block where that is shorter.
//!
//! Bytes are never trusted: the checksum tells of damage, not of malice. A reader takes no more memory than a fixed multiple of the bytes
//! it is given, and the contents are validated before they become a state.

use super::hash::sum;
use super::{Contents, Snapshot, SnapshotError, check, migrate};
use serde::{Serialize, de::DeserializeOwned};
use std::io::Write;
use std::path::Path;
use std::sync::Arc;

/// The version of the format that this build writes. Snapshots are read from [`migrate::OLDEST`] on, recordings and runs, which promise the same
/// bits, of this one alone.
pub(crate) const VERSION: u16 = 19;

const FACTORS_FLAG: u16 = 1;
const IS_COMPRESSED: u16 = 2;
const HEAD: usize = 28;

/// A body that claims to be more times as long as its bytes is refused; one that would be is written as it is.
const MOST_RATIO: usize = 16;

/// Kind of the contents: snapshot or recording.
#[derive(Clone, Copy)]
pub enum Kind {
    /// A snapshot.
    Snapshot,
    /// A recording.
    Recording,
    /// The state of a run of the command line.
    Run,
}

impl Kind {
    fn magic(self) -> &'static [u8; 8] {
        match self {
            Self::Snapshot => b"rhexsnap",
            Self::Recording => b"rhexrec\0",
            Self::Run => b"rhexrun\0",
        }
    }

    /// Whether it is there to lead to the same bits again: another build's factors would lead to others.
    fn promises_bits(self) -> bool {
        !matches!(self, Self::Snapshot)
    }

    fn name(self) -> &'static str {
        match self {
            Self::Snapshot => "snapshot",
            Self::Recording => "recording",
            Self::Run => "state of a run",
        }
    }
}

/// The bytes of a value.
pub fn pack(kind: Kind, value: &impl Serialize) -> Result<Vec<u8>, SnapshotError> {
    let body = postcard::to_allocvec(value).map_err(|error| SnapshotError::Unreadable(error.to_string()))?;
    let packed = lz4_flex::block::compress(&body);
    let is_compressed = packed.len() < body.len() && body.len() <= packed.len() * MOST_RATIO;
    let mut marks = if cfg!(feature = "direct") { FACTORS_FLAG } else { 0 };
    marks |= if is_compressed { IS_COMPRESSED } else { 0 };
    let written = if is_compressed { &packed } else { &body };
    let mut bytes = Vec::with_capacity(HEAD + written.len());
    bytes.extend_from_slice(kind.magic());
    bytes.extend_from_slice(&VERSION.to_le_bytes());
    bytes.extend_from_slice(&marks.to_le_bytes());
    bytes.extend_from_slice(&(body.len() as u64).to_le_bytes());
    bytes.extend_from_slice(&sum(written).to_le_bytes());
    bytes.extend_from_slice(written);
    Ok(bytes)
}

/// The value of bytes, as they say.
pub fn unpack<T: DeserializeOwned>(kind: Kind, bytes: &[u8]) -> Result<T, SnapshotError> {
    let another = SnapshotError::AnotherFile { expected: kind.name() };
    let (head, body) = bytes.split_at_checked(HEAD).ok_or(another.clone())?;
    if !head.starts_with(kind.magic()) {
        return Err(another);
    }
    let short = |at: usize| u16::from_le_bytes([head[at], head[at + 1]]);
    let long = |at: usize| u64::from_le_bytes(std::array::from_fn(|i| head[at + i]));
    let (version, marks, length) = (short(8), short(10), long(12));
    let oldest = if kind.promises_bits() { VERSION } else { migrate::OLDEST };
    if !(oldest..=VERSION).contains(&version) {
        return Err(SnapshotError::Version { found: version, oldest, known: VERSION });
    }
    if kind.promises_bits() && (marks & FACTORS_FLAG != 0) != cfg!(feature = "direct") {
        return Err(SnapshotError::Build { has_factors: marks & FACTORS_FLAG != 0 });
    }
    if long(20) != sum(body) {
        return Err(SnapshotError::Damaged);
    }
    let unreadable = |error: &dyn std::fmt::Display| SnapshotError::Unreadable(error.to_string());
    let unpacked;
    let body = if marks & IS_COMPRESSED != 0 {
        let length = usize::try_from(length).ok().filter(|&length| length <= body.len().saturating_mul(MOST_RATIO));
        let length = length.ok_or_else(|| unreadable(&"they claim to hold more than they can"))?;
        unpacked = lz4_flex::block::decompress(body, length).map_err(|error| unreadable(&error))?;
        &unpacked[..]
    } else {
        body
    };
    if body.len() as u64 != length {
        return Err(unreadable(&"their length is another than they say"));
    }
    let body = &*migrate::to_present(version, body);
    match postcard::take_from_bytes(body) {
        Ok((value, [])) => Ok(value),
        Ok(_) => Err(unreadable(&"more follows than belongs to it")),
        Err(error) => Err(unreadable(&error)),
    }
}

/// Writes bytes beside `path` and renames: the file is the old one or the new one, never half of it, whatever ends the program or the
/// machine. A path that is neither file nor directory is refused: renaming would put a file in its place.
pub fn replace(path: &Path, bytes: &[u8]) -> Result<(), SnapshotError> {
    let mut part = path.as_os_str().to_owned();
    part.push(".part");
    let write = || -> std::io::Result<()> {
        if std::fs::metadata(path).is_ok_and(|data| !data.is_file() && !data.is_dir()) {
            return Err(std::io::Error::other("not a regular file"));
        }
        let mut file = std::fs::File::create(&part)?;
        file.write_all(bytes)?;
        file.sync_all()?;
        std::fs::rename(&part, path)?;
        // The name of the new file, too, is to outlive a loss of power; where a directory cannot be opened, the system sees to it.
        #[cfg(unix)]
        if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
            let _ = std::fs::File::open(folder).and_then(|folder| folder.sync_all());
        }
        Ok(())
    };
    write().map_err(|error| {
        // The first failure is the one to tell of.
        let _ = std::fs::remove_file(&part);
        file_error(path, &error)
    })
}

/// The largest snapshot or recording that is read from a file \[bytes\].
const MOST_BYTES: u64 = 8 << 30;

/// The bytes of a file.
pub fn read(path: &Path) -> Result<Vec<u8>, SnapshotError> {
    crate::source::read(path, MOST_BYTES).map_err(|error| file_error(path, &error))
}

fn file_error(path: &Path, error: &std::io::Error) -> SnapshotError {
    SnapshotError::File { path: path.display().to_string(), reason: error.to_string() }
}

impl Snapshot {
    /// The snapshot as bytes.
    ///
    /// # Errors
    /// For a state that [`from_bytes`](Self::from_bytes) would refuse, taken while something written past the calls was not yet judged:
    /// the error says where.
    pub fn to_bytes(&self) -> Result<Vec<u8>, SnapshotError> {
        self.validate()?;
        pack(Kind::Snapshot, &*self.0)
    }

    /// The snapshot that these bytes are. It goes on to the same bits in builds that agree about the feature `direct`. From one to
    /// the other it goes on without a factor, to the same answers within the tolerances of its solves.
    ///
    /// # Errors
    /// For bytes that are no snapshot, are damaged or of another version, and for a state that contradicts itself: the error
    /// says where. Bytes from anywhere may be given.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, SnapshotError> {
        Self::of(unpack(Kind::Snapshot, bytes)?)
    }

    /// Validates contents that were read.
    pub(crate) fn of(mut contents: Contents) -> Result<Self, SnapshotError> {
        check::complete(&mut contents)?;
        Ok(Self(Arc::new(contents)))
    }

    /// Judges it as one that was read.
    pub(crate) fn validate(&self) -> Result<(), SnapshotError> {
        check::validate_contents(&self.0).map(|_| ())
    }

    /// Writes the snapshot to a file, whole or not at all.
    ///
    /// # Errors
    /// As [`to_bytes`](Self::to_bytes), and where the file cannot be written.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), SnapshotError> {
        replace(path.as_ref(), &self.to_bytes()?)
    }

    /// Reads a snapshot from a file.
    ///
    /// # Errors
    /// Where the file cannot be read, and as [`from_bytes`](Self::from_bytes).
    pub fn load(path: impl AsRef<Path>) -> Result<Self, SnapshotError> {
        Self::from_bytes(&read(path.as_ref())?)
    }
}

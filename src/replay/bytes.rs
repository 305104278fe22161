//! Recordings as bytes and files, in the form of snapshots.

use super::{Input, Recording};
use crate::snapshot::bytes::{Kind, pack, read, replace, unpack};
use crate::snapshot::{Contents, Snapshot, SnapshotError, check_spawned};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};
use std::path::Path;

impl Serialize for Snapshot {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.serialize(serializer)
    }
}

/// Judged as one that stands alone.
impl<'de> Deserialize<'de> for Snapshot {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Self::of(Contents::deserialize(deserializer)?).map_err(D::Error::custom)
    }
}

impl Recording {
    /// The recording as bytes.
    ///
    /// # Errors
    /// Where [`from_bytes`](Self::from_bytes) would refuse it: for a state at its start, or gone back to in it, that contradicts itself.
    pub fn to_bytes(&self) -> Result<Vec<u8>, SnapshotError> {
        self.start.validate()?;
        for input in &self.inputs {
            match input {
                Input::Spawn(spawned) => _ = check_spawned(&spawned.0)?,
                Input::Restore(snapshot) => snapshot.validate()?,
                _ => {}
            }
        }
        pack(Kind::Recording, self)
    }

    /// The recording that these bytes are. Its states are judged here, and its calls where they are repeated: those that a host would
    /// be refused are refused again.
    ///
    /// # Errors
    /// As for a [`Snapshot`]: bytes from anywhere may be given.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, SnapshotError> {
        let mut recording: Self = unpack(Kind::Recording, bytes)?;
        for input in &mut recording.inputs {
            if let Input::Spawn(spawned) = input {
                spawned.0.topology = Some(check_spawned(&spawned.0)?);
            }
        }
        Ok(recording)
    }

    /// Writes the recording to a file, whole or not at all.
    ///
    /// # Errors
    /// As [`to_bytes`](Self::to_bytes), and where the file cannot be written.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), SnapshotError> {
        replace(path.as_ref(), &self.to_bytes()?)
    }

    /// Reads a recording from a file.
    ///
    /// # Errors
    /// Where the file cannot be read, and as [`from_bytes`](Self::from_bytes).
    pub fn load(path: impl AsRef<Path>) -> Result<Self, SnapshotError> {
        Self::from_bytes(&read(path.as_ref())?)
    }
}

//! Snapshots and recordings.

use crate::handle::{Kind, Table};
use crate::pointer::{Array, Out};
use crate::status::{Answer, RhexisStatus, call, refused};
use crate::types::*;
use crate::world::{Run, World, keep, with};
use rhexis::replay::Recording;
use rhexis::simulation::Simulation;
use rhexis::snapshot::{Snapshot, SnapshotError};

static SNAPSHOTS: Table<Kept<Snapshot>> = Table::new(Kind::Snapshot);
static RECORDINGS: Table<Kept<Recording>> = Table::new(Kind::Recording);

/// A state or a run, with its bytes once they were asked for.
struct Kept<T> {
    value: T,
    /// How far the scene of the world had come.
    progress: Option<(u64, bool)>,
    bytes: Option<Vec<u8>>,
}

impl<T> Kept<T> {
    fn new(value: T, progress: Option<(u64, bool)>) -> Self {
        Self { value, progress, bytes: None }
    }

    /// The bytes, which stay where they are.
    fn bytes(&mut self, pack: impl FnOnce(&T) -> Result<Vec<u8>, SnapshotError>) -> Answer<RhexisViewU8> {
        let bytes = match &self.bytes {
            Some(bytes) => bytes,
            None => self.bytes.insert(pack(&self.value).map_err(refused)?),
        };
        Ok(RhexisViewU8 { data: bytes.as_ptr(), count: bytes.len() })
    }
}

/// Takes a snapshot of the whole state, to go back to and to go on from to the same bits.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_snapshot_take(world: RhexisWorld, snapshot: Out<RhexisSnapshot>) -> RhexisStatus {
    call(|| {
        snapshot.check("snapshot")?;
        let taken = with(world, |world| {
            let progress = match &world.run {
                Run::Scene(instance) => Some(instance.progress()),
                Run::Bare(_) => None,
            };
            Ok(Kept::new(world.simulation().snapshot(), progress))
        })?;
        let bits = SNAPSHOTS.add(|_| taken)?;
        snapshot.write(RhexisSnapshot { bits });
        Ok(())
    })
}

/// Destroys a snapshot, and the bytes that it has lent.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_snapshot_destroy(snapshot: RhexisSnapshot) -> RhexisStatus {
    call(|| SNAPSHOTS.remove(snapshot.bits))
}

/// Lends the bytes of a snapshot, valid until it is destroyed.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_snapshot_bytes(snapshot: RhexisSnapshot, bytes: Out<RhexisViewU8>) -> RhexisStatus {
    call(|| {
        bytes.check("bytes")?;
        bytes.write(SNAPSHOTS.with(snapshot.bits, |kept| kept.bytes(Snapshot::to_bytes))?);
        Ok(())
    })
}

/// Makes a snapshot of bytes, from wherever they come: they are judged.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_snapshot_from_bytes(
    data: Array<u8>,
    count: usize,
    snapshot: Out<RhexisSnapshot>,
) -> RhexisStatus {
    call(|| {
        snapshot.check("snapshot")?;
        let value = Snapshot::from_bytes(data.read(count, "the bytes")?).map_err(refused)?;
        let bits = SNAPSHOTS.add(|_| Kept::new(value, None))?;
        snapshot.write(RhexisSnapshot { bits });
        Ok(())
    })
}

fn go_back(world: &mut World, snapshot: &Snapshot, progress: Option<(u64, bool)>) -> Answer<()> {
    match &mut world.run {
        Run::Bare(simulation) => simulation.restore(snapshot).map_err(refused)?,
        Run::Scene(instance) => {
            let progress = progress.unwrap_or((snapshot.step(), false));
            instance.resume(snapshot, progress).map_err(refused)?;
        }
    }
    world.shown.clear();
    world.events.clear();
    Ok(())
}

/// Goes back to a snapshot, of this world or of another one: bodies, obstacles and tools are those of the snapshot. Handles of this world
/// name in it what they named when it was taken of this world.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_restore(world: RhexisWorld, snapshot: RhexisSnapshot) -> RhexisStatus {
    call(|| {
        let (snapshot, progress) = SNAPSHOTS.with(snapshot.bits, |kept| Ok((kept.value.clone(), kept.progress)))?;
        with(world, |world| go_back(world, &snapshot, progress))
    })
}

/// Makes a world that goes on from a snapshot, with as many threads as its settings ask for; not driven by a scene.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_world_from_snapshot(snapshot: RhexisSnapshot, world: Out<RhexisWorld>) -> RhexisStatus {
    call(|| {
        world.check("world")?;
        let snapshot = SNAPSHOTS.with(snapshot.bits, |kept| Ok(kept.value.clone()))?;
        let simulation = Simulation::from_snapshot(&snapshot).map_err(refused)?;
        world.write(keep(Run::Bare(Box::new(simulation)))?);
        Ok(())
    })
}

/// Writes down from now on what is done to a world.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_record(world: RhexisWorld) -> RhexisStatus {
    call(|| {
        with(world, |world| {
            world.simulation().record();
            Ok(())
        })
    })
}

/// Ends the recording of a world. Refused where none was made.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_record_end(world: RhexisWorld, recording: Out<RhexisRecording>) -> RhexisStatus {
    call(|| {
        recording.check("recording")?;
        let ended = with(world, |world| {
            let none = || refused("nothing is recorded: call rhexis_record first");
            world.simulation().end_recording().ok_or_else(none)
        })?;
        let bits = RECORDINGS.add(|_| Kept::new(ended, None))?;
        recording.write(RhexisRecording { bits });
        Ok(())
    })
}

/// Destroys a recording, and the bytes that it has lent.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_recording_destroy(recording: RhexisRecording) -> RhexisStatus {
    call(|| RECORDINGS.remove(recording.bits))
}

/// Lends the bytes of a recording, valid until it is destroyed.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_recording_bytes(recording: RhexisRecording, bytes: Out<RhexisViewU8>) -> RhexisStatus {
    call(|| {
        bytes.check("bytes")?;
        bytes.write(RECORDINGS.with(recording.bits, |kept| kept.bytes(Recording::to_bytes))?);
        Ok(())
    })
}

/// Makes a recording of bytes, from wherever they come: they are judged.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_recording_from_bytes(
    data: Array<u8>,
    count: usize,
    recording: Out<RhexisRecording>,
) -> RhexisStatus {
    call(|| {
        recording.check("recording")?;
        let value = Recording::from_bytes(data.read(count, "the bytes")?).map_err(refused)?;
        let bits = RECORDINGS.add(|_| Kept::new(value, None))?;
        recording.write(RhexisRecording { bits });
        Ok(())
    })
}

/// Does once more what was recorded, to the same hash or to a refusal, and makes a world of its end. `world` may be NULL.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_replay(recording: RhexisRecording, world: Out<RhexisWorld>) -> RhexisStatus {
    call(|| {
        world.check_if_any("world")?;
        let end = RECORDINGS.with(recording.bits, |kept| kept.value.replay().map_err(refused))?;
        if world.check("world").is_ok() {
            world.write(keep(Run::Bare(Box::new(end)))?);
        }
        Ok(())
    })
}

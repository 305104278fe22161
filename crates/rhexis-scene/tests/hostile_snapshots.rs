//! Bytes are never trusted: whatever is changed in a snapshot or a recording, it is refused, or it steps without a panic; and it
//! takes no more memory than a fixed multiple of the bytes.

#[path = "../../../tests/common/mod.rs"]
mod common;
mod hostile;

use common::Square;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use rhexis::components::{Attributes, Channel, Sleeping, Tearing};
use rhexis::replay::Recording;
use rhexis::settings::Settings;
use rhexis::simulation::Simulation;
use rhexis::snapshot::{Snapshot, SnapshotError};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};
use std::alloc::System;

#[global_allocator]
static GLOBAL: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

const HEAD: usize = 28;

fn torn() -> Simulation {
    let mut square = Square::new([6, 5], 60.0);
    square.tearing = Tearing { strength_across_fibres: 0.1, strength_along_fibres: 0.01, ..square.tearing };
    let mut simulation = Simulation::new(Settings { threads: 1, ..Settings::default() }).unwrap();
    simulation.record();
    let membrane = square.membrane().with(Sleeping::default());
    let values = membrane.mesh().positions.iter().flat_map(|p| [p.x / 30.0, p.y / 30.0]).collect();
    let channels = vec![(Channel::TextureCoordinates, 0)];
    let body = simulation.spawn(membrane.with(Attributes { stride: 2, values, channels })).unwrap();
    simulation.cut(body, &common::NOTCH).unwrap();
    (0..40).for_each(|_| _ = simulation.step(4.0));
    simulation
}

/// What a head guards, as it is before it is compressed.
fn body(bytes: &[u8]) -> Vec<u8> {
    let length = u64::from_le_bytes(bytes[12..20].try_into().unwrap()) as usize;
    match bytes[10] & 2 {
        0 => bytes[HEAD..].to_vec(),
        _ => lz4_flex::block::decompress(&bytes[HEAD..], length).unwrap(),
    }
}

/// A head that guards this body, and says that it has this length.
fn guarded(like: &[u8], body: &[u8], marks: u8, length: u64) -> Vec<u8> {
    let mut bytes = like[..HEAD].to_vec();
    bytes[10] = bytes[10] & 1 | marks;
    bytes[12..20].copy_from_slice(&length.to_le_bytes());
    bytes[20..28].copy_from_slice(&xxhash_rust::xxh3::xxh3_64(body).to_le_bytes());
    bytes.extend_from_slice(body);
    bytes
}

fn runner(cases: u32) -> TestRunner {
    let config = Config { cases, failure_persistence: None, ..Config::default() };
    TestRunner::new_with_rng(config, TestRng::from_seed(RngAlgorithm::ChaCha, &[7; 32]))
}

/// Bytes to put in at places, counted in parts of the whole.
fn changes() -> impl Strategy<Value = Vec<(f64, u8)>> {
    let byte = prop_oneof![any::<u8>(), Just(0xff), Just(0), Just(0x7f), Just(0x80)];
    prop::collection::vec((0.0..1.0, byte), 1..6)
}

fn changed(mut body: Vec<u8>, changes: &[(f64, u8)]) -> Vec<u8> {
    let length = body.len() as f64;
    changes.iter().for_each(|&(at, byte)| body[(at * length) as usize] = byte);
    body
}

/// Steps it a little, by settings of our own: those of the bytes may ask for more work than there is time.
fn try_out(snapshot: &Snapshot) {
    if let Ok(mut simulation) = Simulation::new(Settings { threads: 1, ..Settings::default() })
        && simulation.restore(snapshot).is_ok()
    {
        simulation.set_settings(Settings::default()).unwrap();
        (0..3).for_each(|_| _ = simulation.step(4.0));
        let _ = simulation.frame();
        let _ = simulation.snapshot().to_bytes();
    }
}

#[test]
fn changed_bytes_are_refused_or_step() {
    let bytes = torn().snapshot().to_bytes().unwrap();
    let whole = body(&bytes);
    let mut read = 0;
    runner(1500)
        .run(&changes(), |changes| {
            let changed = changed(whole.clone(), &changes);
            if let Ok(snapshot) = Snapshot::from_bytes(&guarded(&bytes, &changed, 0, changed.len() as u64)) {
                try_out(&snapshot);
            }
            Ok(())
        })
        .unwrap();
    // Some are read: it is the judgement of the state that is tried, not the checksum.
    for at in 0..whole.len() / 97 {
        let mut changed = whole.clone();
        changed[97 * at] ^= 1;
        read += u32::from(Snapshot::from_bytes(&guarded(&bytes, &changed, 0, changed.len() as u64)).is_ok());
    }
    assert!(read > 10, "{read} of {} read", whole.len() / 97);
}

#[test]
fn changed_recordings_are_refused_or_repeated() {
    let bytes = torn().end_recording().unwrap().to_bytes().unwrap();
    let whole = body(&bytes);
    let read = std::cell::Cell::new(0);
    runner(500)
        .run(&changes(), |changes| {
            let changed = changed(whole.clone(), &changes);
            if let Ok(recording) = Recording::from_bytes(&guarded(&bytes, &changed, 0, changed.len() as u64)) {
                read.set(read.get() + u32::from(hostile::replayed(&recording)));
            }
            Ok(())
        })
        .unwrap();
    // As with snapshots, some come so far.
    assert!(read.get() > 10, "{} repeated", read.get());
}

#[test]
fn damage_is_told_by_what_it_is() {
    let bytes = torn().snapshot().to_bytes().unwrap();
    let with = |at: usize, byte: u8| {
        let mut bytes = bytes.clone();
        bytes[at] = byte;
        Snapshot::from_bytes(&bytes).unwrap_err()
    };
    assert!(matches!(with(0, b'x'), SnapshotError::AnotherFile { .. }));
    assert!(matches!(with(8, 77), SnapshotError::Version { found: 77, .. }));
    assert_eq!(with(bytes.len() - 1, !bytes[bytes.len() - 1]), SnapshotError::Damaged);
    for length in [0, 7, HEAD - 1, HEAD, bytes.len() / 2, bytes.len() - 1] {
        assert!(Snapshot::from_bytes(&bytes[..length]).is_err(), "the first {length} bytes");
    }
    assert!(matches!(Recording::from_bytes(&bytes), Err(SnapshotError::AnotherFile { .. })));
    let missing = Snapshot::load("no such folder/file").unwrap_err();
    assert!(missing.to_string().contains("no such folder"), "{missing}");
}

#[test]
fn bytes_of_a_build_with_other_factors_are_read_where_they_do_not_promise_bits() {
    let other_build = |mut bytes: Vec<u8>| {
        bytes[10] ^= 1;
        bytes
    };
    let simulation = torn();
    assert!(Snapshot::from_bytes(&other_build(simulation.snapshot().to_bytes().unwrap())).is_ok());
    let recording = torn().end_recording().unwrap().to_bytes().unwrap();
    assert!(matches!(Recording::from_bytes(&other_build(recording)), Err(SnapshotError::Build { .. })));
}

#[test]
fn absurd_sizes_take_no_memory() {
    let bytes = torn().snapshot().to_bytes().unwrap();
    let whole = body(&bytes);
    let most = 200 * whole.len() + (4 << 20);
    let refused = |bytes: &[u8], what: &str| {
        let region = Region::new(GLOBAL);
        assert!(Snapshot::from_bytes(bytes).is_err(), "{what}");
        let taken = region.change().bytes_allocated;
        assert!(taken < most, "{what}: {taken} bytes allocated, of {} read", bytes.len());
    };
    // A compressed body that says it is endless.
    let zeros = lz4_flex::block::compress(&vec![0; 10_000_000]);
    for length in [10_000_000, 1 << 40, u64::MAX] {
        refused(&guarded(&bytes, &zeros, 2, length), "compressed zeros");
    }
    // The longest number wherever one may stand: lengths of lists among them.
    let longest = [0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x01];
    for at in (0..whole.len() - longest.len()).step_by(7) {
        let mut changed = whole.clone();
        changed[at..at + longest.len()].copy_from_slice(&longest);
        let region = Region::new(GLOBAL);
        let _ = Snapshot::from_bytes(&guarded(&bytes, &changed, 0, changed.len() as u64));
        let taken = region.change().bytes_allocated;
        // Other tests of this file may run meanwhile.
        assert!(taken < 100 * most, "at {at}: {taken} bytes allocated");
    }
}

/// Bodies of a snapshot and of a recording, for the fuzz targets.
#[test]
#[ignore = "writes files for tests/fuzz/seed.sh into the directory RHEXIS_SEEDS: cargo test --test hostile_snapshots -- --ignored seeds"]
fn seeds() {
    let Some(folder) = std::env::var_os("RHEXIS_SEEDS").map(std::path::PathBuf::from) else { return };
    let mut simulation = torn();
    std::fs::write(folder.join("snapshot/torn"), body(&simulation.snapshot().to_bytes().unwrap())).unwrap();
    std::fs::write(folder.join("recording/torn"), body(&simulation.end_recording().unwrap().to_bytes().unwrap()))
        .unwrap();
}

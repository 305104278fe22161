//! What must hold whatever is given: shared by the tests that run everywhere and by the fuzz targets (`tests/fuzz`).
//!
//! Each function takes bytes from anywhere; it panics where the engine breaks a promise.
#![allow(dead_code, reason = "shared: each that takes it in uses a part")]

#[path = "../../../../tests/meshes/mod.rs"]
mod meshes;

use glam::DVec3;
use meshes::{Body, Sheet};
use rhexis::replay::{self, Recording};
use rhexis::settings::{Advanced, LinearParams, Settings};
use rhexis::simulation::Simulation;
use rhexis::snapshot::Snapshot;
use rhexis::storage::{Edit, EditRecord, Topology, Triangles, Vertices, apply, outlook, undo, validate};
use rhexis_scene::mesh_file::{self, Reading};
use rhexis_scene::{Document, catalog::CATALOG};
use std::path::Path;
use std::sync::OnceLock;

/// Length of the head of a snapshot or a recording.
pub const HEAD: usize = 28;

/// A mesh file is refused, or its surface passes the check.
pub fn mesh(extension: &str, bytes: &[u8]) {
    let name = format!("mesh.{extension}");
    if let Ok(file) = mesh_file::from_bytes_with(Path::new(&name), bytes.to_vec(), &Reading::default()) {
        let mesh = &file.mesh;
        assert_eq!(mesh.check(), Ok(()));
        assert!(mesh.positions.iter().all(|p| p.is_finite()));
        if let Some(attributes) = &file.attributes {
            assert_eq!(attributes.values.len(), attributes.stride * mesh.positions.len());
            assert!(attributes.values.iter().all(|value| value.is_finite()));
        }
    }
}

/// A scene is refused with a text, or it can be checked and stepped.
pub fn scene(document: Document) {
    let Ok(scene) = document.scene() else { return };
    let is_small = scene.file().bodies.iter().all(|body| body.copies < 10 && is_small(&format!("{:?}", body.mesh)));
    if !is_small || scene.check().is_err() {
        return;
    }
    let Ok(mut instance) = scene.instantiate() else { return };
    // The scene's own may ask for more work than there is time.
    instance.simulation.set_settings(cheap()).unwrap();
    for _ in 0..2 {
        let _ = instance.simulation.step(1.0);
        sound(&instance.simulation);
    }
}

/// Whether no two numbers of a mesh's description make a product that takes long to build.
fn is_small(mesh: &str) -> bool {
    let numbers =
        mesh.split(|c: char| !c.is_ascii_digit() && !".eE-+".contains(c)).filter_map(|w| w.parse::<f64>().ok());
    let mut sizes: Vec<f64> = numbers.map(|x| x.abs().max(1.0 / x.abs()).max(1.0)).collect();
    sizes.sort_by(|a, b| b.total_cmp(a));
    let [largest, second] = [0, 1].map(|i| sizes.get(i).copied().unwrap_or(1.0));
    largest * second < 3000.0 && largest < 1000.0
}

/// Few iterations, one thread.
fn cheap() -> Settings {
    let linear = LinearParams { tolerance: 1e-2, iterations: 20, ..LinearParams::default() };
    Settings {
        threads: 1,
        advanced: Advanced { linear, max_step_halvings: 1, static_iterations: 2, ..Advanced::default() },
        ..Settings::default()
    }
}

/// Finite, with tables that belong together.
fn sound(simulation: &Simulation) {
    for (vertices, triangles, topology) in simulation.world().query::<(&Vertices, &Triangles, &Topology)>().iter() {
        assert!(vertices.position.iter().all(|x| x.is_finite()));
        assert!(vertices.velocity.iter().all(|v| v.is_finite()));
        assert_eq!(validate(vertices, triangles, topology), Ok(()));
    }
}

/// A body with the head that guards it: 8 bytes of the kind, version, marks, length, checksum.
pub fn guarded(kind: &[u8; 8], body: &[u8]) -> Vec<u8> {
    static OWN: OnceLock<Vec<u8>> = OnceLock::new();
    let own = OWN.get_or_init(|| Simulation::new(cheap()).unwrap().snapshot().to_bytes().unwrap());
    let mut bytes = kind.to_vec();
    // Version and marks as this build writes them, but for the mark of compression.
    bytes.extend_from_slice(&[own[8], own[9], own[10] & 1, 0]);
    bytes.extend_from_slice(&(body.len() as u64).to_le_bytes());
    bytes.extend_from_slice(&xxhash_rust::xxh3::xxh3_64(body).to_le_bytes());
    bytes.extend_from_slice(body);
    bytes
}

/// A snapshot is refused, or it steps.
pub fn snapshot(body: &[u8]) {
    let Ok(snapshot) = Snapshot::from_bytes(&guarded(b"rhexsnap", body)) else { return };
    let mut simulation = Simulation::new(cheap()).unwrap();
    if simulation.restore(&snapshot).is_err() {
        return;
    }
    simulation.set_settings(cheap()).unwrap();
    for _ in 0..2 {
        let _ = simulation.step(4.0);
        sound(&simulation);
    }
    let _ = simulation.frame();
    Snapshot::from_bytes(&simulation.snapshot().to_bytes().unwrap()).unwrap();
}

/// A recording is refused, or its start can be gone back to, and it is repeated if that does not take long.
pub fn recording(body: &[u8]) {
    let Ok(recording) = Recording::from_bytes(&guarded(b"rhexrec\0", body)) else { return };
    let mut simulation = Simulation::new(cheap()).unwrap();
    if simulation.restore(recording.start()).is_ok() {
        sound(&simulation);
    }
    replayed(&recording);
}

/// Repeats a recording, to whatever end, if no settings in it ask for more work than there is time; whether it did.
pub fn replayed(recording: &Recording) -> bool {
    let is_few = |settings: &Settings| {
        let Settings { threads, max_tear_passes, advanced, .. } = *settings;
        let Advanced { linear, newton_iterations, static_iterations, max_step_halvings, .. } = advanced;
        let solves = [linear.iterations / 1000, newton_iterations, static_iterations / 10];
        let mut counts = solves.into_iter().chain([max_tear_passes / 10, max_step_halvings]);
        threads < 5 && counts.all(|count| count < 10)
    };
    let is_cheap = |input: &replay::Input| match input {
        replay::Input::SetSettings(settings) => is_few(settings),
        replay::Input::Restore(snapshot) => is_few(snapshot.settings()),
        replay::Input::SettleAndTear { rounds, .. } => *rounds < 20,
        _ => true,
    };
    let is_short = is_few(recording.start().settings()) && recording.inputs().iter().all(is_cheap);
    if is_short {
        // Any end will do: the hash that the bytes tell may be another.
        let _ = recording.replay();
    }
    is_short
}

/// `--set` with any text, a line each, on a scene of the catalog.
pub fn overrides(which: u8, text: &str) {
    let entry = &CATALOG[usize::from(which) % CATALOG.len()];
    let mut document = Document::named(entry.name).unwrap();
    for line in text.lines().take(20) {
        let _ = document.set(line);
    }
    scene(document);
}

/// Edits of a small body, read from bytes, undone now and then: refused, or whole.
pub fn edits(bytes: &[u8]) {
    let mut input = Input(bytes);
    let start = input.byte() % 5;
    let sheet: Sheet = match start {
        1 => meshes::cap(2),
        2 => meshes::sphere(1),
        3 => meshes::torus(4, 4),
        _ => meshes::grid(3, 3, 3.0, 3.0),
    };
    let mut body = Body::new(&sheet, DVec3::new(1.0, 0.5, 0.2));
    let area: f64 = area(&body);
    let mut done: Vec<EditRecord> = Vec::new();
    if start == 4 {
        // A notch, so that there is a tip.
        done.push(apply(&mut body.mesh(), &Edit::Open { path: [1, 5].into_iter().collect() }).unwrap());
    }
    while !input.0.is_empty() && body.triangles.len() < 500 {
        let edit = match input.byte() % 9 {
            0 => Edit::SplitEdge { triangle: input.row(), edge: input.edge(), weight: input.number() },
            1 => Edit::SplitTriangle { triangle: input.row(), weights: input.weights() },
            2 => Edit::Flip { triangle: input.row(), edge: input.edge() },
            3 => Edit::Slide { vertex: input.row(), towards: input.row(), weight: input.number() },
            4 => Edit::Open { path: (0..input.byte() % 6).map(|_| input.row()).collect() },
            5 | 6 => Edit::Collapse { vertex: input.row(), into: input.row() },
            7 => {
                let (triangle, corner) = (input.row(), input.edge());
                let corners = body.triangles.corners.get(triangle as usize);
                let vertex = corners.and_then(|corners| corners.get(corner)).copied().unwrap_or(triangle);
                Edit::Glide { vertex, triangle, weights: input.weights() }
            }
            _ => {
                if let Some(record) = done.pop() {
                    undo(&mut body.mesh(), &record).unwrap();
                    assert_eq!(body.mesh().validate(), Ok(()));
                }
                continue;
            }
        };
        let expected = outlook(&body.mesh(), &edit).map(|_| ());
        let outcome = apply(&mut body.mesh(), &edit);
        assert_eq!(body.mesh().validate(), Ok(()), "{edit:?}");
        match outcome {
            Ok(record) => {
                assert_eq!(expected, Ok(()), "{edit:?}");
                done.push(record);
            }
            // As text: a weight that is no number differs from itself.
            Err(refusal) => assert_eq!(format!("{expected:?}"), format!("{:?}", Err::<(), _>(refusal)), "{edit:?}"),
        }
    }
    let now = self::area(&body);
    assert!(now.is_finite() && now > 0.0 && now < 10.0 * area);
}

fn area(body: &Body) -> f64 {
    body.triangles.rest.iter().map(|rest| rest.area).sum()
}

/// Bytes that are read as numbers; zeros after their end.
struct Input<'a>(&'a [u8]);

impl Input<'_> {
    fn byte(&mut self) -> u8 {
        let (first, rest) = self.0.split_first().map_or((0, self.0), |(first, rest)| (*first, rest));
        self.0 = rest;
        first
    }

    /// Mostly a row that there is; now and then one far beyond.
    fn row(&mut self) -> u32 {
        match self.byte() {
            255 => u32::MAX,
            254 => 1 << 20,
            row => row.into(),
        }
    }

    fn edge(&mut self) -> usize {
        match self.byte() {
            255 => usize::MAX,
            edge => usize::from(edge % 4),
        }
    }

    fn number(&mut self) -> f64 {
        match self.byte() {
            255 => f64::NAN,
            254 => f64::INFINITY,
            253 => -1e-300,
            252 => 1e300,
            251 => 1.0,
            250 => f64::EPSILON,
            byte => f64::from(byte) / 249.0,
        }
    }

    fn weights(&mut self) -> [f64; 3] {
        let [a, b] = [self.number(), self.number()];
        [a, b, 1.0 - a - b]
    }
}

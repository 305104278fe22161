//! The files that a run writes as it goes on. Each row is flushed, each whole file renamed into place: an interrupted run
//! leaves what it had. What cannot be written ends no run: it is tried again where that can be, and reported at once and at the
//! end.

use super::journal::{Journal, Written};
use super::lock::{self, Lock};
use super::moments::Moments;
use super::report::RunReport;
use super::series::Observation;
use super::{Stop, checkpoint};
use crate::output::{OutputError, PictureSettings, PvdWriter, file, gltf, render, surface};
use glam::DVec3;
use rhexis::components::BlockedNucleation;
use rhexis::event::{Event, EventKind, Verdict};
use rhexis::frame::{BodyFrame, Frame};
use rhexis_scene::Seams;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use slotmap::Key;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The output directory and its open files.
pub(super) struct Files {
    folder: PathBuf,
    lock: Lock,
    title: String,
    series: Journal,
    events: Journal,
    frames: Option<PvdWriter>,
    picture_moments: Moments,
    frame_moments: Moments,
    last_frame: Option<u64>,
    last_picture: Option<u64>,
    /// Pictures that could not be drawn, and what else the report should say of the files.
    pub notes: Vec<String>,
    /// Whether pictures have arrows for the forces of obstacles and jaws.
    pub with_forces: bool,
    /// What could not be written, by the kind of file.
    faults: BTreeMap<&'static str, String>,
    /// Faults that nobody has been told of.
    untold: Vec<String>,
}

fn cannot_write(path: &Path, error: impl std::fmt::Display) -> String {
    format!("cannot write {}: {error}; make room, or choose another directory with --out", path.display())
}

fn failed(path: &Path, error: impl std::fmt::Display) -> Stop {
    Stop::Failed(cannot_write(path, error))
}

/// Takes away the pictures and the frames of an earlier run from these steps on: beside those of this one they would tell of
/// another tear.
fn remove_earlier(folder: &Path, from: [u64; 2]) -> std::io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        let found = numbered(&entry.file_name().to_string_lossy());
        if found.is_some_and(|(kind, step)| step >= from[kind]) && entry.file_type()?.is_file() {
            std::fs::remove_file(entry.path())?;
        }
    }
    Ok(())
}

/// The kind and the step of a file with a name that a run gives: 0 for `picture-0-000012.png`, 1 for
/// `frames-0-tissue-000012.vtu`.
fn numbered(name: &str) -> Option<(usize, u64)> {
    let number = |word: &str, least: usize| {
        let is_number = word.len() >= least && word.bytes().all(|b| b.is_ascii_digit());
        is_number.then(|| word.parse().ok()).flatten()
    };
    let step = |kind: &str, extension: &str| {
        let (first, rest) = name.strip_prefix(kind)?.strip_suffix(extension)?.split_once('-')?;
        number(first, 1).and_then(|_: u64| number(rest.rsplit('-').next()?, 6))
    };
    let picture = step("picture-", ".png").map(|step| (0, step));
    picture.or_else(|| step("frames-", ".vtu").map(|step| (1, step)))
}

/// Whether a run gives this name to a file of its output directory, or to the part of one.
pub(super) fn is_own_name(name: &str) -> bool {
    let whole = name.strip_suffix(".part").unwrap_or(name);
    let fixed = ["series.csv", "events.jsonl", "report.json", "frames.pvd", checkpoint::NAME, lock::NAME];
    fixed.contains(&whole) || numbered(whole).is_some()
}

impl From<OutputError> for Stop {
    fn from(error: OutputError) -> Self {
        Self::Failed(error.to_string())
    }
}

/// Where the files of a run stand: to go on from there.
#[derive(Debug, Default, Deserialize, Serialize)]
pub(super) struct Marks {
    /// Lengths of `series.csv` and `events.jsonl`.
    lengths: [u64; 2],
    /// Of the list of frames.
    entries: String,
    last_frame: Option<u64>,
    last_picture: Option<u64>,
    notes: Vec<String>,
}

impl Files {
    /// Opens the files of a run that was interrupted and takes away what they have beyond these marks.
    pub(crate) fn resume(lock: Lock, title: &str, moments: [Moments; 2], marks: &Marks) -> Result<Self, Stop> {
        let folder = &lock.folder().to_owned();
        let open = |name: &str, length: u64| {
            let path = folder.join(name);
            let journal = Journal::resume(&path, length);
            journal.map_err(|error| Stop::Failed(format!("cannot go on with {}: {error}", path.display())))
        };
        let beyond = [marks.last_picture, marks.last_frame].map(|last| last.map_or(0, |step| step + 1));
        remove_earlier(folder, beyond).map_err(|error| failed(folder, error))?;
        let has_frames = moments[1].count > 0;
        let frames = has_frames.then(|| PvdWriter::resume(&folder.join("frames.pvd"), &marks.entries)).transpose()?;
        let [series, events] = marks.lengths;
        let journals = [open("series.csv", series)?, open("events.jsonl", events)?];
        let files = Self::new(lock, title, moments, journals, frames);
        let &Marks { last_frame, last_picture, ref notes, .. } = marks;
        Ok(Self { last_frame, last_picture, notes: notes.clone(), ..files })
    }

    /// Begins the files.
    pub(crate) fn create(lock: Lock, title: &str, moments: [Moments; 2]) -> Result<Self, Stop> {
        let folder = &lock.folder().to_owned();
        let open = |name: &str| {
            let path = folder.join(name);
            Journal::create(&path).map_err(|error| failed(&path, error))
        };
        checkpoint::remove(folder)?;
        remove_earlier(folder, [0; 2]).map_err(|error| failed(folder, error))?;
        let has_frames = moments[1].count > 0;
        let frames = has_frames.then(|| PvdWriter::create(&folder.join("frames.pvd"))).transpose()?;
        let journals = [open("series.csv")?, open("events.jsonl")?];
        Ok(Self::new(lock, title, moments, journals, frames))
    }

    fn new(
        lock: Lock,
        title: &str,
        [picture_moments, frame_moments]: [Moments; 2],
        [series, events]: [Journal; 2],
        frames: Option<PvdWriter>,
    ) -> Self {
        Self {
            folder: lock.folder().to_owned(),
            lock,
            title: title.to_owned(),
            series,
            events,
            frames,
            picture_moments,
            frame_moments,
            last_frame: None,
            last_picture: None,
            notes: Vec::new(),
            with_forces: false,
            faults: BTreeMap::new(),
            untold: Vec::new(),
        }
    }

    /// Where the files stand; nothing while some of it cannot be written.
    pub(crate) fn marks(&self) -> Option<Marks> {
        let lengths = [self.series.mark()?, self.events.mark()?];
        let entries = self.frames.as_ref().map_or("", PvdWriter::entries).to_owned();
        let &Self { last_frame, last_picture, ref notes, .. } = self;
        Some(Marks { lengths, entries, last_frame, last_picture, notes: notes.clone() })
    }

    /// Whether the state after `step` steps is to be drawn or written as a frame; `is_special` states are, whatever the
    /// moments say.
    pub(crate) fn wants_frame(&self, step: u64, is_special: bool) -> bool {
        [self.picture_moments, self.frame_moments].iter().any(|m| m.is_due(step) || (is_special && m.count > 0))
    }

    /// The state after a step: its pictures and frames, where they are due or it `is_special`.
    pub(crate) fn frame(&mut self, frame: &Frame, step: u64, tears: u64, is_special: bool) {
        let due = |moments: Moments| moments.is_due(step) || (is_special && moments.count > 0);
        if due(self.frame_moments)
            && self.last_frame.replace(step) != Some(step)
            && let Some(list) = &mut self.frames
            && let Err(error) = list.write_frame(frame)
        {
            self.fault("frames", error.to_string());
        }
        if due(self.picture_moments) && self.last_picture.replace(step) != Some(step) {
            for (index, body) in frame.bodies.iter().enumerate() {
                let path = self.folder.join(format!("picture-{index}-{step:06}.png"));
                let titled = PictureSettings::titled(&self.title, frame.time, step, tears as usize);
                let settings =
                    PictureSettings { solids: frame.solids.clone(), show_forces: self.with_forces, ..titled };
                match render(&path, body, &settings) {
                    Err(OutputError::Content { what, .. }) => {
                        self.notes.push(format!("{}: no picture: {what}", body.name))
                    }
                    Err(error) => self.fault("pictures", error.to_string()),
                    Ok(()) => {}
                }
            }
        }
    }

    /// The surfaces of the bodies at the end, as OBJ and as PLY; `seams` are those of their textures.
    pub(crate) fn surfaces(&mut self, frame: &Frame, seams: &[Option<Arc<Seams>>], [obj, ply]: [bool; 2]) {
        for (index, body) in frame.bodies.iter().enumerate().filter(|_| obj || ply) {
            let path = |ending: &str| self.folder.join(format!("surface-{index}.{ending}"));
            let textured = textured(body, seams.get(index));
            let textured = textured.as_deref();
            let written = [
                obj.then(|| surface::write_textured_obj(&path("obj"), body, textured)),
                ply.then(|| surface::write_textured_ply(&path("ply"), body, textured)),
            ];
            for error in written.into_iter().flatten().filter_map(Result::err) {
                self.fault("surfaces", error.to_string());
            }
        }
    }

    /// A row of `series.csv`, after its header if it is the first.
    ///
    /// # Errors
    /// Where so much waits to be written that the run had better end.
    pub(crate) fn row(&mut self, o: &Observation, is_first: bool) -> Result<(), Stop> {
        let mut rows = csv::Writer::from_writer(Vec::new());
        let header = if is_first { rows.write_record(o.header()) } else { Ok(()) };
        let row = header.and_then(|()| rows.write_record(o.row()));
        let lines = row.map_err(|error| error.to_string()).and_then(|()| rows.into_inner().map_err(|e| e.to_string()));
        let lines = lines.map_err(Stop::Failed)?;
        let written = self.series.append(&lines);
        self.note_journal("series.csv", written);
        match self.series.is_overfull() || self.events.is_overfull() {
            true => Err(Stop::Failed(self.lasting_faults().join("\n"))),
            false => Ok(()),
        }
    }

    /// A line of `events.jsonl`.
    pub(crate) fn event(&mut self, step: u64, body: &str, event: &Event) {
        let line = format!("{}\n", described(step, body, event));
        let written = self.events.append(line.as_bytes());
        self.note_journal("events.jsonl", written);
    }

    /// A line of `events.jsonl` that no event of the engine is.
    pub(crate) fn event_line(&mut self, line: &Value) {
        let written = self.events.append(format!("{line}\n").as_bytes());
        self.note_journal("events.jsonl", written);
    }

    fn note_journal(&mut self, name: &'static str, written: std::io::Result<Written>) {
        match written {
            Ok(Written::All) => self.mended(name),
            Ok(Written::Anew) => {
                self.mended(name);
                let path = self.folder.join(name);
                self.notes.push(format!("{} was taken away during the run and is written anew", path.display()));
                if let Err(Stop::Failed(what)) = self.lock.renew() {
                    self.fault(lock::NAME, what);
                }
            }
            Err(error) => self.fault(name, cannot_write(&self.folder.join(name), error)),
        }
    }

    /// `report.json`, replacing the last one.
    pub(crate) fn report(&mut self, report: &RunReport) {
        let text = serde_json::to_string_pretty(report).map_err(|error| error.to_string());
        let path = self.folder.join("report.json");
        let replace = |text: String| file::replace(&path, (text + "\n").as_bytes()).map_err(|error| error.to_string());
        match text.and_then(replace) {
            Ok(()) => self.mended("report.json"),
            Err(what) => self.fault("report.json", what),
        }
    }

    /// The surfaces of the bodies at the end as binary glTF, with their textures and the seams of these.
    pub(crate) fn gltf(&mut self, frame: &Frame, seams: &[Option<Arc<Seams>>], textures: &[Option<Arc<Vec<u8>>>]) {
        for (index, body) in frame.bodies.iter().enumerate() {
            let texture = textures.get(index).and_then(Option::as_ref).map(|bytes| &bytes[..]);
            let path = self.folder.join(format!("surface-{index}.glb"));
            let textured = textured(body, seams.get(index));
            if let Err(error) = gltf::write_textured_gltf(&path, body, texture, textured.as_deref()) {
                self.fault("surfaces as glTF", error.to_string());
            }
        }
    }

    /// Notes what could not be written. The first time of its kind it is to be reported.
    pub(crate) fn fault(&mut self, kind: &'static str, what: String) {
        if !self.faults.contains_key(kind) {
            self.untold.push(what.clone());
            self.faults.insert(kind, what);
        }
    }

    /// What could not be written is there now, whole.
    pub(crate) fn mended(&mut self, kind: &'static str) {
        self.faults.remove(kind);
    }

    /// Faults that nobody has been told of.
    pub(crate) fn untold(&mut self) -> Vec<String> {
        std::mem::take(&mut self.untold)
    }

    /// Tries once more to write what waits, and tells what is lost.
    pub(crate) fn lasting_faults(&mut self) -> Vec<String> {
        for name in ["series.csv", "events.jsonl"] {
            let journal = if name == "series.csv" { &mut self.series } else { &mut self.events };
            let written = journal.write();
            self.note_journal(name, written);
        }
        self.faults.values().cloned().collect()
    }
}

/// An event as a line of JSON. Points are in the rest shape.
fn described(step: u64, body: &str, event: &Event) -> Value {
    let point = |p: &DVec3| json!(p.to_array());
    let key = |tip: &rhexis::storage::TipKey| json!(format!("{:?}", tip.data()));
    let mut line = match &event.kind {
        EventKind::Started { tip, at, verdict: None } => {
            json!({ "kind": "started", "tip": key(tip), "at_mm": point(at) })
        }
        // A margin without a runner-up is infinite, which JSON writes as null.
        EventKind::Started { tip, at, verdict: Some(Verdict { criterion, margin, is_ambiguous }) } => json!({
            "kind": "started", "tip": key(tip), "at_mm": point(at),
            "criterion": criterion, "margin": margin, "is_ambiguous": is_ambiguous,
        }),
        EventKind::Advanced {
            tip,
            from,
            to,
            direction,
            criterion,
            margin,
            is_ambiguous,
            by,
            release,
            cost,
            course,
        } => {
            json!({
                "kind": "advanced", "tip": key(tip), "from_mm": point(from), "to_mm": point(to),
                "direction": point(direction), "criterion": criterion, "margin": margin, "is_ambiguous": is_ambiguous,
                "decided_by": by.to_string(), "release_n_per_mm": release, "course": course.to_string(),
                "torn_area_mm2": cost.map(|cost| cost.area), "overshoot": cost.map(|cost| cost.overshoot),
                "surface_energy_mj": cost.map(|cost| cost.surface_energy()),
            })
        }
        EventKind::Released { energy, length } => {
            json!({ "kind": "released", "energy_mj": energy, "length_mm": length })
        }
        EventKind::Ended { tip, at, .. } => json!({ "kind": "ended", "tip": key(tip), "at_mm": point(at) }),
        EventKind::Cut { asked, made, strokes } => {
            json!({ "kind": "cut", "asked_mm": asked, "made_mm": made, "strokes": strokes })
        }
        EventKind::FragmentFreed { triangle_count } => json!({ "kind": "fragment_freed", "triangles": triangle_count }),
        EventKind::Renewed { tip, at, by } => {
            json!({ "kind": "renewed", "tip": key(tip), "at_mm": point(at), "by": by.to_string() })
        }
        EventKind::Parted { at, value, by } => {
            json!({ "kind": "parted", "at_mm": point(at), "value": value, "by": by.to_string() })
        }
        EventKind::HeldShut { at } => json!({ "kind": "held_shut", "at_mm": point(at) }),
        EventKind::UnderResolved { tip, at, edges_per_radius } => json!({
            "kind": "under_resolved", "tip": key(tip), "at_mm": point(at), "edges_per_radius": edges_per_radius,
        }),
        EventKind::HeldBack { tip, at, criterion } => {
            json!({ "kind": "held_back", "tip": key(tip), "at_mm": point(at), "criterion": criterion })
        }
        EventKind::NucleationBlocked(BlockedNucleation { at, criterion, length, release, toughness }) => json!({
            "kind": "nucleation_blocked", "at_mm": point(at), "criterion": criterion, "length_mm": length,
            "release_n_per_mm": release, "toughness_n_per_mm": toughness,
        }),
        EventKind::Refused { tip, at, reason } => {
            json!({ "kind": "refused", "tip": tip.as_ref().map(key), "at_mm": point(at), "reason": reason })
        }
        EventKind::Slipped { jaws, force, is_open } => {
            json!({ "kind": "slipped", "jaws": jaws, "force_n": force, "is_open": is_open })
        }
        EventKind::FellAsleep => json!({ "kind": "fell_asleep" }),
        EventKind::Woke { by } => json!({ "kind": "woke", "by": by.to_string() }),
        EventKind::StepGuarded { refused, limited, limited_vertices, first } => json!({
            "kind": "step_guarded", "refused": refused, "limited": limited, "limited_vertices": limited_vertices,
            "cause": first.map(|place| place.cause.to_string()), "at_mm": first.map(|place| point(&place.at)),
            "triangle": first.and_then(|place| place.triangle), "vertex": first.and_then(|place| place.vertex),
            "energy_mj": first.map(|place| place.energy),
        }),
        EventKind::StepFailed { reason } => json!({ "kind": "step_failed", "reason": reason }),
        // Of a newer engine.
        other => json!({ "kind": "other", "detail": format!("{other:?}") }),
    };
    if let Value::Object(fields) = &mut line {
        fields.insert("step".to_owned(), json!(step));
        fields.insert("time_ms".to_owned(), json!(event.time));
        fields.insert("body".to_owned(), json!(body));
    }
    line
}

/// The texture coordinates of the corners of a body's triangles, where its texture has seams.
fn textured(body: &BodyFrame, seams: Option<&Option<Arc<Seams>>>) -> Option<Vec<[[f64; 2]; 3]>> {
    let seams = seams.and_then(Option::as_ref)?;
    Some(seams.textured(&body.rest_positions, &body.triangles))
}

#[cfg(test)]
mod tests {
    use super::numbered;

    #[test]
    fn only_names_that_a_run_gives_are_taken_away() {
        let own = [
            ("picture-0-000012.png", (0, 12)),
            ("picture-12-1234567.png", (0, 1_234_567)),
            ("frames-0-my-tissue-000012.vtu", (1, 12)),
        ];
        for (name, found) in own {
            assert_eq!(numbered(name), Some(found), "{name}");
        }
        for name in
            ["picture.png", "picture-0-12.png", "picture-a-000012.png", "frames.pvd", "frames-0-a.vtu", "mine.vtu"]
        {
            assert_eq!(numbered(name), None, "{name}");
        }
    }
}

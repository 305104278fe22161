//! The files that a run writes as it goes on. Each row is flushed, each whole file renamed into place: an interrupted run
//! leaves what it had.

use super::moments::Moments;
use super::report::RunReport;
use super::series::Observation;
use super::{Stop, checkpoint};
use crate::event::{Event, EventKind, Verdict};
use crate::frame::Frame;
use crate::output::{OutputError, PictureSettings, PvdWriter, file, render};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use slotmap::Key;
use std::fs::File;
use std::io::{Seek, Write};
use std::path::{Path, PathBuf};

/// The output directory and its open files.
pub(super) struct Files {
    folder: PathBuf,
    title: String,
    series: csv::Writer<File>,
    events: File,
    frames: Option<PvdWriter>,
    picture_moments: Moments,
    frame_moments: Moments,
    last_frame: Option<u64>,
    last_picture: Option<u64>,
    /// Pictures that could not be drawn.
    pub notes: Vec<String>,
}

fn cannot_write(path: &Path, error: impl std::fmt::Display) -> Stop {
    Stop::Failed(format!("cannot write {}: {error}; choose another directory with --out", path.display()))
}

/// Takes away the pictures and frames of an earlier run: beside those of a shorter one they would tell of another tear.
fn remove_earlier(folder: &Path) -> std::io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        if is_numbered(&entry.file_name().to_string_lossy()) && entry.file_type()?.is_file() {
            std::fs::remove_file(entry.path())?;
        }
    }
    Ok(())
}

/// Whether a file has a name that a run gives: `picture-0-000012.png`, `frames-0-tissue-000012.vtu`.
fn is_numbered(name: &str) -> bool {
    let is_number = |word: &str, least: usize| word.len() >= least && word.bytes().all(|b| b.is_ascii_digit());
    let stem = |kind: &str, extension: &str| {
        let (first, rest) = name.strip_prefix(kind)?.strip_suffix(extension)?.split_once('-')?;
        let last = rest.rsplit('-').next()?;
        Some(is_number(first, 1) && is_number(last, 6))
    };
    stem("picture-", ".png").or_else(|| stem("frames-", ".vtu")).unwrap_or(false)
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
    pub fn resume(folder: &Path, title: &str, moments: [Moments; 2], marks: &Marks) -> Result<Self, Stop> {
        let [picture_moments, frame_moments] = moments;
        let open = |name: &str, length: u64| {
            let path = folder.join(name);
            let file = File::options().write(true).open(&path).and_then(|mut file| {
                if file.metadata()?.len() < length {
                    return Err(std::io::Error::other("it is shorter than it was"));
                }
                file.set_len(length)?;
                file.seek(std::io::SeekFrom::End(0))?;
                Ok(file)
            });
            file.map_err(|error| Stop::Failed(format!("cannot go on with {}: {error}", path.display())))
        };
        let has_frames = frame_moments.count > 0;
        let frames = has_frames.then(|| PvdWriter::resume(&folder.join("frames.pvd"), &marks.entries)).transpose()?;
        Ok(Self {
            folder: folder.to_owned(),
            title: title.to_owned(),
            series: csv::Writer::from_writer(open("series.csv", marks.lengths[0])?),
            events: open("events.jsonl", marks.lengths[1])?,
            frames,
            picture_moments,
            frame_moments,
            last_frame: marks.last_frame,
            last_picture: marks.last_picture,
            notes: marks.notes.clone(),
        })
    }

    /// Where the files stand.
    pub fn marks(&self) -> Result<Marks, Stop> {
        let length = |file: &File| file.metadata().map(|data| data.len());
        let lengths = length(self.series.get_ref()).and_then(|series| Ok([series, length(&self.events)?]));
        let lengths = lengths.map_err(|error| cannot_write(&self.folder, error))?;
        let entries = self.frames.as_ref().map_or("", PvdWriter::entries).to_owned();
        let &Self { last_frame, last_picture, ref notes, .. } = self;
        Ok(Marks { lengths, entries, last_frame, last_picture, notes: notes.clone() })
    }

    /// Makes the directory and begins the files.
    pub fn create(folder: &Path, title: &str, pictures: Moments, frames: Moments) -> Result<Self, Stop> {
        std::fs::create_dir_all(folder).map_err(|error| cannot_write(folder, error))?;
        let open = |name: &str| {
            let path = folder.join(name);
            File::create(&path).map_err(|error| cannot_write(&path, error))
        };
        checkpoint::remove(folder)?;
        remove_earlier(folder).map_err(|error| cannot_write(folder, error))?;
        let frame_list = if frames.count > 0 { Some(PvdWriter::create(&folder.join("frames.pvd"))?) } else { None };
        Ok(Self {
            folder: folder.to_owned(),
            title: title.to_owned(),
            series: csv::Writer::from_writer(open("series.csv")?),
            events: open("events.jsonl")?,
            frames: frame_list,
            picture_moments: pictures,
            frame_moments: frames,
            last_frame: None,
            last_picture: None,
            notes: Vec::new(),
        })
    }

    /// Whether the state after `step` steps is to be drawn or written as a frame; `is_special` states are, whatever the
    /// moments say.
    pub fn wants_frame(&self, step: u64, is_special: bool) -> bool {
        [self.picture_moments, self.frame_moments].iter().any(|m| m.is_due(step) || (is_special && m.count > 0))
    }

    /// The state after a step: its pictures and frames, where they are due or it `is_special`.
    pub fn frame(&mut self, frame: &Frame, step: u64, tears: u64, is_special: bool) -> Result<(), Stop> {
        let due = |moments: Moments| moments.is_due(step) || (is_special && moments.count > 0);
        if due(self.frame_moments)
            && self.last_frame.replace(step) != Some(step)
            && let Some(list) = &mut self.frames
        {
            list.write_frame(frame)?;
        }
        if due(self.picture_moments) && self.last_picture.replace(step) != Some(step) {
            for (index, body) in frame.bodies.iter().enumerate() {
                let path = self.folder.join(format!("picture-{index}-{step:06}.png"));
                let settings = PictureSettings::titled(&self.title, frame.time, step, tears as usize);
                match render(&path, body, &settings) {
                    Err(OutputError::Content { what, .. }) => {
                        self.notes.push(format!("{}: no picture: {what}", body.name))
                    }
                    other => other?,
                }
            }
        }
        Ok(())
    }

    /// A row of `series.csv`, after its header if it is the first.
    pub fn row(&mut self, o: &Observation, is_first: bool) -> Result<(), Stop> {
        let path = self.folder.join("series.csv");
        let header = if is_first { self.series.write_record(o.header()) } else { Ok(()) };
        let written = header.and_then(|()| self.series.write_record(o.row()));
        written.map_err(|error| cannot_write(&path, error))?;
        self.series.flush().map_err(|error| cannot_write(&path, error))
    }

    /// A line of `events.jsonl`.
    pub fn event(&mut self, step: u64, body: &str, event: &Event) -> Result<(), Stop> {
        let line = format!("{}\n", described(step, body, event));
        self.events.write_all(line.as_bytes()).map_err(|error| cannot_write(&self.folder.join("events.jsonl"), error))
    }

    /// `report.json`, replacing the last one.
    pub fn report(&self, report: &RunReport) -> Result<(), Stop> {
        let mut text = serde_json::to_string_pretty(report).map_err(|error| Stop::Failed(error.to_string()))?;
        text.push('\n');
        Ok(file::replace(&self.folder.join("report.json"), text.as_bytes())?)
    }
}

/// An event as a line of JSON. Points are in the rest shape.
fn described(step: u64, body: &str, event: &Event) -> Value {
    let point = |p: &DVec3| json!(p.to_array());
    let key = |tip: &crate::storage::TipKey| json!(format!("{:?}", tip.data()));
    let mut line = match &event.kind {
        EventKind::Started { tip, at, verdict: None } => {
            json!({ "kind": "started", "tip": key(tip), "at_mm": point(at) })
        }
        // A margin without a runner-up is infinite, which JSON writes as null.
        EventKind::Started { tip, at, verdict: Some(Verdict { criterion, margin, is_ambiguous }) } => json!({
            "kind": "started", "tip": key(tip), "at_mm": point(at),
            "criterion": criterion, "margin": margin, "is_ambiguous": is_ambiguous,
        }),
        EventKind::Advanced { tip, from, to, direction, criterion, margin, is_ambiguous, by, course } => json!({
            "kind": "advanced", "tip": key(tip), "from_mm": point(from), "to_mm": point(to),
            "direction": point(direction), "criterion": criterion, "margin": margin, "is_ambiguous": is_ambiguous,
            "decided_by": by.to_string(), "course": course.to_string(),
        }),
        EventKind::Released { energy, length } => {
            json!({ "kind": "released", "energy_mj": energy, "length_mm": length })
        }
        EventKind::Ended { tip, at, .. } => json!({ "kind": "ended", "tip": key(tip), "at_mm": point(at) }),
        EventKind::PieceFreed { triangle_count } => json!({ "kind": "piece_freed", "triangles": triangle_count }),
        EventKind::HeldShut { at } => json!({ "kind": "held_shut", "at_mm": point(at) }),
        EventKind::UnderResolved { tip, at, edges_per_radius } => json!({
            "kind": "under_resolved", "tip": key(tip), "at_mm": point(at), "edges_per_radius": edges_per_radius,
        }),
        EventKind::Refused { tip, at, reason } => {
            json!({ "kind": "refused", "tip": tip.as_ref().map(key), "at_mm": point(at), "reason": reason })
        }
        EventKind::Slipped { jaws, force, is_open } => {
            json!({ "kind": "slipped", "jaws": jaws, "force_n": force, "is_open": is_open })
        }
        EventKind::FellAsleep => json!({ "kind": "fell_asleep" }),
        EventKind::Woke { by } => json!({ "kind": "woke", "by": by.to_string() }),
        EventKind::StepFailed { reason } => json!({ "kind": "step_failed", "reason": reason }),
    };
    if let Value::Object(fields) = &mut line {
        fields.insert("step".to_owned(), json!(step));
        fields.insert("time_ms".to_owned(), json!(event.time));
        fields.insert("body".to_owned(), json!(body));
    }
    line
}

#[cfg(test)]
mod tests {
    use super::is_numbered;

    #[test]
    fn only_names_that_a_run_gives_are_taken_away() {
        for name in ["picture-0-000012.png", "picture-12-1234567.png", "frames-0-my-tissue-000012.vtu"] {
            assert!(is_numbered(name), "{name}");
        }
        for name in
            ["picture.png", "picture-0-12.png", "picture-a-000012.png", "frames.pvd", "frames-0-a.vtu", "mine.vtu"]
        {
            assert!(!is_numbered(name), "{name}");
        }
    }
}

//! The list of a run's ParaView files (.pvd): which file shows which body at which time.

use super::{OutputError, file, write_solids, write_vtu};
use rhexis::frame::Frame;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Name of the part with obstacles and jaws.
pub(crate) const SOLIDS: &str = "solids";

/// Writes a .pvd file and, if wished, the .vtu files it lists.
///
/// The list is whole after every [`append`](Self::append): an interrupted run keeps all frames up to the interruption.
#[derive(Debug)]
pub struct PvdWriter {
    path: PathBuf,
    entries: String,
}

impl PvdWriter {
    /// Starts an empty list at `path` (which should end in `.pvd`), replacing an older one.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn create(path: &Path) -> Result<Self, OutputError> {
        let writer = Self { path: path.to_owned(), entries: String::new() };
        writer.save()?;
        Ok(writer)
    }

    /// Goes on with a list that was interrupted, at the entries that it had.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn resume(path: &Path, entries: &str) -> Result<Self, OutputError> {
        let writer = Self { path: path.to_owned(), entries: entries.to_owned() };
        writer.save()?;
        Ok(writer)
    }

    /// The entries so far, to go on with them.
    pub fn entries(&self) -> &str {
        &self.entries
    }

    /// Adds the files of one moment, one part per body in the order given. `time` in \[ms\].
    ///
    /// # Errors
    /// The list cannot be written, or `time` is not finite.
    pub fn append(&mut self, time: f64, parts: &[(&str, &Path)]) -> Result<(), OutputError> {
        if !time.is_finite() {
            return Err(OutputError::content(&self.path, format!("the time of a frame is {time}; it must be finite")));
        }
        let folder = self.path.parent().unwrap_or(Path::new(""));
        for (part, (name, path)) in parts.iter().enumerate() {
            let path =
                path.strip_prefix(folder).unwrap_or(path).to_string_lossy().replace(std::path::MAIN_SEPARATOR, "/");
            // Writing to a String cannot fail.
            let _ = writeln!(
                self.entries,
                r#"    <DataSet timestep="{time}" part="{part}" name="{}" file="{}"/>"#,
                escape(name),
                escape(&path)
            );
        }
        self.save()
    }

    /// Writes one .vtu per body beside the list, named after list, body and step, and one for obstacles and jaws where there are any, and appends them.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn write_frame(&mut self, frame: &Frame) -> Result<Vec<PathBuf>, OutputError> {
        let stem = self.path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let mut files = Vec::with_capacity(frame.bodies.len());
        for (index, body) in frame.bodies.iter().enumerate() {
            // The index keeps two bodies of one name apart.
            let name = format!("{stem}-{index}-{}-{:06}.vtu", plain(&body.name), frame.step);
            let path = self.path.with_file_name(name);
            write_vtu(&path, body)?;
            files.push(path);
        }
        let mut parts: Vec<(&str, &Path)> =
            frame.bodies.iter().zip(&files).map(|(body, path)| (body.name.as_str(), path.as_path())).collect();
        let solids = self.path.with_file_name(format!("{stem}-{}-{SOLIDS}-{:06}.vtu", files.len(), frame.step));
        if !frame.solids.is_empty() {
            write_solids(&solids, &frame.solids)?;
            parts.push((SOLIDS, &solids));
        }
        self.append(frame.time, &parts)?;
        if !frame.solids.is_empty() {
            files.push(solids);
        }
        Ok(files)
    }

    fn save(&self) -> Result<(), OutputError> {
        let text = format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n  <Collection>\n{}  </Collection>\n</VTKFile>\n",
            self.entries
        );
        file::replace(&self.path, text.as_bytes())
    }
}

fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            // Control characters cannot be written in XML 1.0 at all.
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

/// A name that is safe in a file name on every system.
fn plain(name: &str) -> String {
    let kept: String = name
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() || c == '-' || c == '_' { c } else { '_' })
        .take(60)
        .collect();
    if kept.is_empty() { "body".to_owned() } else { kept }
}

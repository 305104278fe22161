//! The files that a run reads, and that nothing it writes takes their place.

use super::files::is_own_name;
use super::{RunArgs, Stop, dump};
use rhexis::internal::{fingerprint, source};
use rhexis_scene::{Scene, mesh_file};
use std::path::{Path, PathBuf};

/// The scene file and what it mentions.
pub(super) struct Inputs {
    scene: Option<PathBuf>,
    data: Vec<PathBuf>,
}

impl Inputs {
    pub(crate) fn of(scene: &Scene) -> Self {
        Self { scene: scene.path().map(Path::to_owned), data: scene.data_files() }
    }

    /// Hashes of what the mesh and fibre files hold, in their order.
    pub(crate) fn hashes(&self) -> Result<Vec<u64>, Stop> {
        let hash = |path: &PathBuf| {
            let bytes = source::read(path, mesh_file::MOST_BYTES);
            bytes.map(|bytes| fingerprint(&bytes)).map_err(|error| {
                Stop::Failed(format!("cannot read {}: {error}; check the path and the permissions", path.display()))
            })
        };
        self.data.iter().map(hash).collect()
    }

    /// The first mesh or fibre file that has another hash.
    pub(crate) fn first_changed(&self, hashes: &[u64]) -> Result<Option<&Path>, Stop> {
        let now = self.hashes()?;
        let changed = (0..now.len()).find(|&i| hashes.get(i) != Some(&now[i]));
        Ok(changed.map(|i| self.data[i].as_path()))
    }

    /// Refuses outputs in the place of a file that is read. Nothing is written yet.
    pub(crate) fn spare(&self, args: &RunArgs, out: &Path) -> Result<(), Stop> {
        if out.exists() && !out.is_dir() {
            let what = format!("{} is a file, not a directory", out.display());
            return Err(Stop::Failed(format!("{what}; choose a directory with --out")));
        }
        // What would be overwritten or taken away is there already.
        let entries = std::fs::read_dir(out).into_iter().flatten().filter_map(Result::ok).map(|entry| entry.path());
        let own = |path: &PathBuf| path.file_name().is_some_and(|name| is_own_name(&name.to_string_lossy()));
        let mut outputs: Vec<(PathBuf, &str)> = entries.filter(own).map(|path| (path, "--out")).collect();
        if let Some(folder) = &args.dump {
            outputs.extend(dump::NAMES.map(|name| (folder.join(name), "--dump")));
        }
        if let Some(record) = &args.record {
            outputs.extend([record.clone(), part_of(record)].map(|path| (path, "--record")));
        }
        for (output, option) in &outputs {
            if let Some(input) = self.scene.iter().chain(&self.data).find(|input| is_same(input, output)) {
                let [output, input] = [output, input].map(|path| path.display());
                return Err(Stop::Failed(format!(
                    "the run would overwrite {output}, which it reads as {input}; choose another place with {option}"
                )));
            }
        }
        Ok(())
    }
}

/// The file beside a whole one from which it is renamed.
pub(super) fn part_of(path: &Path) -> PathBuf {
    let mut part = path.as_os_str().to_owned();
    part.push(".part");
    part.into()
}

/// Whether two paths lead to one file, by links too.
#[cfg(unix)]
fn is_same(a: &Path, b: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let place = |path: &Path| std::fs::metadata(path).ok().map(|data| (data.dev(), data.ino()));
    place(a).is_some_and(|place_of_a| place(b) == Some(place_of_a))
}

/// Whether two paths lead to one file.
#[cfg(not(unix))]
fn is_same(a: &Path, b: &Path) -> bool {
    let place = |path: &Path| path.canonicalize().ok();
    place(a).is_some_and(|place_of_a| place(b) == Some(place_of_a))
}

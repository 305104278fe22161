//! [rhexis]: rhexis
//! [schema]: schema
//! [measures]: measures
#![doc = include_str!("../README.md")]
#![cfg_attr(not(test), warn(clippy::disallowed_methods, unreachable_pub))]
#![cfg_attr(not(test), warn(clippy::expect_used, clippy::panic, clippy::unreachable, clippy::unwrap_used))]

mod beginning;
mod breaking;
mod build;
pub mod catalog;
mod changing;
mod compartment;
mod copies;
pub mod course;
mod doctor;
mod document;
mod doubts;
mod error;
mod fibre_field;
mod fibre_law;
mod files;
pub mod generate;
mod grasp;
mod held;
mod instance;
pub mod measures;
pub mod mesh_file;
mod mesh_on_file;
mod obstacle;
pub mod output;
pub mod patch;
mod per_triangle;
mod probes;
mod region;
mod renamed;
pub mod schema;
pub mod score;
mod seams;
mod sets;
mod settings;
mod shape;
mod size;
mod springs;
mod summary;
mod table_file;
mod texture;
mod timed;

pub use doctor::MeshSummary;
pub use document::Document;
pub use error::{SceneError, nearest};
pub use instance::thresholds;
pub use instance::{Instance, MOST_STEPS, Run};
pub use probes::{Probe, ProbeKind};
pub use seams::Seams;
pub use summary::{BodySummary, Summary};
pub use timed::CutTold;

use error::Span;
use schema::SceneFile;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A scene that follows the schema; [`check`](Self::check) judges it, [`instantiate`](Self::instantiate) builds it.
#[derive(Clone, Debug)]
pub struct Scene {
    file: SceneFile,
    document: Document,
    spans: BTreeMap<String, Span>,
    /// Files of curves and paths.
    tables: Vec<PathBuf>,
}

impl Scene {
    /// A scene from text; `origin` names it in errors.
    ///
    /// # Errors
    /// Where the text is not TOML or does not follow the schema.
    pub fn parse(text: &str, origin: &str) -> Result<Self, SceneError> {
        Document::new(text, origin).scene()
    }

    /// A scene from a file.
    ///
    /// # Errors
    /// If it cannot be read, is not TOML or does not follow the schema.
    pub fn load(path: &Path) -> Result<Self, SceneError> {
        Document::load(path)?.scene()
    }

    /// A scene of the catalog.
    ///
    /// # Errors
    /// If there is none of that name.
    pub fn named(name: &str) -> Result<Self, SceneError> {
        Document::named(name)?.scene()
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.file.scene.name
    }

    /// One sentence about it.
    pub fn about(&self) -> &str {
        &self.file.scene.about
    }

    /// A number that tells it from other scenes, as they are with their changes.
    pub fn fingerprint(&self) -> u64 {
        rhexis::internal::fingerprint(format!("{:?}", self.file).as_bytes())
    }

    /// The scene file, where it is from one.
    pub fn path(&self) -> Option<&Path> {
        self.document.file()
    }

    /// Files of curves, meshes with the buffers of glTF, fibres, values per triangle, textures and the scoring that it reads, each once, but
    /// for those given with its text.
    pub fn data_files(&self) -> Vec<PathBuf> {
        let sources = self.document.files();
        let mut files: Vec<PathBuf> = self.tables.iter().map(|table| sources.path(table)).collect();
        let mesh = |path: &Path| {
            let all = std::iter::once(path.to_owned()).chain(mesh_file::beside(&sources, path));
            all.map(|path| sources.path(&path)).collect::<Vec<_>>()
        };
        for body in &self.file.bodies {
            if let schema::MeshSpec::File(file) = &body.mesh {
                files.extend(mesh(&file.path));
            }
            if let Some(schema::FibreSpec::File(file)) = &body.fibres {
                files.push(sources.path(file));
            }
            files.extend(body.texture.iter().map(|texture| sources.path(texture)));
            let per_triangle = body.per_triangle.iter().flat_map(|values| values.given());
            files.extend(per_triangle.filter_map(|(_, values)| match values {
                schema::Values::File(file) => Some(sources.path(file)),
                _ => None,
            }));
        }
        for obstacle in &self.file.obstacles {
            if let Some(schema::MeshSpec::File(file)) = &obstacle.mesh {
                files.extend(mesh(&file.path));
            }
        }
        let scoring = self.file.output.scoring.iter().filter(|scoring| !score::Scoring::is_named(scoring));
        files.extend(scoring.map(|scoring| sources.path(scoring)));
        files.retain(|file| !sources.is_given(file));
        files.sort();
        files.dedup();
        files
    }

    /// What the file says.
    pub fn file(&self) -> &SceneFile {
        &self.file
    }
}

//! Mesh files: Wavefront OBJ, Gmsh, VTK, PLY and STL surfaces, and fibre directions as plain text.
//!
//! One rule for all formats: triangles are taken, other flat polygons are cut into triangles (a fan about their first corner),
//! points and lines are ignored, curved or solid elements are refused. Vertices that no triangle uses are dropped and triangles
//! turned over where that makes their neighbours agree; the result has passed [`TriangleMesh::check`].
//!
//! No reader allocates by what a header claims: counts are held against the size of the file first.

mod fault;
mod fibres;
mod gmsh;
mod obj;
mod ply;
mod stl;
mod surface;
mod vtk_legacy;
mod vtk_xml;

use std::io;
use std::path::{Path, PathBuf};

use glam::DVec3;

use crate::source;
use crate::storage::{MeshError, TriangleMesh};
use fault::Fault;

/// The extensions [`read`] knows, in any case of letters.
pub const EXTENSIONS: [&str; 6] = ["obj", "msh", "vtu", "vtk", "ply", "stl"];

/// The largest mesh or fibre file that is read \[bytes\]: ten times what the largest mesh of a scene takes as text.
pub const MOST_BYTES: u64 = 1 << 30;

/// Why a mesh or fibre file is refused.
#[derive(Debug, thiserror::Error)]
pub enum MeshFileError {
    /// The file cannot be read.
    #[error("cannot read {}: {source}; check the path and the permissions", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
    /// The format is not known.
    #[error("{}: unknown mesh format; save the mesh as one of .{}", path.display(), EXTENSIONS.join(", ."))]
    UnsupportedExtension {
        /// The file.
        path: PathBuf,
    },
    /// The file does not follow its format.
    #[error("{}{}: {what}", path.display(), line.map(|line| format!(":{line}")).unwrap_or_default())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Line, counted from 1, where the format has lines.
        line: Option<usize>,
        /// What is wrong and how to mend it.
        what: String,
    },
    /// The file is well formed, but its surface cannot be used. Vertices are counted without those that no triangle uses.
    #[error("{}: {error}", path.display())]
    Mesh {
        /// The file.
        path: PathBuf,
        /// What is wrong with the surface.
        #[source]
        error: MeshError,
    },
}

/// Reads a surface; the format follows from the extension, one of [`EXTENSIONS`]. Coordinates are taken as mm.
///
/// In VTK files a cell array `fibre` with three components gives the fibres.
///
/// # Errors
/// Where the file cannot be read, and as [`from_bytes`].
pub fn read(path: &Path) -> Result<TriangleMesh, MeshFileError> {
    // Known before a file of any size is read.
    format(path)?;
    from_bytes(path, bytes(path)?)
}

/// The surface that a file of this name and content holds: for meshes from an archive or a network. `name` gives the format and
/// stands in errors; nothing is opened. Bytes from anywhere may be given: memory is bounded by a multiple of their number.
///
/// # Errors
/// Where the extension is not one of [`EXTENSIONS`], the bytes do not follow the format, or the surface fails
/// [`TriangleMesh::check`].
pub fn from_bytes(name: &Path, bytes: Vec<u8>) -> Result<TriangleMesh, MeshFileError> {
    let mesh = format(name)?(bytes).map_err(|fault| malformed(name, fault))?;
    tidy(mesh).map_err(|error| MeshFileError::Mesh { path: name.into(), error })
}

/// Reads the bytes of one format.
type Format = fn(Vec<u8>) -> Result<TriangleMesh, Fault>;

fn format(path: &Path) -> Result<Format, MeshFileError> {
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase()).unwrap_or_default();
    match extension.as_str() {
        "obj" => Ok(obj::parse),
        "msh" => Ok(gmsh::parse),
        "vtu" => Ok(vtk_xml::parse),
        "vtk" => Ok(vtk_legacy::parse),
        "ply" => Ok(ply::parse),
        "stl" => Ok(stl::parse),
        _ => Err(MeshFileError::UnsupportedExtension { path: path.into() }),
    }
}

/// Reads fibre directions for the triangles of a mesh in their order: three numbers a line, with spaces, commas or semicolons
/// between; empty lines and what follows a `#` are skipped.
pub fn read_fibres(path: &Path) -> Result<Vec<DVec3>, MeshFileError> {
    fibres::parse(bytes(path)?).map_err(|fault| malformed(path, fault))
}

fn bytes(path: &Path) -> Result<Vec<u8>, MeshFileError> {
    source::read(path, MOST_BYTES).map_err(|source| MeshFileError::Unreadable { path: path.into(), source })
}

fn malformed(path: &Path, Fault { line, what }: Fault) -> MeshFileError {
    MeshFileError::Malformed { path: path.into(), line, what }
}

fn tidy(mesh: TriangleMesh) -> Result<TriangleMesh, MeshError> {
    if mesh.triangles.is_empty() {
        return Err(MeshError::Empty("triangles"));
    }
    // Corners out of range are named by the numbers of the file: before vertices are dropped.
    let mesh = mesh.oriented()?.without_unused_vertices();
    mesh.check()?;
    Ok(mesh)
}

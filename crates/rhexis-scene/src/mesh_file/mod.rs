//! Mesh files: OBJ, Gmsh, VTK, PLY, STL, OFF and glTF surfaces, and fibre directions as plain text.
//!
//! One rule for all formats: triangles are taken, other polygons filled with triangles, points and lines ignored, curved or solid
//! elements refused. Vertices that no triangle uses are dropped and triangles turned over where that makes their neighbours agree: in
//! each piece those that are fewer, in a closed one those that face inwards. The result has passed [`TriangleMesh::check`].
//!
//! No reader allocates by what a header claims: counts are held against the size of the file first.

mod decoration;
mod defects;
mod draft;
mod encoding;
mod fault;
mod fibres;
mod finish;
mod gltf;
mod gmsh;
mod gmsh_old;
mod gmsh_scan;
mod hanging;
mod obj;
mod off;
mod ply;
mod ply_columns;
mod polygon;
mod stl;
mod vtk_legacy;
mod vtk_xml;
mod weld;

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;

use super::files::Files;
pub use defects::Defects;
pub use draft::{Array, On};
use draft::{Draft, Wanted};
use fault::Fault;
use finish::{Refusal, finish};
pub(crate) use hanging::{Hanging, ends, hanging};
use rhexis::components::Attributes;
use rhexis::internal::source;
use rhexis::storage::{MeshError, TriangleMesh};
pub(crate) use weld::coincident;

/// The extensions [`read`] knows, in any case of letters.
pub const EXTENSIONS: [&str; 10] = ["obj", "msh", "vtu", "vtk", "ply", "stl", "vtp", "off", "glb", "gltf"];

/// Maximum size of a mesh or fibre file, and of all files of a scene together \[bytes\]: ten times the text of the largest mesh.
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
    /// The surface has defects that [`Reading::repair`] mends.
    #[error("{}: {}; clean the mesh, or give `repair = true` to drop and split them", path.display(), defects.text())]
    Defects {
        /// The file.
        path: PathBuf,
        /// All of them, counted.
        defects: Defects,
    },
}

/// How a mesh file is read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reading {
    /// Millimetres per unit of the file, in place of those of the format: glTF is in metres, other formats are taken in mm.
    pub scale: Option<f64>,
    /// Vertices so close \[units of the file\] become one. By itself STL and glTF join what rounding tells apart.
    pub weld: Option<f64>,
    /// Whether triangles without area, double ones and those beyond two at an edge are dropped, bowties split, vertices on an edge of
    /// another triangle split in, and polygons that cross themselves filled all the same.
    pub repair: bool,
    /// Whether all triangles are turned over in the end.
    pub flip: bool,
    /// The array of the fibres, where its name is no usual one (fibre, fiber, fibres, fibers, f0, in any case of letters).
    pub fibres: Option<String>,
    /// Names of other arrays to be kept.
    pub arrays: Vec<String>,
}

/// What was done to a surface to make it one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tidied {
    /// Vertices joined to another.
    pub joined: usize,
    /// Triangles turned over.
    pub turned: usize,
    /// What was dropped and split.
    pub defects: Defects,
}

/// A surface with what its file says of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshFile {
    /// The surface, its fibres included.
    pub mesh: TriangleMesh,
    /// Arrays that were asked for, with a row for each vertex or triangle.
    pub arrays: Vec<Array>,
    /// Names of arrays that nobody asked for.
    pub passed_over: Vec<String>,
    /// Vertices by names: physical groups of Gmsh, groups and objects of OBJ, nodes and meshes of glTF.
    pub groups: Vec<(String, Vec<u32>)>,
    /// Texture coordinates, normals and colours of its vertices, each where every vertex has one; of several sets of a kind the first, and
    /// `passed_over` names the others.
    pub attributes: Option<Attributes>,
    /// Vertices with several texture coordinates in the file, of which `attributes` have the first.
    pub seams: usize,
    /// The texture coordinates of the corners of triangles, where such vertices are.
    pub textured: Option<Vec<[[f64; 2]; 3]>>,
    /// Where the fibres come from, in words, if the file has any.
    pub fibres_from: Option<String>,
    /// What was mended.
    pub tidied: Tidied,
    /// The number of each triangle among those of the file, before any was dropped or split.
    pub rows: Vec<u32>,
    /// Triangles of the file, before any was dropped or split.
    pub triangles_of_file: usize,
}

impl MeshFile {
    /// Its arrays in words.
    pub fn array_names(&self) -> String {
        let kept = self.arrays.iter().map(|array| &array.name);
        let names: Vec<String> = kept.chain(&self.passed_over).map(|name| format!("{name:?}")).collect();
        if names.is_empty() { "it has no arrays".into() } else { format!("it has {}", names.join(", ")) }
    }

    /// The array of this name.
    ///
    /// # Errors
    /// In words, where there is no such array.
    pub(crate) fn array(&self, name: &str) -> Result<&Array, String> {
        let array = self.arrays.iter().find(|array| array.name == name);
        array.ok_or_else(|| format!("the mesh has no array {name:?}: {}", self.array_names()))
    }

    /// The numbers of the array of this name for each triangle, by rows, with how many they are a row: points are averaged.
    ///
    /// # Errors
    /// In words, where there is no such array.
    pub fn per_triangle(&self, name: &str) -> Result<(Vec<f64>, usize), String> {
        let array = self.array(name)?;
        let components = array.components;
        let at = |row: u32, component: usize| array.values[row as usize * components + component];
        let values = match array.on {
            On::Cells => array.values.clone(),
            On::Points => {
                let rows = self.mesh.triangles.iter();
                rows.flat_map(|&[a, b, c]| (0..components).map(move |i| (at(a, i) + at(b, i) + at(c, i)) / 3.0))
                    .collect()
            }
        };
        Ok((values, components))
    }

    /// The rows of a list that counts the triangles of the file, for each triangle of the mesh.
    ///
    /// # Errors
    /// In words, for a list of another number of rows.
    pub(crate) fn by_triangle<T: Clone>(&self, list: Vec<T>, from: &str) -> Result<Vec<T>, String> {
        let triangles = self.mesh.triangles.len();
        let (needed, of) = match self.rows.is_empty() || self.triangles_of_file == triangles {
            true => (triangles, String::new()),
            false => (self.triangles_of_file, format!(" in its file ({triangles} after `repair`)")),
        };
        match list.len() == needed {
            true if self.rows.is_empty() => Ok(list),
            true => Ok(self.rows.iter().map(|&row| list[row as usize].clone()).collect()),
            false => Err(format!("{from} has {} entries, and the mesh {needed} triangles{of}", list.len())),
        }
    }
}

/// Reads a surface; the format follows from the extension, one of [`EXTENSIONS`]. glTF is in metres, others are taken in mm.
///
/// An array of three components with a usual name ([`Reading::fibres`]) gives the fibres.
///
/// # Errors
/// Where the file cannot be read, and as [`from_bytes`].
pub fn read(path: &Path) -> Result<TriangleMesh, MeshFileError> {
    read_with(path, &Reading::default()).map(|file| file.mesh)
}

/// Reads a surface and what its file says of it.
///
/// # Errors
/// As [`read`].
pub fn read_with(path: &Path, reading: &Reading) -> Result<MeshFile, MeshFileError> {
    mesh_of(&Files::new(PathBuf::new(), BTreeMap::new()), path, reading)
}

/// A grid of triangles as its file has it: nothing is joined, turned or dropped.
#[derive(Clone, Debug, Default)]
pub struct Grid {
    /// Its points \[mm\].
    pub positions: Vec<DVec3>,
    /// Corners of the triangles.
    pub triangles: Vec<[u32; 3]>,
    /// The arrays asked for, with a row for each point or cell of the file.
    pub arrays: Vec<Array>,
}

/// Reads a VTK XML grid (.vtu), with the arrays of these names that it has.
///
/// # Errors
/// Where the file cannot be read or does not follow its format.
pub fn read_grid(path: &Path, names: &[&str]) -> Result<Grid, MeshFileError> {
    let wanted = Wanted { names: names.to_vec(), ..Wanted::default() };
    let draft = encoding::unwrapped(bytes(path)?).and_then(|bytes| vtk_xml::parse(bytes, &wanted));
    let Draft { positions, triangles, arrays, .. } = draft.map_err(|fault| malformed(path, fault))?;
    Ok(Grid { positions, triangles, arrays })
}

/// The surface that a file of this name and content holds: for meshes from an archive or a network. `name` gives the format and
/// stands in errors; nothing is opened. Bytes from anywhere may be given: memory is bounded by a multiple of their number.
///
/// # Errors
/// Where the extension is not one of [`EXTENSIONS`], the bytes do not follow the format, or the surface fails
/// [`TriangleMesh::check`].
pub fn from_bytes(name: &Path, bytes: Vec<u8>) -> Result<TriangleMesh, MeshFileError> {
    from_bytes_with(name, bytes, &Reading::default()).map(|file| file.mesh)
}

/// The surface of a file's content and what it says of it.
///
/// # Errors
/// As [`from_bytes`].
pub fn from_bytes_with(name: &Path, bytes: Vec<u8>, reading: &Reading) -> Result<MeshFile, MeshFileError> {
    parse(name, bytes, None, reading)
}

fn parse(
    name: &Path,
    bytes: Vec<u8>,
    beside: Option<(&Path, &Files)>,
    reading: &Reading,
) -> Result<MeshFile, MeshFileError> {
    let names = reading.arrays.iter().chain(&reading.fibres).map(String::as_str).collect();
    let wanted = Wanted { names, fibres: reading.fibres.is_none(), beside };
    let read = format(name)?;
    let draft =
        encoding::unwrapped(bytes).and_then(|bytes| read(bytes, &wanted)).map_err(|fault| malformed(name, fault))?;
    let scale = reading.scale.unwrap_or_else(|| millimetres(name));
    finish(draft, reading, scale).map_err(|refusal| match refusal {
        Refusal::Fault(fault) => malformed(name, fault),
        Refusal::Mesh(error) => MeshFileError::Mesh { path: name.into(), error },
        Refusal::Defects(defects) => MeshFileError::Defects { path: name.into(), defects },
    })
}

/// Millimetres in the unit of a file's format.
pub(crate) fn millimetres(path: &Path) -> f64 {
    if is_gltf(path) { 1000.0 } else { 1.0 }
}

fn is_gltf(path: &Path) -> bool {
    path.extension().is_some_and(|own| ["glb", "gltf"].iter().any(|name| own.eq_ignore_ascii_case(name)))
}

/// Reads the bytes of one format.
type Format = fn(Vec<u8>, &Wanted) -> Result<Draft, Fault>;

fn format(path: &Path) -> Result<Format, MeshFileError> {
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase()).unwrap_or_default();
    match extension.as_str() {
        "obj" => Ok(obj::parse),
        "msh" => Ok(gmsh::parse),
        "vtu" | "vtp" => Ok(vtk_xml::parse),
        "vtk" => Ok(vtk_legacy::parse),
        "ply" => Ok(ply::parse),
        "stl" => Ok(stl::parse),
        "off" => Ok(off::parse),
        "glb" | "gltf" => Ok(gltf::parse),
        _ => Err(MeshFileError::UnsupportedExtension { path: path.into() }),
    }
}

/// Reads fibre directions for the triangles of a mesh in their order: three numbers a line, with spaces, commas or semicolons
/// between; empty lines and what follows a `#` are skipped.
pub fn read_fibres(path: &Path) -> Result<Vec<DVec3>, MeshFileError> {
    parse_fibres(path, bytes(path)?)
}

fn parse_fibres(name: &Path, bytes: Vec<u8>) -> Result<Vec<DVec3>, MeshFileError> {
    encoding::unwrapped(bytes).and_then(fibres::parse).map_err(|fault| malformed(name, fault))
}

/// Reads the numbers of a text file, a row for each line that holds any, with its line; separated as in [`read_fibres`].
///
/// # Errors
/// Where the file cannot be read, or a word is no number.
pub fn read_rows(path: &Path) -> Result<Vec<(usize, Vec<f64>)>, MeshFileError> {
    parse_rows(path, bytes(path)?)
}

fn parse_rows(name: &Path, bytes: Vec<u8>) -> Result<Vec<(usize, Vec<f64>)>, MeshFileError> {
    let must = "give numbers, the same count on every line";
    let rows = encoding::unwrapped(bytes).and_then(|bytes| fibres::rows(bytes, must));
    rows.map_err(|fault| malformed(name, fault))
}

/// The surface in a file that a scene mentions.
pub(crate) fn mesh_of(files: &Files, path: &Path, reading: &Reading) -> Result<MeshFile, MeshFileError> {
    let name = files.path(path);
    // Known before a file of any size is read.
    format(&name)?;
    let beside = (!files.is_given(path)).then_some((path, files));
    parse(&name, content(files, path)?, beside, reading)
}

/// The files beside a mesh file that it reads, too: buffers of a glTF file. None where it cannot be read.
pub(crate) fn beside(files: &Files, path: &Path) -> Vec<PathBuf> {
    if !is_gltf(path) || files.is_given(path) {
        return Vec::new();
    }
    let bytes = content(files, path).ok().and_then(|bytes| encoding::unwrapped(bytes).ok());
    let named = bytes.map_or(Vec::new(), |bytes| gltf::buffers(&bytes));
    named.into_iter().map(|buffer| path.with_file_name(buffer)).collect()
}

/// The fibres in a file that a scene mentions.
pub(crate) fn fibres_of(files: &Files, path: &Path) -> Result<Vec<DVec3>, MeshFileError> {
    parse_fibres(&files.path(path), content(files, path)?)
}

/// The rows of numbers in a file that a scene mentions.
pub(crate) fn rows_of(files: &Files, path: &Path) -> Result<Vec<(usize, Vec<f64>)>, MeshFileError> {
    parse_rows(&files.path(path), content(files, path)?)
}

fn content(files: &Files, path: &Path) -> Result<Vec<u8>, MeshFileError> {
    let read = files.read(path, MOST_BYTES).map(Arc::unwrap_or_clone);
    read.map_err(|source| MeshFileError::Unreadable { path: files.path(path), source })
}

fn bytes(path: &Path) -> Result<Vec<u8>, MeshFileError> {
    source::read(path, MOST_BYTES).map_err(|source| MeshFileError::Unreadable { path: path.into(), source })
}

fn malformed(path: &Path, Fault { line, what }: Fault) -> MeshFileError {
    MeshFileError::Malformed { path: path.into(), line, what }
}

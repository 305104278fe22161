//! `mesh = { file = … }`: a mesh file and how it is read.

use super::Point;
use serde::Deserialize;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, Error, MapAccess, Visitor};
use std::fmt;
use std::path::PathBuf;

/// A mesh file: its path, or `{ path, … }`. It is scaled, then turned, then moved.
#[derive(Clone, Debug)]
pub struct FileSpec {
    /// .obj, .msh, .vtu, .vtk, .ply, .stl, .vtp, .off, .glb or .gltf; relative to the scene file.
    pub path: PathBuf,
    /// How it is read.
    pub reading: ReadingSpec,
}

/// How a mesh file is read: all keys but `path`.
#[derive(Clone, Debug, Default)]
pub struct ReadingSpec {
    /// Millimetres per unit of the file. Default 1; for glTF, which is in metres, 1000.
    pub scale: Option<f64>,
    /// The unit of the file, in place of `scale`. Default mm; for glTF m.
    pub unit: Option<UnitSpec>,
    /// Angles \[°\] by which it is turned about x, then y, then z through the origin. Default none.
    pub rotate: Option<Point>,
    /// Way by which it is moved \[mm\]. Default none.
    pub translate: Option<Point>,
    /// Vertices no farther apart \[mm\] become one, ≥ 0. Default: STL and glTF join what rounding tells apart, others nothing.
    pub weld: Option<f64>,
    /// Whether bowties are split, empty, double and third triangles dropped and folded polygons filled, all of which is refused by default;
    /// and vertices on the edge of another triangle split in. Default false.
    pub repair: bool,
    /// Whether all triangles are turned over. Default false.
    pub flip: bool,
    /// Name of the array of fibres, three numbers a row. Default: fibre, fiber, fibres, fibers or f0 in any case of letters.
    pub fibres: Option<String>,
}

/// A unit of length.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum UnitSpec {
    /// Metre.
    #[serde(rename = "m")]
    Metre,
    /// Centimetre.
    #[serde(rename = "cm")]
    Centimetre,
    /// Millimetre.
    #[serde(rename = "mm")]
    Millimetre,
    /// Micrometre.
    #[serde(rename = "um", alias = "µm", alias = "μm")]
    Micrometre,
    /// Inch.
    #[serde(rename = "in")]
    Inch,
}

impl UnitSpec {
    /// Millimetres in it.
    pub fn millimetres(self) -> f64 {
        match self {
            Self::Metre => 1000.0,
            Self::Centimetre => 10.0,
            Self::Millimetre => 1.0,
            Self::Micrometre => 1e-3,
            Self::Inch => 25.4,
        }
    }
}

/// The long form.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FileTable {
    path: PathBuf,
    scale: Option<f64>,
    unit: Option<UnitSpec>,
    rotate: Option<Point>,
    translate: Option<Point>,
    weld: Option<f64>,
    #[serde(default)]
    repair: bool,
    #[serde(default)]
    flip: bool,
    fibres: Option<String>,
}

impl<'de> Deserialize<'de> for FileSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Read;
        impl<'de> Visitor<'de> for Read {
            type Value = FileSpec;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a path in quotes, or { path = \"…\", scale = … }")
            }
            fn visit_str<E: Error>(self, path: &str) -> Result<FileSpec, E> {
                Ok(FileSpec { path: path.into(), reading: ReadingSpec::default() })
            }
            fn visit_map<A: MapAccess<'de>>(self, access: A) -> Result<FileSpec, A::Error> {
                let FileTable { path, scale, unit, rotate, translate, weld, repair, flip, fibres } =
                    FileTable::deserialize(MapAccessDeserializer::new(access))?;
                Ok(FileSpec {
                    path,
                    reading: ReadingSpec { scale, unit, rotate, translate, weld, repair, flip, fibres },
                })
            }
        }
        deserializer.deserialize_any(Read)
    }
}

//! What differs from triangle to triangle.

use super::Numbers;
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Deserialize, Deserializer, Error, MapAccess, SeqAccess, Visitor};
use std::fmt;
use std::path::PathBuf;

/// `per_triangle`: a value for each triangle, in place of the body's own. Where there is no number (NaN), the body's own stands.
#[derive(Clone, Debug, Default, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PerTriangleSpec {
    /// Thickness \[mm\], > 0, in place of the material's.
    pub thickness: Option<Values>,
    /// Strength along the fibres \[MPa\], > 0, in place of `strength_along_fibres`; that across them keeps its ratio to it.
    pub strength: Option<Values>,
    /// Toughness along the fibres \[N/mm\], > 0, in place of `toughness_along_fibres`; that across them keeps its ratio to it.
    pub toughness: Option<Values>,
    /// Pre-stretch in the fibre's axes, in place of the body's: one number, or along, across and (tensor) shear.
    pub pre_stretch: Option<Values>,
}

impl PerTriangleSpec {
    /// What is given, by key.
    pub fn given(&self) -> impl Iterator<Item = (&'static str, &Values)> {
        let keys = [
            ("thickness", &self.thickness),
            ("strength", &self.strength),
            ("toughness", &self.toughness),
            ("pre_stretch", &self.pre_stretch),
        ];
        keys.into_iter().filter_map(|(key, values)| Some((key, values.as_ref()?)))
    }
}

/// Where values per triangle come from.
#[derive(Clone, Debug)]
pub enum Values {
    /// `"NAME"`: an array of the mesh file, of its cells or points; points are averaged.
    Array(String),
    /// `[…]`: an entry for each triangle, in the mesh's order.
    List(Vec<Numbers>),
    /// `{ file = "…" }`: a text file with a line for each triangle, in the mesh's order.
    File(PathBuf),
}

/// The table form.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct OnFile {
    file: PathBuf,
}

impl<'de> Deserialize<'de> for Values {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Read;
        impl<'de> Visitor<'de> for Read {
            type Value = Values;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(
                    "the name of an array of the mesh file, a list with an entry for each triangle or { file = \"…\" }",
                )
            }
            fn visit_str<E: Error>(self, name: &str) -> Result<Values, E> {
                Ok(Values::Array(name.to_owned()))
            }
            fn visit_seq<A: SeqAccess<'de>>(self, access: A) -> Result<Values, A::Error> {
                match Numbers::deserialize(SeqAccessDeserializer::new(access))? {
                    Numbers::List(list) => Ok(Values::List(list)),
                    one @ Numbers::One(_) => Ok(Values::List(vec![one])),
                }
            }
            fn visit_map<A: MapAccess<'de>>(self, access: A) -> Result<Values, A::Error> {
                let OnFile { file } = OnFile::deserialize(MapAccessDeserializer::new(access))?;
                Ok(Values::File(file))
            }
        }
        deserializer.deserialize_any(Read)
    }
}

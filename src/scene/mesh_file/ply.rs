//! PLY, text and binary, by `ply-rs-bw`.

use std::io::Cursor;

use glam::DVec3;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{ElementDef, Encoding, Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType};

use super::fault::Fault;
use super::surface::{Shape, push_cell};
use crate::storage::TriangleMesh;

/// Reads the elements `vertex` (x, y, z) and `face` (vertex_indices or vertex_index); others are skipped.
pub fn parse(bytes: Vec<u8>) -> Result<TriangleMesh, Fault> {
    let size = bytes.len();
    let mut reader = Reader::new(Cursor::new(bytes));
    let parser = Parser::<Element>::new();
    let header = parser.read_header(&mut reader).map_err(refused)?;
    for name in ["vertex", "face"] {
        if !header.elements.contains_key(name) {
            return Err(Fault::new(format!("the header declares no element `{name}`; export the mesh with its faces")));
        }
    }
    let mut mesh = TriangleMesh::default();
    let mut faces = Vec::new();
    for element in header.elements.values() {
        let left = size.saturating_sub(reader.get_ref().position() as usize);
        check_count(element, header.encoding, left)?;
        let read = parser.read_payload_for_element(&mut reader, element, &header).map_err(refused)?;
        match element.name.as_str() {
            "vertex" => mesh.positions.extend(read.into_iter().map(|vertex| vertex.position)),
            "face" => faces.extend(read.into_iter().map(|face| face.corners)),
            _ => {}
        }
    }
    // Faces may stand before the vertices.
    for (number, face) in faces.iter().enumerate() {
        let corners: Option<Vec<u32>> = face.iter().map(|&corner| u32::try_from(corner).ok()).collect();
        let corners = corners.ok_or_else(|| Fault::new(format!("face {number} has a negative vertex index")))?;
        push_cell(&mut mesh, Shape::Polygon, &corners, None)
            .map_err(|what| Fault::new(format!("face {number}: {what}")))?;
    }
    Ok(mesh)
}

/// A vertex or a face, whichever the properties make it.
struct Element {
    position: DVec3,
    corners: Vec<i64>,
}

impl PropertyAccess for Element {
    fn new() -> Self {
        Self { position: DVec3::NAN, corners: Vec::new() }
    }

    fn set_property(&mut self, key: &str, property: Property) -> PropertyAccessResult {
        match (key, property) {
            ("x", number) => self.position.x = scalar(&number),
            ("y", number) => self.position.y = scalar(&number),
            ("z", number) => self.position.z = scalar(&number),
            ("vertex_indices" | "vertex_index", list) => match integers(list) {
                Some(corners) => self.corners = corners,
                None => return PropertyAccessResult::UnsupportedType,
            },
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

fn scalar(property: &Property) -> f64 {
    match *property {
        Property::Char(x) => x.into(),
        Property::UChar(x) => x.into(),
        Property::Short(x) => x.into(),
        Property::UShort(x) => x.into(),
        Property::Int(x) => x.into(),
        Property::UInt(x) => x.into(),
        Property::Float(x) => x.into(),
        Property::Double(x) => x,
        _ => f64::NAN,
    }
}

fn integers(list: Property) -> Option<Vec<i64>> {
    fn widen<T: Into<i64>>(list: Vec<T>) -> Option<Vec<i64>> {
        Some(list.into_iter().map(Into::into).collect())
    }
    match list {
        Property::ListChar(list) => widen(list),
        Property::ListUChar(list) => widen(list),
        Property::ListShort(list) => widen(list),
        Property::ListUShort(list) => widen(list),
        Property::ListInt(list) => widen(list),
        Property::ListUInt(list) => widen(list),
        _ => None,
    }
}

/// The parser believes the count of an element without properties, which takes no bytes at all.
fn check_count(element: &ElementDef, encoding: Encoding, left: usize) -> Result<(), Fault> {
    let bytes_each = match encoding {
        // A digit and a blank or line break for each property; the last line may lack its break.
        Encoding::Ascii => 2 * element.properties.len(),
        _ => element.properties.values().map(|property| least_bytes(&property.data_type)).sum(),
    };
    let fits = bytes_each > 0 && element.count.checked_mul(bytes_each).is_some_and(|needed| needed <= left + 1);
    if element.count == 0 || fits {
        return Ok(());
    }
    let (name, count) = (&element.name, element.count);
    Err(Fault::new(format!(
        "the header promises {count} of element `{name}`, but only {left} bytes are left; the file is cut off or its header wrong: \
         export it again"
    )))
}

fn least_bytes(data_type: &PropertyType) -> usize {
    let (PropertyType::Scalar(first) | PropertyType::List(first, _)) = data_type;
    match first {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    }
}

fn refused(error: ParseError) -> Fault {
    let text = error.to_string();
    let what = text.split_once(": ").filter(|_| error.line().is_some()).map_or(text.as_str(), |(_, what)| what);
    let what = what.split(['\n', '\t']).filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" ");
    Fault { line: error.line(), what: format!("{what}; correct the line or export the file again") }
}

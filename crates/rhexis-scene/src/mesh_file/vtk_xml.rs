//! VTK XML unstructured grids (.vtu) and polygonal data (.vtp): text, base64 and appended data, plain or zlib-compressed.
//!
//! The XML is read by `roxmltree`, the encodings by `base64` and `miniz_oxide`; what the arrays mean is a page of code here. The
//! crate that knows the format as a whole panics on malformed files and misreads the default header size.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::rc::Rc;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use miniz_oxide::inflate::decompress_to_vec_zlib_with_limit;
use roxmltree::{Document, Node};

use super::draft::{Array, Draft, On, Origin, Shape, Wanted, points, vtk_shape};
use super::fault::{Fault, line_of};
use super::vtk_legacy::{index_list, slices};

/// Bytes of numbers, 8 for each, allowed per byte of file. Meshes shrink 2 to 20 times, up to 60 with their cell types as numbers.
/// Bombs, and pieces that all name one appended array, shrink thousands of times.
const MOST_INFLATION: usize = 128;

/// Reads all pieces as one surface.
pub(super) fn parse(bytes: Vec<u8>, wanted: &Wanted) -> Result<Draft, Fault> {
    let (text, appended) = split_appended(&bytes)?;
    let document = Document::parse(&text).map_err(|error| {
        Fault::at(error.pos().row as usize, format!("{error}; the XML is broken: save the file again"))
    })?;
    let root = document.root_element();
    let file = File::new(root, appended, bytes.len())?;
    let grid = child(root, "UnstructuredGrid").map(|grid| (grid, Kind::Grid));
    let (grid, kind) = grid.or_else(|| Some((child(root, "PolyData")?, Kind::Polygons))).ok_or_else(|| {
        fault_at(root, "no <UnstructuredGrid> and no <PolyData>; save the surface as one of them (.vtu, .vtp)")
    })?;
    let mut draft = Draft { origin: Origin::Number("cell"), ..Draft::default() };
    let mut cell_count = 0;
    for piece in grid.children().filter(|node| node.has_tag_name("Piece")) {
        cell_count += file.piece(piece, kind, cell_count, wanted, &mut draft)?;
    }
    Ok(draft)
}

/// The two kinds of data.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Grid,
    Polygons,
}

/// The lists of cells of polygonal data in the order of their cell data.
const LISTS: [(&str, &str, Shape); 4] = [
    ("Verts", "NumberOfVerts", Shape::Thin),
    ("Lines", "NumberOfLines", Shape::Thin),
    ("Polys", "NumberOfPolys", Shape::Polygon),
    ("Strips", "NumberOfStrips", Shape::Strip),
];

/// Takes the content of <AppendedData>, which need not be text, out of the file.
fn split_appended(bytes: &[u8]) -> Result<(String, &[u8]), Fault> {
    let find =
        |needle: &[u8], from: usize| bytes[from..].windows(needle.len()).position(|w| w == needle).map(|at| from + at);
    let end_tag = b"</AppendedData";
    let cut = find(b"<AppendedData", 0).and_then(|tag| {
        let start = find(b">", tag)? + 1;
        let end = bytes.windows(end_tag.len()).rposition(|window| window == end_tag).filter(|end| *end >= start)?;
        Some((start, end))
    });
    let (start, end) = cut.unwrap_or((bytes.len(), bytes.len()));
    let text = |part: &[u8]| {
        String::from_utf8(part.to_vec()).map_err(|_| Fault::new("not text: not a VTK XML file, or cut off"))
    };
    let content = &bytes[start..end];
    let data = content.iter().position(|byte| *byte == b'_').map_or(&[][..], |mark| &content[mark + 1..]);
    Ok((text(&bytes[..start])? + &text(&bytes[end..])?, data))
}

fn child<'a>(node: Node<'a, 'a>, name: &str) -> Option<Node<'a, 'a>> {
    node.children().find(|child| child.has_tag_name(name))
}

fn fault_at(node: Node, what: impl std::fmt::Display) -> Fault {
    Fault::at(line_of(node.document().input_text().as_bytes(), node.range().start), what)
}

/// A fault of an array, with its name or that of the element around it.
fn array_fault(array: Node, what: impl std::fmt::Display) -> Fault {
    let around = || array.parent_element().map(|parent| parent.tag_name().name());
    let name = array.attribute("Name").or_else(around).unwrap_or_default();
    fault_at(array, format!("array {name:?}: {what}"))
}

/// How the file encodes its numbers.
struct File<'a> {
    appended: &'a [u8],
    appended_is_base64: bool,
    /// Offsets of all appended arrays: each ends where the next begins.
    offsets: Vec<usize>,
    big_endian: bool,
    header_bytes: usize,
    compressed: bool,
    /// Bytes of numbers that may still be read.
    budget: Cell<usize>,
    /// Appended arrays that have been decoded, by their offset: any number of arrays may name one.
    decoded: RefCell<BTreeMap<usize, Option<Rc<Vec<u8>>>>>,
}

impl<'a> File<'a> {
    fn new(root: Node<'_, '_>, appended: &'a [u8], size: usize) -> Result<Self, Fault> {
        let known = |name: &str, default: &str, choices: [&str; 2]| {
            let value = root.attribute(name).unwrap_or(default);
            match choices.iter().position(|choice| *choice == value) {
                Some(place) => Ok(place == 1),
                None => {
                    Err(fault_at(root, format!("{name} {value:?} is not read; save with {}", choices.join(" or "))))
                }
            }
        };
        if !root.has_tag_name("VTKFile") {
            return Err(fault_at(root, "not a VTK XML file: the outermost element must be <VTKFile>"));
        }
        let encoding =
            root.children().find(|node| node.has_tag_name("AppendedData")).and_then(|node| node.attribute("encoding"));
        let compressed = match root.attribute("compressor") {
            None | Some("") => false,
            Some("vtkZLibDataCompressor") => true,
            Some(other) => {
                return Err(fault_at(root, format!("{other} is not read; save with zlib or without compression")));
            }
        };
        let offset = |node: Node| node.attribute("offset")?.parse().ok();
        let mut offsets: Vec<usize> = root.descendants().filter_map(offset).collect();
        offsets.sort_unstable();
        offsets.dedup();
        Ok(Self {
            appended,
            appended_is_base64: encoding == Some("base64"),
            offsets,
            big_endian: known("byte_order", "LittleEndian", ["LittleEndian", "BigEndian"])?,
            header_bytes: if known("header_type", "UInt32", ["UInt32", "UInt64"])? { 8 } else { 4 },
            compressed,
            budget: Cell::new(size.saturating_mul(MOST_INFLATION)),
            decoded: RefCell::default(),
        })
    }

    /// Appends a piece; the number of its cells.
    fn piece(
        &self,
        piece: Node<'_, '_>,
        kind: Kind,
        first_cell: usize,
        wanted: &Wanted,
        draft: &mut Draft,
    ) -> Result<usize, Fault> {
        let count = |name: &str| {
            // Polygonal data need not name the lists that they do not have.
            let default = if kind == Kind::Polygons { "0" } else { "" };
            let text = piece.attribute(name).unwrap_or(default);
            text.trim().parse::<usize>().map_err(|_| fault_at(piece, format!("{name} {text:?} is not a count")))
        };
        let point_count = count("NumberOfPoints")?;
        let positions = match point_count {
            0 if child(piece, "Points").is_none() => Vec::new(),
            _ => points(&self.sized(piece, "Points", None, 3, point_count)?),
        };
        let mut cells: Vec<(Shape, Vec<u32>)> = Vec::new();
        match kind {
            Kind::Grid => {
                let cell_count = count("NumberOfCells")?;
                let types = self.sized(piece, "Cells", Some("types"), 1, cell_count)?;
                let corners = self.cells(piece, "Cells", cell_count)?;
                for (number, (corners, cell_type)) in corners.into_iter().zip(types).enumerate() {
                    let fault = |what| fault_at(piece, format!("cell {}: {what}", first_cell + number));
                    cells.push((vtk_shape(cell_type as u64).map_err(fault)?, corners));
                }
            }
            Kind::Polygons => {
                for (list, name, shape) in LISTS {
                    let cell_count = count(name)?;
                    if cell_count > 0 {
                        let corners = self.cells(piece, list, cell_count)?;
                        cells.extend(corners.into_iter().map(|corners| (shape, corners)));
                    }
                }
            }
        }
        let first = draft.positions.len();
        draft.positions.extend(positions);
        if u32::try_from(draft.positions.len()).is_err() {
            return Err(fault_at(piece, "there are more points than an index can name; save fewer pieces"));
        }
        let first = first as u32;
        for (number, (shape, cell)) in cells.iter().enumerate() {
            let number = first_cell + number;
            // The corners of other pieces are not its own.
            if let Some(&corner) = cell.iter().find(|&&corner| corner as usize >= point_count) {
                let what =
                    format!("cell {number} names point {corner}, but its piece has only {point_count}; save again");
                return Err(fault_at(piece, what));
            }
            let corners: Vec<u32> = cell.iter().map(|&corner| first + corner).collect();
            draft
                .push_cell(*shape, &corners, number, number)
                .map_err(|what| fault_at(piece, format!("cell {number}: {what}")))?;
        }
        self.arrays(
            piece,
            [(On::Points, first as usize, point_count), (On::Cells, first_cell, cells.len())],
            wanted,
            draft,
        )?;
        Ok(cells.len())
    }

    /// The array `name` (or the first) in `parent`, of so many numbers.
    fn sized(
        &self,
        piece: Node<'_, '_>,
        parent: &str,
        name: Option<&str>,
        components: usize,
        expected: usize,
    ) -> Result<Vec<f64>, Fault> {
        let array = self.find(piece, parent, name);
        let array = array
            .ok_or_else(|| fault_at(piece, format!("<{parent}> holds no array {}", name.unwrap_or("of points"))))?;
        let numbers = self.numbers(array)?;
        match expected.checked_mul(components) {
            Some(length) if length == numbers.len() => Ok(numbers),
            _ => {
                let what = format!("{} numbers where {expected} × {components} belong; save again", numbers.len());
                Err(array_fault(array, what))
            }
        }
    }

    /// The corners of each cell of a list.
    fn cells(&self, piece: Node<'_, '_>, list: &str, cell_count: usize) -> Result<Vec<Vec<u32>>, Fault> {
        let mut offsets = vec![0.0];
        offsets.extend(self.sized(piece, list, Some("offsets"), 1, cell_count)?);
        let connectivity = self.find(piece, list, Some("connectivity"));
        let connectivity = connectivity.map(|array| self.numbers(array)).transpose()?.unwrap_or_default();
        index_list(&offsets)
            .zip(index_list(&connectivity))
            .and_then(|(offsets, connectivity)| slices(&offsets, &connectivity))
            .ok_or_else(|| fault_at(piece, "the cell offsets and the connectivity do not fit together; save again"))
    }

    /// Reads the arrays that are asked for; those that other pieces lack have no numbers there.
    fn arrays(
        &self,
        piece: Node<'_, '_>,
        rows: [(On, usize, usize); 2],
        wanted: &Wanted,
        draft: &mut Draft,
    ) -> Result<(), Fault> {
        for (on, first, count) in rows {
            let parent = if on == On::Points { "PointData" } else { "CellData" };
            let found = child(piece, parent).into_iter().flat_map(|data| data.children());
            for node in found.filter(|node| node.has_tag_name("DataArray")) {
                let name = node.attribute("Name").unwrap_or_default();
                if !wanted.has(name) {
                    draft.passed_over.insert(name.to_owned());
                    continue;
                }
                let numbers = self.numbers(node)?;
                let components = match count {
                    0 => continue,
                    count if (1..=9).any(|components| numbers.len() == components * count) => numbers.len() / count,
                    _ => {
                        let what = format!("{} numbers for {count} rows; save again", numbers.len());
                        return Err(array_fault(node, what));
                    }
                };
                let place =
                    draft.arrays.iter().position(|a| a.on == on && a.name == name && a.components == components);
                let array = match place {
                    Some(place) => &mut draft.arrays[place],
                    None => {
                        draft.arrays.push(Array { name: name.to_owned(), on, components, values: Vec::new() });
                        let last = draft.arrays.len() - 1;
                        &mut draft.arrays[last]
                    }
                };
                // Rows of pieces without the array count as numbers of the file.
                let missing = (components * first).saturating_sub(array.values.len());
                let left = self.budget.get().checked_sub(size_of::<f64>() * missing);
                self.budget.set(
                    left.ok_or_else(|| array_fault(node, "more numbers than a file of this size holds; save again"))?,
                );
                array.values.resize(components * first, f64::NAN);
                array.values.extend(numbers);
            }
        }
        Ok(())
    }

    /// The array `name` (or the first) in `parent`.
    fn find<'b>(&self, piece: Node<'b, 'b>, parent: &str, name: Option<&str>) -> Option<Node<'b, 'b>> {
        let mut arrays = child(piece, parent)?.children().filter(|node| node.has_tag_name("DataArray"));
        arrays.find(|array| name.is_none() || array.attribute("Name") == name)
    }

    fn numbers(&self, array: Node) -> Result<Vec<f64>, Fault> {
        let refuse = |what: &str| array_fault(array, format!("{what}; save the file again"));
        let text = array.text().unwrap_or_default();
        let bytes = match array.attribute("format") {
            Some("ascii") | None => {
                let parse = |word: &str| word.parse().map_err(|_| refuse(&format!("{word:?} is not a number")));
                return text.split_ascii_whitespace().map(parse).collect();
            }
            Some("binary") => from_base64(text.as_bytes()).and_then(|packed| self.unpack(&packed)).map(Rc::new),
            Some("appended") => self.appended_array(array),
            Some(_) => None,
        };
        let bytes = bytes.ok_or_else(|| refuse("its data are broken or cut off"))?;
        macro_rules! read {
            ($type:ty) => {{
                let (numbers, rest) = bytes.as_chunks::<{ size_of::<$type>() }>();
                let left = self.budget.get().checked_sub(size_of::<f64>() * numbers.len());
                self.budget.set(left.ok_or_else(|| refuse("there are more numbers than a file of this size holds"))?);
                let convert = if self.big_endian { <$type>::from_be_bytes } else { <$type>::from_le_bytes };
                rest.is_empty().then(|| numbers.iter().map(|bytes| convert(*bytes) as f64).collect())
            }};
        }
        let numbers = match array.attribute("type").unwrap_or_default() {
            "Float64" => read!(f64),
            "Float32" => read!(f32),
            "Int64" => read!(i64),
            "UInt64" => read!(u64),
            "Int32" => read!(i32),
            "UInt32" => read!(u32),
            "Int16" => read!(i16),
            "UInt16" => read!(u16),
            "Int8" => read!(i8),
            "UInt8" => read!(u8),
            _ => None,
        };
        numbers.ok_or_else(|| refuse("its type does not fit its data"))
    }

    fn appended_array(&self, array: Node) -> Option<Rc<Vec<u8>>> {
        let offset: usize = array.attribute("offset")?.parse().ok()?;
        self.decoded.borrow_mut().entry(offset).or_insert_with(|| self.decode(offset).map(Rc::new)).clone()
    }

    fn decode(&self, offset: usize) -> Option<Vec<u8>> {
        let next = self.offsets.partition_point(|other| *other <= offset);
        let end = self.offsets.get(next).copied().unwrap_or(self.appended.len());
        let bytes = self.appended.get(offset..end.min(self.appended.len()))?;
        if self.appended_is_base64 { self.unpack(&from_base64(bytes)?) } else { self.unpack(bytes) }
    }

    /// A header number at `place`.
    fn header(&self, bytes: &[u8], place: usize) -> Option<usize> {
        let at = place.checked_mul(self.header_bytes)?;
        let mut number = bytes.get(at..at.checked_add(self.header_bytes)?)?.to_vec();
        if self.big_endian {
            number.reverse();
        }
        number.resize(8, 0);
        usize::try_from(u64::from_le_bytes(number.try_into().ok()?)).ok()
    }

    /// Plain: [length][data]. Compressed: [blocks][size of a block][size of the last if shorter][compressed sizes…][data…].
    fn unpack(&self, bytes: &[u8]) -> Option<Vec<u8>> {
        let first = self.header(bytes, 0)?;
        if !self.compressed {
            return Some(bytes.get(self.header_bytes..self.header_bytes.checked_add(first)?)?.to_vec());
        }
        let block_size = self.header(bytes, 1)?;
        let mut rest = bytes.get(first.checked_add(3)?.checked_mul(self.header_bytes)?..)?;
        let mut out = Vec::new();
        for block in 0..first {
            let (data, after) = rest.split_at_checked(self.header(bytes, 3 + block)?)?;
            let room = self.budget.get().checked_sub(out.len())?;
            out.extend(decompress_to_vec_zlib_with_limit(data, block_size.min(room)).ok()?);
            rest = after;
        }
        Some(out)
    }
}

/// Base64 in one or more separately padded pieces, as VTK writes header and data.
fn from_base64(text: &[u8]) -> Option<Vec<u8>> {
    let text: Vec<u8> = text.iter().copied().filter(|byte| !byte.is_ascii_whitespace()).collect();
    let mut out = Vec::with_capacity(text.len());
    // A piece ends with its padding: cut where something else follows it.
    for piece in text.chunk_by(|a, b| !(*a == b'=' && *b != b'=')) {
        STANDARD.decode_vec(piece, &mut out).ok()?;
    }
    Some(out)
}

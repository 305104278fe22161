//! Legacy VTK (.vtk), text and binary, file versions up to 5.1.
//!
//! Read here rather than by a crate: the readers on offer allocate by the counts in the file, and do not know the layout
//! of cells that VTK itself has written since version 5.1.

use std::str::FromStr;

use super::fault::{Fault, line_of};
use super::surface::{Shape, points, push_cell, vtk_shape};
use crate::storage::TriangleMesh;

/// Reads an unstructured grid or polygonal data.
pub fn parse(bytes: Vec<u8>) -> Result<TriangleMesh, Fault> {
    let mut file = Cursor { bytes: &bytes, at: 0, binary: false };
    let version = file.header()?;
    let mut found = Found::default();
    while let Some(line) = file.keyword_line()? {
        found.section(&line, version, &mut file)?;
    }
    found.mesh()
}

/// The parts of the file that matter.
#[derive(Default)]
struct Found {
    dataset: String,
    points: Vec<f64>,
    /// Corner lists per cell: CELLS, or VERTICES, LINES, POLYGONS and TRIANGLE_STRIPS in the order of cell data.
    cells: [Vec<Vec<u32>>; 5],
    types: Vec<f64>,
    fibres: Option<Vec<f64>>,
    /// Points or cells that the attributes being read belong to.
    attribute_count: usize,
    of_cells: bool,
}

const CELL_KEYWORDS: [&str; 5] = ["CELLS", "VERTICES", "LINES", "POLYGONS", "TRIANGLE_STRIPS"];

impl Found {
    fn section(&mut self, line: &[String], version: u32, file: &mut Cursor) -> Result<(), Fault> {
        let word = |place: usize| line.get(place).map(String::as_str).unwrap_or_default();
        let keyword = word(0).to_uppercase();
        let count = |place: usize| file.count(word(place));
        match keyword.as_str() {
            "DATASET" => {
                self.dataset = word(1).to_uppercase();
                if !["UNSTRUCTURED_GRID", "POLYDATA"].contains(&self.dataset.as_str()) {
                    let what = format!("the data set is {}; save it as POLYDATA or UNSTRUCTURED_GRID", word(1));
                    return Err(file.fault(what));
                }
            }
            "POINTS" => {
                let count = count(1)?;
                self.points = file.numbers(count.saturating_mul(3), word(2))?;
            }
            "CELL_TYPES" => {
                let count = count(1)?;
                self.types = file.numbers(count, "int")?;
            }
            "METADATA" => file.skip_to_blank_line(),
            "POINT_DATA" | "CELL_DATA" => {
                self.attribute_count = count(1)?;
                self.of_cells = keyword == "CELL_DATA";
            }
            "SCALARS" => {
                let components = if line.len() > 3 { count(3)? } else { 1 };
                file.skip_lookup_table_line();
                self.attribute(word(1), components, word(2), file)?;
            }
            "COLOR_SCALARS" => {
                let components = count(2)?;
                self.attribute(word(1), components, "unsigned_char", file)?;
            }
            "LOOKUP_TABLE" => {
                let count = count(2)?;
                file.numbers(count.saturating_mul(4), "unsigned_char")?;
            }
            "VECTORS" | "NORMALS" => self.attribute(word(1), 3, word(2), file)?,
            "TENSORS" => self.attribute(word(1), 9, word(2), file)?,
            "TENSORS6" => self.attribute(word(1), 6, word(2), file)?,
            "GLOBAL_IDS" | "PEDIGREE_IDS" => self.attribute(word(1), 1, word(2), file)?,
            "TEXTURE_COORDINATES" => {
                let components = count(2)?;
                self.attribute(word(1), components, word(3), file)?;
            }
            "FIELD" => {
                let arrays = count(2)?;
                let mut read = 0;
                while read < arrays {
                    let Some(array) = file.keyword_line()? else {
                        return Err(file.fault("the field data are cut off"));
                    };
                    let word = |place: usize| array.get(place).map(String::as_str).unwrap_or_default();
                    // Arrays may carry metadata of their own.
                    if word(0).eq_ignore_ascii_case("METADATA") {
                        file.skip_to_blank_line();
                        continue;
                    }
                    let (components, tuples) = (file.count(word(1))?, file.count(word(2))?);
                    let values = file.numbers(components.saturating_mul(tuples), word(3))?;
                    self.keep(word(0), components, values);
                    read += 1;
                }
            }
            other => match CELL_KEYWORDS.iter().position(|keyword| *keyword == other) {
                Some(kind) => {
                    let (first, second) = (count(1)?, count(2)?);
                    self.cells[kind] =
                        if version >= 5 { file.cells(first, second)? } else { file.old_cells(first, second)? };
                }
                None => return Err(file.fault(format!("unknown keyword {:?}; save the file again", word(0)))),
            },
        }
        Ok(())
    }

    fn attribute(&mut self, name: &str, components: usize, number_type: &str, file: &mut Cursor) -> Result<(), Fault> {
        let values = file.numbers(components.saturating_mul(self.attribute_count), number_type)?;
        self.keep(name, components, values);
        Ok(())
    }

    fn keep(&mut self, name: &str, components: usize, values: Vec<f64>) {
        if self.of_cells && name == "fibre" && components == 3 {
            self.fibres = Some(values);
        }
    }

    fn mesh(self) -> Result<TriangleMesh, Fault> {
        let cell_count: usize = self.cells.iter().map(Vec::len).sum();
        if self.dataset == "UNSTRUCTURED_GRID" && self.types.len() != cell_count {
            return Err(Fault::new(format!(
                "there are {cell_count} cells but {} cell types; save again",
                self.types.len()
            )));
        }
        let fibres = self.fibres.as_deref().map(points);
        if let Some(fibres) = &fibres
            && fibres.len() != cell_count
        {
            return Err(Fault::new(format!(
                "there are {} fibres for {cell_count} cells; give one per cell",
                fibres.len()
            )));
        }
        let mut mesh = TriangleMesh { positions: points(&self.points), ..Default::default() };
        let shapes = [Shape::Polygon, Shape::Thin, Shape::Thin, Shape::Polygon, Shape::Strip];
        let cells =
            self.cells.iter().zip(shapes).flat_map(|(cells, shape)| cells.iter().map(move |cell| (cell, shape)));
        for (number, (cell, shape)) in cells.enumerate() {
            let shape = match self.types.get(number) {
                Some(&cell_type) => {
                    vtk_shape(cell_type as u64).map_err(|what| Fault::new(format!("cell {number}: {what}")))?
                }
                None => shape,
            };
            push_cell(&mut mesh, shape, cell, fibres.as_ref().map(|fibres| fibres[number]))
                .map_err(|what| Fault::new(format!("cell {number}: {what}")))?;
        }
        Ok(mesh)
    }
}

/// A place in the file.
struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    binary: bool,
}

impl Cursor<'_> {
    fn fault(&self, what: impl std::fmt::Display) -> Fault {
        // Line breaks in binary data mean nothing.
        Fault { line: (!self.binary).then(|| line_of(self.bytes, self.at.saturating_sub(1))), what: what.to_string() }
    }

    fn line(&mut self) -> Option<&[u8]> {
        let rest = self.bytes.get(self.at..).filter(|rest| !rest.is_empty())?;
        let length = rest.iter().position(|byte| *byte == b'\n').map_or(rest.len(), |end| end + 1);
        self.at += length;
        Some(&rest[..length])
    }

    /// Major version; leaves the cursor after the line that tells text from binary.
    fn header(&mut self) -> Result<u32, Fault> {
        let what = "not a VTK file: it must begin with `# vtk DataFile Version`";
        let line = String::from_utf8_lossy(self.line().unwrap_or_default()).to_lowercase();
        let version = line.strip_prefix("# vtk datafile version").ok_or_else(|| Fault::at(1, what))?;
        let major = version.trim().split('.').next().and_then(|major| major.parse().ok());
        let major = major.ok_or_else(|| Fault::at(1, what))?;
        self.line();
        match self.line().unwrap_or_default().trim_ascii() {
            format if format.eq_ignore_ascii_case(b"ascii") => {}
            format if format.eq_ignore_ascii_case(b"binary") => self.binary = true,
            _ => return Err(Fault::at(3, "the third line must be ASCII or BINARY")),
        }
        Ok(major)
    }

    /// The words of the next line that has any.
    fn keyword_line(&mut self) -> Result<Option<Vec<String>>, Fault> {
        while let Some(line) = self.line() {
            let text = str::from_utf8(line)
                .map_err(|_| Fault::new("a keyword was expected where binary data stand; save again"))?;
            let words: Vec<String> = text.split_ascii_whitespace().map(String::from).collect();
            if !words.is_empty() {
                return Ok(Some(words));
            }
        }
        Ok(None)
    }

    fn count(&self, word: &str) -> Result<usize, Fault> {
        word.parse().map_err(|_| self.fault(format!("{word:?} is not a count")))
    }

    fn skip_to_blank_line(&mut self) {
        while self.line().is_some_and(|line| !line.trim_ascii().is_empty()) {}
    }

    fn skip_lookup_table_line(&mut self) {
        let before = self.at;
        let found = self.line().is_some_and(|line| line.to_ascii_uppercase().starts_with(b"LOOKUP_TABLE"));
        if !found {
            self.at = before;
        }
    }

    /// `count` numbers of a VTK type. Refused before anything is allocated if the file is too short for them.
    fn numbers(&mut self, count: usize, number_type: &str) -> Result<Vec<f64>, Fault> {
        let rest = &self.bytes[self.at.min(self.bytes.len())..];
        let number_type = number_type.to_lowercase();
        let too_many = |me: &Self| {
            me.fault(format!("{count} numbers are announced, but the file is too short for them; save it again"))
        };
        if !self.binary {
            // A digit and a blank each.
            if count > rest.len() / 2 + 1 {
                return Err(too_many(self));
            }
            return (0..count).map(|_| self.text_number()).collect();
        }
        macro_rules! read {
            ($type:ty) => {{
                const SIZE: usize = size_of::<$type>();
                let length =
                    count.checked_mul(SIZE).filter(|length| *length <= rest.len()).ok_or_else(|| too_many(self))?;
                let numbers = rest[..length].as_chunks::<SIZE>().0.iter();
                let numbers = numbers.map(|bytes| <$type>::from_be_bytes(*bytes) as f64).collect();
                self.at += length;
                Ok(numbers)
            }};
        }
        match number_type.as_str() {
            "float" => read!(f32),
            "double" => read!(f64),
            "int" | "vtkidtype" => read!(i32),
            "unsigned_int" => read!(u32),
            "long" | "vtktypeint64" => read!(i64),
            "unsigned_long" | "vtktypeuint64" => read!(u64),
            "short" => read!(i16),
            "unsigned_short" => read!(u16),
            "char" | "signed_char" => read!(i8),
            "unsigned_char" => read!(u8),
            _ => {
                Err(self.fault(format!("numbers of type {number_type:?} are not read; remove the array from the file")))
            }
        }
    }

    fn text_number(&mut self) -> Result<f64, Fault> {
        let rest = &self.bytes[self.at.min(self.bytes.len())..];
        let start = rest.iter().take_while(|byte| byte.is_ascii_whitespace()).count();
        let length = rest[start..].iter().take_while(|byte| !byte.is_ascii_whitespace()).count();
        let word = String::from_utf8_lossy(&rest[start..start + length]);
        self.at += start + length;
        f64::from_str(&word).map_err(|_| match length {
            0 => self.fault("the file ends where numbers are still to come; save it again"),
            _ => self.fault(format!("{word:?} is not a number")),
        })
    }

    fn indices(&mut self, count: usize, number_type: &str) -> Result<Vec<u32>, Fault> {
        let numbers = self.numbers(count, number_type)?;
        index_list(&numbers).ok_or_else(|| self.fault("a cell holds a number that is no vertex index"))
    }

    /// Up to version 4: each cell as its number of corners and the corners.
    fn old_cells(&mut self, count: usize, size: usize) -> Result<Vec<Vec<u32>>, Fault> {
        let list = self.indices(size, "int")?;
        let mut rest = list.as_slice();
        let mut cells = Vec::new();
        while let [corner_count, corners @ ..] = rest {
            let Some((corners, after)) = corners.split_at_checked(*corner_count as usize) else { break };
            cells.push(corners.to_vec());
            rest = after;
        }
        if cells.len() != count || !rest.is_empty() {
            return Err(self.fault(format!("the cell list does not hold {count} cells; save the file again")));
        }
        Ok(cells)
    }

    /// From version 5: offsets into a list of corners.
    fn cells(&mut self, offset_count: usize, size: usize) -> Result<Vec<Vec<u32>>, Fault> {
        let list = |me: &mut Self, keyword: &str, count| {
            let line = me.keyword_line()?.unwrap_or_default();
            match line.as_slice() {
                [found, number_type] if found.eq_ignore_ascii_case(keyword) => me.indices(count, number_type),
                _ => Err(me.fault(format!("`{keyword} type` is missing; save the file again"))),
            }
        };
        let offsets = list(self, "OFFSETS", offset_count)?;
        let corners = list(self, "CONNECTIVITY", size)?;
        slices(&offsets, &corners)
            .ok_or_else(|| self.fault("the cell offsets do not fit the connectivity; save the file again"))
    }
}

/// Whole numbers that a `u32` holds.
pub fn index_list(numbers: &[f64]) -> Option<Vec<u32>> {
    let whole = |number: &f64| number.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(number);
    numbers.iter().all(whole).then(|| numbers.iter().map(|number| *number as u32).collect())
}

/// The pieces of `corners` between successive `offsets`.
pub fn slices(offsets: &[u32], corners: &[u32]) -> Option<Vec<Vec<u32>>> {
    offsets.windows(2).map(|ends| Some(corners.get(ends[0] as usize..ends[1] as usize)?.to_vec())).collect()
}

//! Legacy VTK (.vtk), text and binary, file versions up to 5.1.
//!
//! Read here rather than by a crate: the readers on offer allocate by the counts in the file, and do not know the layout
//! of cells that VTK itself has written since version 5.1.

use std::collections::BTreeSet;

use super::draft::{Array, Draft, On, Origin, Shape, Wanted, points, vtk_shape};
use super::encoding;
use super::fault::{Fault, line_of};

/// Reads an unstructured grid or polygonal data.
pub(super) fn parse(bytes: Vec<u8>, wanted: &Wanted) -> Result<Draft, Fault> {
    let is_text = encoding::first_lines(&bytes, 3).get(2).is_some_and(|line| line.trim().eq_ignore_ascii_case("ascii"));
    let bytes = if is_text { encoding::line_feeds(bytes) } else { bytes };
    let mut file = Cursor { bytes: &bytes, at: 0, binary: false };
    let version = file.header()?;
    let mut found = Found::default();
    while let Some(line) = file.keyword_line()? {
        found.section(&line, version, &mut file, wanted)?;
    }
    found.draft()
}

/// The parts of the file that matter.
#[derive(Default)]
struct Found {
    dataset: String,
    points: Vec<f64>,
    /// Corner lists per cell: CELLS, or VERTICES, LINES, POLYGONS and TRIANGLE_STRIPS in the order of cell data.
    cells: [Vec<Vec<u32>>; 5],
    types: Vec<f64>,
    arrays: Vec<Array>,
    passed_over: BTreeSet<String>,
    /// Points or cells that the attributes being read belong to: none before the first of them.
    attribute_count: usize,
    on: Option<On>,
}

const CELL_KEYWORDS: [&str; 5] = ["CELLS", "VERTICES", "LINES", "POLYGONS", "TRIANGLE_STRIPS"];

impl Found {
    fn section(&mut self, line: &[String], version: u32, file: &mut Cursor, wanted: &Wanted) -> Result<(), Fault> {
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
                self.on = Some(if keyword == "CELL_DATA" { On::Cells } else { On::Points });
            }
            "SCALARS" => {
                let components = if line.len() > 3 { count(3)? } else { 1 };
                file.skip_lookup_table_line();
                self.attribute(word(1), components, word(2), file, wanted)?;
            }
            "COLOR_SCALARS" => {
                let components = count(2)?;
                self.attribute(word(1), components, "unsigned_char", file, wanted)?;
            }
            "LOOKUP_TABLE" => {
                let count = count(2)?;
                file.numbers(count.saturating_mul(4), "unsigned_char")?;
            }
            "VECTORS" | "NORMALS" => self.attribute(word(1), 3, word(2), file, wanted)?,
            "TENSORS" => self.attribute(word(1), 9, word(2), file, wanted)?,
            "TENSORS6" => self.attribute(word(1), 6, word(2), file, wanted)?,
            "GLOBAL_IDS" | "PEDIGREE_IDS" => self.attribute(word(1), 1, word(2), file, wanted)?,
            "TEXTURE_COORDINATES" => {
                let components = count(2)?;
                self.attribute(word(1), components, word(3), file, wanted)?;
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
                    let count = components.saturating_mul(tuples);
                    match word(3).to_lowercase().as_str() {
                        "string" => file.skip_strings(count)?,
                        number_type => {
                            let values = file.numbers(count, number_type)?;
                            self.keep(word(0), components, values, wanted);
                        }
                    }
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

    fn attribute(
        &mut self,
        name: &str,
        components: usize,
        number_type: &str,
        file: &mut Cursor,
        wanted: &Wanted,
    ) -> Result<(), Fault> {
        let count = components.saturating_mul(self.attribute_count);
        if number_type.eq_ignore_ascii_case("string") {
            return file.skip_strings(count);
        }
        let values = file.numbers(count, number_type)?;
        self.keep(name, components, values, wanted);
        Ok(())
    }

    fn keep(&mut self, name: &str, components: usize, values: Vec<f64>, wanted: &Wanted) {
        match self.on {
            Some(on) if wanted.has(name) => self.arrays.push(Array { name: name.to_owned(), on, components, values }),
            Some(_) => drop(self.passed_over.insert(name.to_owned())),
            None => {}
        }
    }

    fn draft(self) -> Result<Draft, Fault> {
        let cell_count: usize = self.cells.iter().map(Vec::len).sum();
        if self.dataset == "UNSTRUCTURED_GRID" && self.types.len() != cell_count {
            return Err(Fault::new(format!(
                "there are {cell_count} cells but {} cell types; save again",
                self.types.len()
            )));
        }
        let Self { points: coordinates, cells, types, arrays, passed_over, .. } = self;
        let positions = points(&coordinates);
        let mut draft = Draft { positions, origin: Origin::Number("cell"), arrays, passed_over, ..Draft::default() };
        let shapes = [Shape::Polygon, Shape::Thin, Shape::Thin, Shape::Polygon, Shape::Strip];
        let cells = cells.iter().zip(shapes).flat_map(|(cells, shape)| cells.iter().map(move |cell| (cell, shape)));
        for (number, (cell, shape)) in cells.enumerate() {
            let fault = |what: String| Fault::new(format!("cell {number}: {what}"));
            let shape = match types.get(number) {
                Some(&cell_type) => vtk_shape(cell_type as u64).map_err(fault)?,
                None => shape,
            };
            draft.push_cell(shape, cell, number, number).map_err(fault)?;
        }
        for array in &draft.arrays {
            let count = if array.on == On::Cells { cell_count } else { draft.positions.len() };
            if array.components.saturating_mul(count) != array.values.len() {
                let rows = array.values.len() / array.components.max(1);
                let what = format!("the array {:?} has {rows} rows where {count} belong; save again", array.name);
                return Err(Fault::new(what));
            }
        }
        Ok(draft)
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

    /// Strings, which are read by nobody: a line each, or in binary files each behind its length.
    fn skip_strings(&mut self, count: usize) -> Result<(), Fault> {
        for _ in 0..count {
            let rest = self.bytes.get(self.at..).unwrap_or_default();
            let Some(&first) = rest.first() else {
                return Err(self.fault("the file ends where strings are still to come; save it again"));
            };
            if !self.binary {
                self.line();
                continue;
            }
            // The two highest bits tell how many bytes the length has, the others begin it.
            let bytes = [8, 4, 2, 1][usize::from(first >> 6)];
            let low = rest.get(..bytes).unwrap_or_default().iter().enumerate();
            let length =
                low.fold(0_usize, |sum, (i, &byte)| (sum << 8) | usize::from(if i == 0 { byte & 0x3f } else { byte }));
            self.at = self.at.saturating_add(bytes).saturating_add(length).min(self.bytes.len());
        }
        Ok(())
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
            "bit" => {
                let length = count.div_ceil(8);
                let packed = rest.get(..length).ok_or_else(|| too_many(self))?;
                let numbers = (0..count).map(|i| f64::from(packed[i / 8] >> (7 - i % 8) & 1)).collect();
                self.at += length;
                Ok(numbers)
            }
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
        encoding::number(&word).ok_or_else(|| match length {
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
pub(super) fn index_list(numbers: &[f64]) -> Option<Vec<u32>> {
    let whole = |number: &f64| number.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(number);
    numbers.iter().all(whole).then(|| numbers.iter().map(|number| *number as u32).collect())
}

/// The pieces of `corners` between successive `offsets`.
pub(super) fn slices(offsets: &[u32], corners: &[u32]) -> Option<Vec<Vec<u32>>> {
    offsets.windows(2).map(|ends| Some(corners.get(ends[0] as usize..ends[1] as usize)?.to_vec())).collect()
}

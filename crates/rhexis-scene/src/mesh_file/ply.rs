//! PLY, text and binary. Read here: 64-bit indices, carriage returns and the lines of text are beyond the readers on offer.

use super::draft::{Draft, On, Origin, Shape, Wanted};
use super::encoding;
use super::fault::{Fault, line_of};
use super::ply_columns::{Arrays, Decorated};
use glam::DVec3;

/// A kind of number in a file.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Number {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Number {
    fn named(word: &str) -> Option<Self> {
        Some(match word.to_ascii_lowercase().as_str() {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "long" | "longlong" | "int64" => Self::I64,
            "ulong" | "ulonglong" | "uint64" => Self::U64,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }
}

/// A column of an element.
pub(super) struct Property {
    pub name: String,
    /// Of a list.
    pub count: Option<Number>,
    pub number: Number,
}

/// Rows with the same columns.
pub(super) struct Element {
    pub name: String,
    pub count: usize,
    pub properties: Vec<Property>,
}

#[derive(Clone, Copy, PartialEq)]
enum Encoding {
    Text,
    Little,
    Big,
}

/// Reads the elements `vertex` (x, y, z), `face` and `tristrips` (vertex_indices or vertex_index).
pub(super) fn parse(bytes: Vec<u8>, wanted: &Wanted) -> Result<Draft, Fault> {
    let is_text =
        encoding::first_lines(&bytes, 2).get(1).is_some_and(|line| line.to_ascii_lowercase().contains("ascii"));
    let bytes = if is_text { encoding::line_feeds(bytes) } else { bytes };
    let mut file = File { bytes: &bytes, at: 0, encoding: Encoding::Text };
    let elements = file.header()?;
    let mut draft = Draft::default();
    let mut cells = Cells::default();
    let mut are_vertices_declared = false;
    for element in &elements {
        file.check_count(element)?;
        match element.name.to_ascii_lowercase().as_str() {
            "vertex" | "vertices" => {
                are_vertices_declared = true;
                file.vertices(element, wanted, &mut draft)?;
            }
            "face" | "faces" => file.faces(element, Shape::Polygon, wanted, (&mut draft, &mut cells))?,
            "tristrips" => file.faces(element, Shape::Strip, wanted, (&mut draft, &mut cells))?,
            _ => (0..element.count).try_for_each(|row| file.row(element, row, |_, _, _| {}))?,
        }
    }
    for (name, is_declared) in [("vertex", are_vertices_declared), ("face", cells.are_declared)] {
        if !is_declared {
            return Err(Fault::new(format!("the header declares no element `{name}`; export the mesh with its faces")));
        }
    }
    cells.fill(&mut draft, file.encoding == Encoding::Text)?;
    Ok(draft)
}

/// Cells until all vertices are known: they may stand before them.
#[derive(Default)]
struct Cells {
    are_declared: bool,
    corners: Vec<i64>,
    /// Shape, end in `corners`, line or number.
    cells: Vec<(Shape, usize, usize)>,
}

impl Cells {
    fn fill(self, draft: &mut Draft, has_lines: bool) -> Result<(), Fault> {
        draft.origin = if has_lines { Origin::Line } else { Origin::Number("face") };
        let mut from = 0;
        for (cell, &(shape, end, place)) in self.cells.iter().enumerate() {
            let fault = |what: String| Fault { line: has_lines.then_some(place), what: format!("face {cell}: {what}") };
            let corners = &self.corners[from..end];
            from = end;
            // A strip ends at −1, and another begins.
            for part in corners.split(|&corner| shape == Shape::Strip && corner == -1).filter(|part| !part.is_empty()) {
                let corners: Option<Vec<u32>> = part.iter().map(|&corner| u32::try_from(corner).ok()).collect();
                let corners =
                    corners.ok_or_else(|| fault("it has a negative vertex index, or one too large".into()))?;
                draft.push_cell(shape, &corners, cell, place).map_err(fault)?;
            }
            if corners.is_empty() {
                return Err(fault("it has 0 corners, and at least three make a surface; correct or remove it".into()));
            }
        }
        Ok(())
    }
}

struct File<'a> {
    bytes: &'a [u8],
    at: usize,
    encoding: Encoding,
}

impl File<'_> {
    fn fault(&self, what: impl std::fmt::Display) -> Fault {
        let line = (self.encoding == Encoding::Text).then(|| line_of(self.bytes, self.at.saturating_sub(1)));
        Fault { line, what: what.to_string() }
    }

    fn line(&mut self) -> Option<String> {
        let rest = self.bytes.get(self.at..).filter(|rest| !rest.is_empty())?;
        let length = rest.iter().position(|byte| b"\r\n".contains(byte)).unwrap_or(rest.len());
        let line = rest[..length].iter().map(|&byte| char::from(byte)).collect();
        // A carriage return alone ends a line only where the data are not yet reached.
        let ends = if rest[length..].starts_with(b"\r\n") { 2 } else { 1 };
        self.at = (self.at + length + ends).min(self.bytes.len());
        Some(line)
    }

    fn header(&mut self) -> Result<Vec<Element>, Fault> {
        let again = "correct the line or export the file again";
        if !self.line().is_some_and(|line| line.trim().eq_ignore_ascii_case("ply")) {
            return Err(Fault::at(1, "not a PLY file: it must begin with `ply`"));
        }
        let mut elements: Vec<Element> = Vec::new();
        let mut encoding = None;
        loop {
            let line = self.line().ok_or_else(|| self.fault("the header does not end; export the file again"))?;
            let words: Vec<&str> = line.split_whitespace().collect();
            let keyword = words.first().map(|word| word.to_ascii_lowercase()).unwrap_or_default();
            match (keyword.as_str(), &words[words.len().min(1)..]) {
                ("" | "comment" | "obj_info", _) => {}
                ("format", [name, ..]) => {
                    encoding = Some(match name.to_ascii_lowercase().as_str() {
                        "ascii" => Encoding::Text,
                        "binary_little_endian" => Encoding::Little,
                        "binary_big_endian" => Encoding::Big,
                        _ => return Err(self.fault(format!("the format {name:?} is not read; {again}"))),
                    });
                }
                ("element", [name, count]) => {
                    let count = count.parse().map_err(|_| self.fault(format!("{count:?} is not a count; {again}")))?;
                    elements.push(Element { name: (*name).to_owned(), count, properties: Vec::new() });
                }
                ("property", kind) => {
                    let number = |word: &str| {
                        Number::named(word)
                            .ok_or_else(|| self.fault(format!("{word:?} is no type of numbers; {again}")))
                    };
                    let property = match *kind {
                        ["list", count, kind, name] => {
                            Property { name: name.to_owned(), count: Some(number(count)?), number: number(kind)? }
                        }
                        [kind, name] => Property { name: name.to_owned(), count: None, number: number(kind)? },
                        _ => return Err(self.fault(format!("{line:?} declares no property; {again}"))),
                    };
                    let element = elements.last_mut();
                    element
                        .ok_or_else(|| self.fault(format!("a property before any element; {again}")))?
                        .properties
                        .push(property);
                }
                ("end_header", _) => break,
                _ => return Err(self.fault(format!("{line:?} is no line of a PLY header; {again}"))),
            }
        }
        self.encoding =
            encoding.ok_or_else(|| self.fault("the header does not tell its format; export the file again"))?;
        Ok(elements)
    }

    /// Whether the file may hold what the header says, before anything of that size is made.
    fn check_count(&self, element: &Element) -> Result<(), Fault> {
        let left = self.bytes.len().saturating_sub(self.at);
        let bytes_each: usize = match self.encoding {
            // A digit and a blank or line break for each property; the last line may lack its break.
            Encoding::Text => 2 * element.properties.len(),
            _ => element.properties.iter().map(|property| property.count.unwrap_or(property.number).bytes()).sum(),
        };
        let fits = bytes_each > 0 && element.count.checked_mul(bytes_each).is_some_and(|needed| needed <= left + 1);
        if element.count == 0 || fits {
            return Ok(());
        }
        let Element { name, count, .. } = element;
        Err(Fault::new(format!(
            "the header promises {count} of element `{name}`, but only {left} bytes are left; the file is cut off or its header wrong: \
             export it again"
        )))
    }

    fn vertices(&mut self, element: &Element, wanted: &Wanted, draft: &mut Draft) -> Result<(), Fault> {
        let mut arrays = Arrays::new(element, On::Points, wanted, draft);
        let decorated = Decorated::of(element);
        let mut numbers = vec![f64::NAN; element.properties.len()];
        for row in 0..element.count {
            let mut position = DVec3::NAN;
            self.row(element, row, |place, value, is_list| {
                numbers[place] = value;
                match element.properties[place].name.as_str() {
                    _ if is_list => {}
                    "x" | "X" => position.x = value,
                    "y" | "Y" => position.y = value,
                    "z" | "Z" => position.z = value,
                    _ => {}
                }
                arrays.keep(place, value, is_list);
            })?;
            draft.positions.push(position);
            decorated.give(row as u32, &numbers, draft);
        }
        arrays.give(draft);
        decorated.names(element).for_each(|name| _ = draft.passed_over.remove(name));
        Ok(())
    }

    fn faces(
        &mut self,
        element: &Element,
        shape: Shape,
        wanted: &Wanted,
        (draft, cells): (&mut Draft, &mut Cells),
    ) -> Result<(), Fault> {
        cells.are_declared = true;
        let mut arrays = Arrays::new(element, On::Cells, wanted, draft);
        let is_corners = |property: &Property| {
            let name = property.name.to_ascii_lowercase();
            property.count.is_some() && (name == "vertex_indices" || name == "vertex_index")
        };
        let place = element.properties.iter().position(is_corners);
        // The lines of faces follow one another; blank ones between them would be counted as none.
        let mut line = if self.encoding == Encoding::Text { line_of(self.bytes, self.at) } else { 0 };
        for row in 0..element.count {
            let before = self.at;
            self.row(element, row, |property, value, is_list| {
                if Some(property) == place {
                    // What is no whole number is no index.
                    cells.corners.push(if value.fract() == 0.0 { value as i64 } else { i64::MIN });
                }
                arrays.keep(property, value, is_list);
            })?;
            let named = match self.encoding {
                Encoding::Text => {
                    let read = &self.bytes[before..self.at];
                    let blank = read.iter().take_while(|byte| byte.is_ascii_whitespace()).count();
                    line += read[..blank].iter().filter(|byte| **byte == b'\n').count();
                    let named = line;
                    line += read[blank..].iter().filter(|byte| **byte == b'\n').count();
                    named
                }
                _ => row,
            };
            cells.cells.push((shape, cells.corners.len(), named));
        }
        arrays.give(draft);
        Ok(())
    }

    /// Reads one row: each number with the place of its property and whether it is one of a list.
    fn row(&mut self, element: &Element, row: usize, mut take: impl FnMut(usize, f64, bool)) -> Result<(), Fault> {
        let cut_off = |me: &Self| {
            let what =
                format!("the file ends within row {row} of element `{}`; it is cut off: export it again", element.name);
            Fault { line: None, ..me.fault(what) }
        };
        for (place, property) in element.properties.iter().enumerate() {
            let Some(count) = property.count else {
                take(place, self.number(property.number)?.ok_or_else(|| cut_off(self))?, false);
                continue;
            };
            let count = self.number(count)?.ok_or_else(|| cut_off(self))?;
            if !(count >= 0.0 && count.fract() == 0.0) {
                return Err(
                    self.fault(format!("{count} is not the length of a list; correct it or export the file again"))
                );
            }
            for _ in 0..count as u64 {
                take(place, self.number(property.number)?.ok_or_else(|| cut_off(self))?, true);
            }
        }
        Ok(())
    }

    /// The next number; `None` at the end of the file.
    fn number(&mut self, kind: Number) -> Result<Option<f64>, Fault> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        if self.encoding == Encoding::Text {
            let start = rest.iter().take_while(|byte| byte.is_ascii_whitespace()).count();
            let length = rest[start..].iter().take_while(|byte| !byte.is_ascii_whitespace()).count();
            let word = str::from_utf8(&rest[start..start + length]).unwrap_or("?");
            self.at += start + length;
            let fault = || self.fault(format!("{word:?} is not a number; correct the line or export the file again"));
            return if length == 0 { Ok(None) } else { word.parse().map(Some).map_err(|_| fault()) };
        }
        let Some(bytes) = rest.get(..kind.bytes()) else { return Ok(None) };
        self.at += bytes.len();
        let mut eight = [0; 8];
        eight[..bytes.len()].copy_from_slice(bytes);
        if self.encoding == Encoding::Big {
            eight[..bytes.len()].reverse();
        }
        let low = u64::from_le_bytes(eight);
        Ok(Some(match kind {
            Number::I8 => f64::from(low as i8),
            Number::U8 => f64::from(low as u8),
            Number::I16 => f64::from(low as i16),
            Number::U16 => f64::from(low as u16),
            Number::I32 => f64::from(low as i32),
            Number::U32 => f64::from(low as u32),
            Number::I64 => low as i64 as f64,
            Number::U64 => low as f64,
            Number::F32 => f64::from(f32::from_bits(low as u32)),
            Number::F64 => f64::from_bits(low),
        }))
    }
}

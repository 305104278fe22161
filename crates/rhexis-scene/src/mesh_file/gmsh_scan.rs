//! Sections of a Gmsh file, text and binary: what all its versions have in common.

use super::draft::{Array, Draft, On, Wanted};
use super::encoding;
use super::fault::{Fault, line_of};
use std::collections::BTreeMap;

/// How a file writes its numbers.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum NumberFormat {
    /// As text.
    Text,
    /// Least byte first.
    LittleEndian,
    /// Greatest byte first.
    BigEndian,
}

/// A place in the file.
pub(super) struct Scanner<'a> {
    pub bytes: &'a [u8],
    pub at: usize,
    pub format: NumberFormat,
}

impl<'a> Scanner<'a> {
    pub(super) fn fault(&self, what: impl std::fmt::Display) -> Fault {
        let is_text = self.format == NumberFormat::Text;
        let line = is_text.then(|| line_of(self.bytes, self.at.saturating_sub(1)));
        Fault { line, what: format!("{what}; the file may be cut off: export it again from Gmsh") }
    }

    /// Goes behind the next line that is `tag`, from where it stands; whether there is one.
    pub(super) fn section(&mut self, tag: &[u8]) -> bool {
        let mut from = self.at;
        while let Some(found) = self.bytes[from..].windows(tag.len()).position(|window| window == tag) {
            let (start, end) = (from + found, from + found + tag.len());
            let is_line = start == 0 || self.bytes[start - 1] == b'\n';
            match self.bytes[end..] {
                [b'\n', ..] if is_line => {
                    self.at = end + 1;
                    return true;
                }
                [b'\r', b'\n', ..] if is_line => {
                    self.at = end + 2;
                    return true;
                }
                _ => from = end,
            }
        }
        false
    }

    /// The next line.
    pub(super) fn line(&mut self) -> Result<String, Fault> {
        let rest = self.bytes.get(self.at..).filter(|rest| !rest.is_empty());
        let rest = rest.ok_or_else(|| self.fault("the file ends within a section"))?;
        let length = rest.iter().position(|byte| *byte == b'\n').map_or(rest.len(), |end| end + 1);
        self.at += length;
        Ok(rest[..length].iter().map(|&byte| char::from(byte)).collect::<String>().trim().to_owned())
    }

    /// A line that holds a count of rows of `least` bytes each: no more than the file may hold.
    pub(super) fn count(&mut self, least: usize) -> Result<usize, Fault> {
        let line = self.line()?;
        let count: usize = line.parse().map_err(|_| self.fault(format!("{line:?} is not a count")))?;
        let left = self.bytes.len() - self.at;
        if count.checked_mul(least).is_none_or(|needed| needed > left + 1) {
            return Err(self.fault(format!("{count} rows are announced, but only {left} bytes are left")));
        }
        Ok(count)
    }

    fn word(&mut self) -> Result<&'a str, Fault> {
        let bytes: &'a [u8] = self.bytes;
        let rest = bytes.get(self.at..).unwrap_or_default();
        let start = rest.iter().take_while(|byte| byte.is_ascii_whitespace()).count();
        let length = rest[start..].iter().take_while(|byte| !byte.is_ascii_whitespace()).count();
        self.at += start + length;
        match length {
            0 => Err(self.fault("the file ends within a section")),
            _ => Ok(str::from_utf8(&rest[start..start + length]).unwrap_or("?")),
        }
    }

    fn four(&mut self) -> Result<[u8; 4], Fault> {
        let four = self.bytes.get(self.at..).and_then(|rest| rest.first_chunk::<4>()).copied();
        self.at += 4;
        four.ok_or_else(|| self.fault("the file ends within a section"))
    }

    /// The next whole number: a word, or four bytes.
    pub(super) fn integer(&mut self) -> Result<u64, Fault> {
        let number = match self.format {
            NumberFormat::Text => {
                let word = self.word()?;
                return word.parse().map_err(|_| self.fault(format!("{word:?} is not a whole number")));
            }
            NumberFormat::LittleEndian => i32::from_le_bytes(self.four()?),
            NumberFormat::BigEndian => i32::from_be_bytes(self.four()?),
        };
        u64::try_from(number).map_err(|_| self.fault(format!("{number} is not a number of a node or element")))
    }

    /// The next number: a word, or eight bytes.
    pub(super) fn real(&mut self) -> Result<f64, Fault> {
        if self.format == NumberFormat::Text {
            let word = self.word()?;
            return encoding::number(word).ok_or_else(|| self.fault(format!("{word:?} is not a number")));
        }
        let eight = self.bytes.get(self.at..).and_then(|rest| rest.first_chunk::<8>()).copied();
        self.at += 8;
        let eight = eight.ok_or_else(|| self.fault("the file ends within a section"))?;
        Ok(if self.format == NumberFormat::LittleEndian {
            f64::from_le_bytes(eight)
        } else {
            f64::from_be_bytes(eight)
        })
    }
}

/// Rows of nodes or elements by the tags that the file gives them, ascending.
#[derive(Default)]
pub(super) struct Tags(Vec<(u64, u32)>);

impl Tags {
    pub(super) fn new(mut tags: Vec<(u64, u32)>) -> Self {
        tags.sort_unstable();
        Self(tags)
    }

    pub(super) fn has_twice(&self) -> bool {
        self.0.windows(2).any(|pair| pair[0].0 == pair[1].0)
    }

    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    pub(super) fn row(&self, tag: u64) -> Option<u32> {
        self.0.binary_search_by_key(&tag, |(tag, _)| *tag).ok().map(|place| self.0[place].1)
    }
}

/// Vertices of physical groups, by dimension and tag.
pub(super) type Groups = BTreeMap<(u64, u64), Vec<u32>>;

/// The groups by their names, or by their tags where they have none.
pub(super) fn named(groups: Groups, scanner: &mut Scanner) -> Result<Vec<(String, Vec<u32>)>, Fault> {
    let mut names: BTreeMap<(u64, u64), String> = BTreeMap::new();
    scanner.at = 0;
    if scanner.section(b"$PhysicalNames") {
        for _ in 0..scanner.count(6)? {
            let line = scanner.line()?;
            let mut parts = line.splitn(3, char::is_whitespace);
            let mut number = || parts.next().and_then(|word| word.parse::<u64>().ok());
            let key = number().zip(number());
            let name = parts.next().unwrap_or_default().trim().trim_matches('"').to_owned();
            names.insert(key.ok_or_else(|| scanner.fault(format!("{line:?} names no group")))?, name);
        }
    }
    let mut out: BTreeMap<String, Vec<u32>> = BTreeMap::new();
    for ((dimension, tag), members) in groups {
        let name = names.get(&(dimension, tag)).cloned().unwrap_or_else(|| tag.to_string());
        out.entry(name).or_default().extend(members);
    }
    Ok(out.into_iter().collect())
}

/// Reads the arrays that are asked for: values of elements that make triangles, and of nodes.
pub(super) fn arrays(
    scanner: &mut Scanner,
    (nodes, elements): (&Tags, &Tags),
    wanted: &Wanted,
    draft: &mut Draft,
) -> Result<(), Fault> {
    for (section, on, tags) in [(&b"$NodeData"[..], On::Points, nodes), (b"$ElementData", On::Cells, elements)] {
        scanner.at = 0;
        while scanner.section(section) {
            let list = |scanner: &mut Scanner| -> Result<Vec<String>, Fault> {
                let count = scanner.count(1)?;
                (0..count).map(|_| scanner.line()).collect()
            };
            let name = list(scanner)?.first().map(|name| name.trim_matches('"').to_owned()).unwrap_or_default();
            list(scanner)?;
            let numbers = list(scanner)?;
            let number = |place: usize| numbers.get(place).and_then(|word| word.parse::<usize>().ok());
            if !wanted.has(&name) {
                draft.passed_over.insert(name);
                continue;
            }
            // Of several times the first.
            if draft.arrays.iter().any(|array| array.on == on && array.name == name) {
                continue;
            }
            let (Some(components @ 1..=9), Some(rows)) = (number(1), number(2)) else {
                return Err(scanner.fault(format!("the array {name:?} does not tell its components and rows")));
            };
            let count = if on == On::Points { draft.positions.len() } else { tags.len() };
            let mut values = vec![f64::NAN; components * count];
            for _ in 0..rows {
                let tag = scanner.integer()?;
                let row = tags.row(tag);
                for component in 0..components {
                    let value = scanner.real()?;
                    // Values of elements that make no triangle belong to nothing.
                    if let Some(slot) = row.and_then(|row| values.get_mut(components * row as usize + component)) {
                        *slot = value;
                    }
                }
            }
            draft.arrays.push(Array { name, on, components, values });
        }
    }
    Ok(())
}

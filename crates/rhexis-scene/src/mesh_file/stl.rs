//! STL, text and binary. A triangle soup: vertices with the same coordinates become one.

use std::collections::HashMap;

use glam::DVec3;

use super::draft::{Draft, Origin, Shape, Wanted};
use super::encoding;
use super::fault::Fault;

/// Header and count of a binary file, and one of its triangles \[bytes\].
const HEADER: usize = 84;
const TRIANGLE: usize = 50;

/// Reads all solids as one surface; normals are not read, the order of the corners tells them.
pub(super) fn parse(bytes: Vec<u8>, _: &Wanted) -> Result<Draft, Fault> {
    let claimed = bytes.get(80..HEADER).and_then(|count| <[u8; 4]>::try_from(count).ok()).map(u32::from_le_bytes);
    let binary_length = claimed.map(|count| HEADER + TRIANGLE * count as usize);
    // Binary headers may start with "solid" too: the length tells, or else that text has no zero bytes.
    let looks_like_text = bytes.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"))
        && !bytes[..bytes.len().min(1024)].contains(&0);
    match binary_length {
        Some(length) if length == bytes.len() => Ok(binary(&bytes[HEADER..])),
        _ if looks_like_text => text(&encoding::text(bytes)),
        // Some leave the count at zero.
        Some(HEADER) if (bytes.len() - HEADER).is_multiple_of(TRIANGLE) => Ok(binary(&bytes[HEADER..])),
        // What follows the last triangle belongs to other programs.
        Some(length) if length < bytes.len() => Ok(binary(&bytes[HEADER..length])),
        Some(length) => Err(Fault::new(format!(
            "neither STL text (\"solid …\") nor binary STL: {} triangles would take {length} bytes, the file has {}; export it again",
            (length - HEADER) / TRIANGLE,
            bytes.len()
        ))),
        None => Err(Fault::new("too short for an STL file; export it again")),
    }
}

/// Rows of positions by their bits.
#[derive(Default)]
struct Rows(HashMap<[u64; 3], u32>);

impl Rows {
    fn row(&mut self, position: [f64; 3], draft: &mut Draft) -> u32 {
        // Adding zero makes −0 and +0 the same bits.
        let position = position.map(|x| x + 0.0);
        *self.0.entry(position.map(f64::to_bits)).or_insert_with(|| {
            draft.positions.push(DVec3::from(position));
            (draft.positions.len() - 1) as u32
        })
    }
}

fn binary(triangles: &[u8]) -> Draft {
    let mut draft = Draft { is_soup: true, origin: Origin::Number("facet"), ..Draft::default() };
    let mut rows = Rows::default();
    for (number, triangle) in triangles.as_chunks::<TRIANGLE>().0.iter().enumerate() {
        let numbers = triangle[12..48].as_chunks::<4>().0;
        let at = |corner: usize| [0, 1, 2].map(|axis| f64::from(f32::from_le_bytes(numbers[3 * corner + axis])));
        let corners = [0, 1, 2].map(|corner| rows.row(at(corner), &mut draft));
        draft.triangles.push(corners);
        draft.cells.push(number as u32);
        draft.places.push(number as u32);
    }
    draft
}

fn text(text: &str) -> Result<Draft, Fault> {
    let mut draft = Draft { is_soup: true, origin: Origin::Line, ..Draft::default() };
    let mut rows = Rows::default();
    let mut facet: Option<(usize, Vec<u32>)> = None;
    let mut count = 0;
    for (number, line) in text.lines().enumerate() {
        let number = number + 1;
        let mut words = line.split_whitespace();
        let keyword = words.next().unwrap_or_default().to_ascii_lowercase();
        let second = words.clone().next().unwrap_or_default();
        let ends = |what: &str| {
            keyword
                .strip_prefix("end")
                .is_some_and(|rest| rest == what || rest.is_empty() && second.eq_ignore_ascii_case(what))
        };
        match keyword.as_str() {
            "facet" if facet.is_none() => facet = Some((number, Vec::new())),
            "facet" => return Err(Fault::at(number, "the facet before this one does not end; add its `endfacet`")),
            "vertex" => {
                let numbers: Option<Vec<f64>> = words.map(|word| word.parse().ok()).collect();
                let place = match (numbers.as_deref(), &mut facet) {
                    (Some(&[x, y, z]), Some((_, corners))) => Some(([x, y, z], corners)),
                    _ => None,
                };
                let what = "a vertex is three numbers within a facet, as in `vertex 0 0.5 1`; correct the line";
                let (position, corners) = place.ok_or_else(|| Fault::at(number, what))?;
                corners.push(rows.row(position, &mut draft));
            }
            _ if ends("facet") => {
                let what = "no facet has begun here; correct the line or export the file again";
                let (line, corners) = facet.take().ok_or_else(|| Fault::at(number, what))?;
                draft.push_cell(Shape::Polygon, &corners, count, line).map_err(|what| Fault::at(line, what))?;
                count += 1;
            }
            "" | "solid" | "endsolid" | "outer" | "endloop" | "color" => {}
            _ if ends("solid") || ends("loop") => {}
            other => {
                let what = format!("{other:?} is no word of an STL file; correct the line or export the file again");
                return Err(Fault::at(number, what));
            }
        }
    }
    match facet {
        Some((line, _)) => Err(Fault::at(line, "the file ends within this facet; it is cut off: export it again")),
        None => Ok(draft),
    }
}

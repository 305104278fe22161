//! OFF, the object file format of Geomview, as text: vertices and polygons; colours, normals and texture coordinates are passed over.

use glam::DVec3;

use super::draft::{Draft, Origin, Shape, Wanted};
use super::encoding;
use super::fault::Fault;

/// Reads the polygons.
pub(super) fn parse(bytes: Vec<u8>, _: &Wanted) -> Result<Draft, Fault> {
    let text = encoding::text(bytes);
    let lines = text.lines().enumerate().map(|(number, line)| {
        let words = line.split('#').next().unwrap_or_default().split_whitespace();
        (number + 1, words.collect::<Vec<_>>())
    });
    let mut lines = lines.filter(|(_, words)| !words.is_empty()).peekable();
    let not_off = || Fault::at(1, "not an OFF file: it must begin with `OFF`");
    let (number, mut head) = lines.next().ok_or_else(not_off)?;
    // The counts often follow the keyword without a blank.
    let glued = head[0].get(..3).filter(|word| word.eq_ignore_ascii_case("off")).and_then(|_| head[0].get(3..));
    if let Some(count) = glued.filter(|count| count.starts_with(|c: char| c.is_ascii_digit())) {
        head.splice(0..1, ["OFF", count]);
    }
    let has_keyword = head[0].to_uppercase().ends_with("OFF");
    if has_keyword {
        let keyword = head.remove(0);
        if head.first().is_some_and(|word| word.eq_ignore_ascii_case("binary")) {
            return Err(Fault::at(number, "binary OFF is not read; save it as text"));
        }
        if keyword.contains(['4', 'n']) && keyword.ends_with("OFF") {
            return Err(Fault::at(
                number,
                format!("{keyword} has other than three coordinates a vertex; save it as plain OFF"),
            ));
        }
    }
    let counts = if head.is_empty() { lines.next().map(|(_, words)| words).unwrap_or_default() } else { head };
    let counts: Option<Vec<usize>> = counts.iter().take(2).map(|word| word.parse().ok()).collect();
    let Some([vertices, faces]) = counts.and_then(|counts| <[usize; 2]>::try_from(counts).ok()) else {
        let what = if has_keyword {
            "the numbers of vertices and faces are missing; save the file again".into()
        } else {
            not_off().what
        };
        return Err(Fault::at(number, what));
    };
    let mut draft = Draft { origin: Origin::Line, ..Draft::default() };
    let cut_off =
        |what: &str| Fault::new(format!("the file ends before its last {what}; it is cut off: save it again"));
    for _ in 0..vertices {
        let (line, words) = lines.next().ok_or_else(|| cut_off("vertex"))?;
        let numbers: Option<Vec<f64>> = words.iter().take(3).map(|word| word.parse().ok()).collect();
        match numbers.as_deref() {
            Some(&[x, y, z]) => draft.positions.push(DVec3::new(x, y, z)),
            _ => return Err(Fault::at(line, "a vertex needs three numbers; correct the line")),
        }
    }
    for cell in 0..faces {
        let (line, words) = lines.next().ok_or_else(|| cut_off("face"))?;
        let corners: Option<Vec<u32>> = words.first().and_then(|count| count.parse::<usize>().ok()).and_then(|count| {
            let corners = words.get(1..count.checked_add(1)?)?;
            corners.iter().map(|word| word.parse().ok()).collect()
        });
        let what = "a face is its number of corners and as many vertices, as in `3 0 1 2`; correct the line";
        let corners = corners.ok_or_else(|| Fault::at(line, what))?;
        // Points and lines stand among the faces.
        let shape = if corners.len() < 3 { Shape::Thin } else { Shape::Polygon };
        draft.push_cell(shape, &corners, cell, line).map_err(|what| Fault::at(line, what))?;
    }
    Ok(draft)
}

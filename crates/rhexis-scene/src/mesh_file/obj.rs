//! Wavefront OBJ: vertices and faces in the order of the file, groups and objects by their names.
//!
//! Read here: vertices keep the numbers of the file, where readers on offer split those with several texture coordinates. Of these a
//! vertex has the first that a face gives it, and a corner its own; normals are averaged; an index of either that is not there gives nothing.

use std::collections::BTreeMap;

use glam::DVec3;

use rhexis::components::Channel;

use super::draft::{Draft, Origin, Shape, Wanted};
use super::encoding;
use super::fault::Fault;

/// The most groups that a line may put its faces into: each face goes into all of them.
const MOST_GROUPS: usize = 8;

/// Reads the faces of all groups as one surface.
pub(super) fn parse(bytes: Vec<u8>, _: &Wanted) -> Result<Draft, Fault> {
    let text = encoding::text(bytes);
    let mut draft = Draft { origin: Origin::Line, ..Draft::default() };
    let (mut corners, mut faces) = (Vec::new(), Vec::new());
    let mut beside = Beside::default();
    let mut groups: BTreeMap<String, Vec<u32>> = BTreeMap::new();
    let (mut current, mut object): (Vec<String>, Vec<String>) = (Vec::new(), Vec::new());
    let mut lines = Lines { rest: text.lines(), number: 0 };
    while let Some((number, words)) = lines.next_words() {
        let mut words = words.into_iter();
        match words.next() {
            Some("v" | "V") => {
                let row = draft.positions.len() as u32;
                let numbers: Option<Vec<f64>> = words.by_ref().take(3).map(|word| word.parse().ok()).collect();
                match numbers.as_deref() {
                    Some(&[x, y, z]) => {
                        draft.positions.push(DVec3::new(x, y, z));
                        let [r, g, b] = numbers_of(words);
                        draft.decoration.give(Channel::Colour, row, &[r, g, b, 1.0]);
                    }
                    _ => return Err(Fault::at(number, "a vertex needs three numbers, as in `v 0 0.5 1`")),
                }
            }
            Some("f" | "F") => {
                let first = corners.len();
                for word in words {
                    corners.push(corner(word, draft.positions.len(), number)?);
                    beside.note(word);
                }
                if corners.len() < first + 3 {
                    return Err(too_few(number));
                }
                for name in current.iter().chain(&object) {
                    if let Some(members) = groups.get_mut(name) {
                        members.extend(corners[first..].iter().filter_map(|&corner| u32::try_from(corner).ok()));
                    }
                }
                faces.push((number, first..corners.len()));
            }
            Some("vt") => beside.texture.push(numbers_of(words)),
            Some("vn") => beside.normals.push(numbers_of(words)),
            Some("g") => current = words.take(MOST_GROUPS).map(str::to_owned).collect(),
            Some("o") => object = words.next().map(str::to_owned).into_iter().collect(),
            _ => continue,
        }
        for name in current.iter().chain(&object) {
            if !groups.contains_key(name) {
                groups.insert(name.clone(), Vec::new());
            }
        }
    }
    let count = draft.positions.len();
    draft.decoration.vertices = count;
    for (cell, (line, range)) in faces.into_iter().enumerate() {
        let face: Vec<u32> = corners[range]
            .iter()
            .map(|&corner| u32::try_from(corner).ok().filter(|&corner| (corner as usize) < count).ok_or(corner))
            .collect::<Result<_, i64>>()
            .map_err(|corner| {
                let what = format!(
                    "the face names vertex {}, but there are only {count} (1 to {count})",
                    corner.saturating_add(1)
                );
                Fault::at(line, format!("{what}; correct the index"))
            })?;
        let first = draft.triangles.len();
        draft.push_cell(Shape::Polygon, &face, cell, line).map_err(|what| Fault::at(line, what))?;
        beside.give(&face, first, &mut draft);
    }
    draft.groups = groups.into_iter().filter(|(_, members)| !members.is_empty()).collect();
    Ok(draft)
}

/// The first numbers of a line; NaN where a word is none.
fn numbers_of<'a, const N: usize>(words: impl Iterator<Item = &'a str>) -> [f64; N] {
    let mut numbers = [f64::NAN; N];
    numbers.iter_mut().zip(words).for_each(|(number, word)| *number = word.parse().unwrap_or(f64::NAN));
    numbers
}

/// Texture coordinates and normals, and the corners that name them.
#[derive(Default)]
struct Beside {
    texture: Vec<[f64; 2]>,
    normals: Vec<[f64; 3]>,
    /// Per corner their rows.
    of_corner: Vec<[Option<u32>; 2]>,
    /// Corners whose vertices have been given theirs.
    given: usize,
    /// Rows of the decoration by vertex and texture coordinate, where the vertex has another one.
    rows: BTreeMap<(u32, usize), u32>,
}

impl Beside {
    /// Notes what a corner as in `1/2/3` names; a negative index counts back from the last one read so far.
    fn note(&mut self, word: &str) {
        let mut parts = word.split('/').skip(1);
        let counts = [self.texture.len(), self.normals.len()];
        self.of_corner.push(counts.map(|seen| {
            let index: i64 = parts.next()?.parse().ok()?;
            let row = if index < 0 { (seen as i64).checked_add(index)? } else { index - 1 };
            u32::try_from(row).ok()
        }));
    }

    /// Texture coordinates and normals of a face, for its vertices and for the corners of its triangles from `first` on.
    fn give(&mut self, face: &[u32], first: usize, draft: &mut Draft) {
        for (&vertex, of_corner) in face.iter().zip(&self.of_corner[self.given..]) {
            let [texture, normal] = of_corner.map(|row| row.map_or(usize::MAX, |row| row as usize));
            if let Some(uv) = self.texture.get(texture)
                && !draft.decoration.give(Channel::TextureCoordinates, vertex, uv)
            {
                let row = self.rows.entry((vertex, texture)).or_insert_with(|| draft.decoration.add(*uv));
                let corners = draft.triangles[first..].iter().zip(&mut draft.textured[first..]);
                corners
                    .flat_map(|(corners, rows)| corners.iter().zip(rows))
                    .filter(|(corner, _)| **corner == vertex)
                    .for_each(|(_, own)| *own = *row);
            }
            if let Some(normal) = self.normals.get(normal) {
                draft.decoration.give(Channel::Normal, vertex, normal);
            }
        }
        self.given += face.len();
    }
}

/// The row, from 0, that `1/2/3` names among the positions; a negative index counts back from the last of `seen`. Whether there are so
/// many is known at the end of the file.
fn corner(word: &str, seen: usize, line: usize) -> Result<i64, Fault> {
    let index: Option<i64> = word.split('/').next().and_then(|index| index.parse().ok());
    match index.ok_or_else(|| too_few(line))? {
        index if index > 0 => Ok(index - 1),
        index if index < 0 && (seen as i64).saturating_add(index) >= 0 => Ok(seen as i64 + index),
        index => {
            let what = format!(
                "the face names vertex {index}, but there are only {seen} before it (1 to {seen}, or −1 to −{seen})"
            );
            Err(Fault::at(line, format!("{what}; correct the index")))
        }
    }
}

fn too_few(line: usize) -> Fault {
    Fault::at(line, "a face needs at least three vertex indices, as in `f 1 2 3`; correct or remove it")
}

/// Lines without comments; one that ends in a backslash goes on in the next.
struct Lines<'a> {
    rest: std::str::Lines<'a>,
    number: usize,
}

impl<'a> Lines<'a> {
    /// The words of the next line, and its number from 1.
    fn next_words(&mut self) -> Option<(usize, Vec<&'a str>)> {
        let first = self.number + 1;
        let mut words = Vec::new();
        loop {
            let line = self.rest.next();
            self.number += 1;
            let Some(line) = line else { return (!words.is_empty()).then_some((first, words)) };
            let line = line.split('#').next().unwrap_or_default().trim_end();
            let part = line.strip_suffix('\\');
            words.extend(part.unwrap_or(line).split_whitespace());
            if part.is_none() {
                return Some((first, words));
            }
        }
    }
}

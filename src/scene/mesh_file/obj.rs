//! Wavefront OBJ, by `tobj`.
//!
//! `tobj` sees only the vertices and faces of the file, reduced to positions and position indices: colours, textures, groups and
//! materials would split one surface into many, and an absurd texture index would overflow in its arithmetic.
//! Vertices come in the order of their first use.

use std::cell::Cell;
use std::io::{self, BufRead, Read};

use tobj::{LoadError, LoadOptions};

use super::fault::Fault;
use super::surface::{Shape, points, push_cell};
use crate::storage::TriangleMesh;

/// Reads the faces of all groups as one surface.
pub fn parse(bytes: Vec<u8>) -> Result<TriangleMesh, Fault> {
    let text = String::from_utf8(bytes).map_err(|_| Fault::new("not text; save the mesh as a plain OBJ file"))?;
    let faces = face_lines(&text)?;
    let line = Cell::new(0);
    let mut reader = Geometry { lines: text.lines(), line: &line, pending: Vec::new(), at: 0 };
    let options = LoadOptions { ignore_points: true, ignore_lines: true, ..LoadOptions::default() };
    let loaded = tobj::load_obj_buf(&mut reader, &options, |_| Err(LoadError::MaterialParseError));
    let (models, _) = loaded.map_err(|error| match error {
        LoadError::FaceVertexOutOfBounds => index_fault(&text),
        LoadError::PositionParseError => Fault::at(line.get(), "a vertex needs three numbers, as in `v 0 0.5 1`"),
        LoadError::FaceParseError | LoadError::InvalidPolygon => too_few(line.get()),
        other => Fault::at(line.get(), other),
    })?;
    let mut mesh = TriangleMesh::default();
    let mut faces = faces.into_iter();
    for model in models {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(points(&model.mesh.positions));
        let corners: Vec<u32> = model.mesh.indices.iter().map(|corner| first + corner).collect();
        let mut rest = &corners[..];
        // Without counts of corners all faces are triangles.
        let mut counts = model.mesh.face_arities.iter().map(|&count| count as usize).chain(std::iter::repeat(3));
        while let Some((face, after)) = counts.next().and_then(|count| rest.split_at_checked(count.max(1))) {
            let line = faces.next();
            push_cell(&mut mesh, Shape::Polygon, face, None).map_err(|what| Fault { line, what })?;
            rest = after;
        }
    }
    Ok(mesh)
}

/// The lines of the faces in their order. One with two corners is a line to `tobj`, and would be a hole in the surface.
fn face_lines(text: &str) -> Result<Vec<usize>, Fault> {
    let mut lines = Vec::new();
    for (number, line) in text.lines().enumerate() {
        match split(line) {
            Some(("f", words)) if words.clone().count() < 3 => return Err(too_few(number + 1)),
            Some(("f", _)) => lines.push(number + 1),
            _ => {}
        }
    }
    Ok(lines)
}

fn too_few(line: usize) -> Fault {
    Fault::at(line, "a face needs at least three vertex indices, as in `f 1 2 3`; correct or remove it")
}

/// The file's `v` and `f` lines without colours, weights, texture and normal indices, handed out one at a time, so that
/// `line` is the one `tobj` is reading.
struct Geometry<'a> {
    lines: std::str::Lines<'a>,
    line: &'a Cell<usize>,
    pending: Vec<u8>,
    at: usize,
}

impl BufRead for Geometry<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        while self.at >= self.pending.len() {
            let Some(line) = self.lines.next() else { break };
            self.line.set(self.line.get() + 1);
            let reduced = match split(line) {
                Some(("v", words)) => ["v"].into_iter().chain(words.take(3)).collect::<Vec<_>>(),
                Some(("f", words)) => ["f"].into_iter().chain(words.map(position_index)).collect(),
                _ => continue,
            };
            self.pending = (reduced.join(" ") + "\n").into_bytes();
            self.at = 0;
        }
        Ok(&self.pending[self.at..])
    }

    fn consume(&mut self, count: usize) {
        self.at = (self.at + count).min(self.pending.len());
    }
}

impl Read for Geometry<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.fill_buf()?.read(buffer)?;
        self.consume(count);
        Ok(count)
    }
}

/// The part of `1/2/3` that names the position; something that is no index where that is missing.
fn position_index(word: &str) -> &str {
    word.split('/').next().filter(|index| !index.is_empty()).unwrap_or("?")
}

fn split(line: &str) -> Option<(&str, std::str::SplitWhitespace<'_>)> {
    let mut words = line.split('#').next().unwrap_or_default().split_whitespace();
    Some((words.next()?, words))
}

/// Finds the line of the index that `tobj` refused without naming it.
fn index_fault(text: &str) -> Fault {
    let count = text.lines().filter(|line| matches!(split(line), Some(("v", _)))).count();
    let mut seen = 0i64;
    for (number, line) in text.lines().enumerate() {
        match split(line) {
            Some(("v", _)) => seen += 1,
            Some(("f", words)) => {
                for index in words.filter_map(|word| position_index(word).parse::<i64>().ok()) {
                    if index == 0 || index > count as i64 || index < -seen {
                        let what = format!("the face names vertex {index}, but there are only {count} (1 to {count})");
                        return Fault::at(number + 1, format!("{what}; correct the index"));
                    }
                }
            }
            _ => {}
        }
    }
    Fault::new("a face names a vertex that does not exist; correct the index")
}

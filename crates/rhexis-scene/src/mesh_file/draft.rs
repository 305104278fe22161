//! What a reader finds, before it is joined, turned and judged.

use std::collections::BTreeSet;
use std::path::Path;

use glam::DVec3;

use super::decoration::Decoration;
use super::polygon;
use crate::files::Files;

/// How the corners of a cell make triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Shape {
    /// Three corners.
    Triangle,
    /// A flat polygon of four corners.
    Quad,
    /// A flat polygon, convex or not.
    Polygon,
    /// A strip: each corner after the second makes a triangle with the two before it.
    Strip,
    /// A quad in raster order: the last two corners swapped.
    Pixel,
    /// A point or a line: makes none.
    Thin,
}

/// The shape of a VTK cell type; an error for curved and solid ones.
pub(super) fn vtk_shape(cell_type: u64) -> Result<Shape, String> {
    match cell_type {
        0..=4 => Ok(Shape::Thin),
        5 => Ok(Shape::Triangle),
        6 => Ok(Shape::Strip),
        7 => Ok(Shape::Polygon),
        8 => Ok(Shape::Pixel),
        9 => Ok(Shape::Quad),
        _ => Err(format!(
            "VTK cell type {cell_type} is curved or solid; extract the surface and save it as linear triangles \
             (ParaView: Extract Surface, then Triangulate)"
        )),
    }
}

/// What the values of an array belong to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum On {
    /// Vertices.
    Points,
    /// Triangles; in a draft, cells of the file.
    Cells,
}

/// Named numbers of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    /// Its name, as the file writes it.
    pub name: String,
    /// Whether it has a row per vertex or per triangle.
    pub on: On,
    /// Numbers per row.
    pub components: usize,
    /// The rows, one after the other.
    pub values: Vec<f64>,
}

impl Array {
    /// The array without its numbers.
    pub(super) fn clone_head(&self) -> Self {
        Self { name: self.name.clone(), values: Vec::new(), ..*self }
    }
}

/// What a triangle is called in messages: where a reader has lines, by the line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Origin {
    /// A line, counted from 1.
    Line,
    /// A cell, face or element by the word, counted as the format does.
    Number(&'static str),
    /// Nothing better than the triangle's own number.
    #[default]
    Triangle,
}

/// A surface as the file has it.
#[derive(Debug, Default)]
pub(super) struct Draft {
    /// All its points \[mm\].
    pub positions: Vec<DVec3>,
    /// Corners.
    pub triangles: Vec<[u32; 3]>,
    /// The row of each triangle's cell in the cell arrays.
    pub cells: Vec<u32>,
    /// Line or number of each triangle.
    pub places: Vec<u32>,
    /// The number of each triangle among those of the file, once these are all there.
    pub rows: Vec<u32>,
    /// What `places` are.
    pub origin: Origin,
    /// The first triangle of each polygon that crosses itself, is folded or overlaps, ascending.
    pub folded: Vec<u32>,
    /// Arrays that were asked for.
    pub arrays: Vec<Array>,
    /// Names of the other arrays.
    pub passed_over: BTreeSet<String>,
    /// Names with the vertices they stand for: Gmsh's physical groups, OBJ's groups and objects.
    pub groups: Vec<(String, Vec<u32>)>,
    /// Whether the format cannot say that triangles share a vertex.
    pub is_soup: bool,
    /// Texture coordinates, normals and colours.
    pub decoration: Decoration,
    /// The row of the decoration that has the texture coordinate of each corner.
    pub textured: Vec<[u32; 3]>,
    /// Rows that were joined to others, ascending.
    pub joined: Vec<(u32, u32)>,
}

impl Draft {
    /// Appends the triangles of one cell: its row among the cells of the file, and its line or number. The positions of its corners
    /// stand in the draft.
    ///
    /// # Errors
    /// For a number of corners that does not make the shape, and for a polygon of too many.
    pub(super) fn push_cell(&mut self, shape: Shape, corners: &[u32], cell: usize, place: usize) -> Result<(), String> {
        let (name, fits) = match shape {
            Shape::Triangle => ("a triangle has three", corners.len() == 3),
            Shape::Quad | Shape::Pixel => ("a quad has four", corners.len() == 4),
            Shape::Polygon | Shape::Strip => ("at least three make a surface", corners.len() >= 3),
            Shape::Thin => return Ok(()),
        };
        if !fits {
            return Err(format!("it has {} corners, and {name}; correct or remove it", corners.len()));
        }
        match (shape, corners) {
            (Shape::Strip, _) => self.triangles.extend(corners.windows(3).enumerate().map(|(number, three)| {
                let [a, b, c] = [three[0], three[1], three[2]];
                if number % 2 == 0 { [a, b, c] } else { [b, a, c] }
            })),
            (Shape::Pixel, &[a, b, c, d]) => self.fill(&[a, b, d, c])?,
            (_, &[a, b, c]) => self.triangles.push([a, b, c]),
            _ => self.fill(corners)?,
        }
        self.cells.resize(self.triangles.len(), u32::try_from(cell).unwrap_or(u32::MAX));
        self.places.resize(self.triangles.len(), u32::try_from(place).unwrap_or(u32::MAX));
        self.textured.extend_from_slice(&self.triangles[self.textured.len()..]);
        Ok(())
    }

    fn fill(&mut self, corners: &[u32]) -> Result<(), String> {
        let filled = polygon::triangles(&self.positions, corners)?;
        if filled.is_folded {
            self.folded.push(self.triangles.len() as u32);
        }
        self.triangles.extend(filled.triangles);
        Ok(())
    }
}

/// Which arrays of a file a scene asks for.
#[derive(Clone, Debug, Default)]
pub(super) struct Wanted<'a> {
    /// Names that must be there.
    pub names: Vec<&'a str>,
    /// Whether the usual names of fibres count as asked for.
    pub fibres: bool,
    /// The file's path and the files beside it, where it may keep data in those.
    pub beside: Option<(&'a Path, &'a Files)>,
}

/// The names by which programs call fibre directions, in lower case.
const FIBRE_NAMES: [&str; 6] = ["fibre", "fiber", "fibres", "fibers", "f0", "fibre_direction"];

/// Whether programs call fibre directions by this name.
pub(super) fn is_fibre_name(name: &str) -> bool {
    let name = name.trim().to_lowercase();
    FIBRE_NAMES.contains(&name.as_str()) || name == "fiber_direction"
}

impl Wanted<'_> {
    /// Whether the array's numbers are asked for.
    pub(super) fn has(&self, name: &str) -> bool {
        self.names.contains(&name) || self.fibres && is_fibre_name(name)
    }
}

/// Points from a flat list of coordinates.
pub(super) fn points(coordinates: &[f64]) -> Vec<DVec3> {
    coordinates.chunks_exact(3).map(|p| DVec3::new(p[0], p[1], p[2])).collect()
}

//! `mesh = …`: where a body's triangles come from.

use super::mesh_file::FileSpec;
use super::{Exactly, Point};
use serde::Deserialize;

/// `mesh = { grid = { … } }` and its kin: exactly one of them.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MeshSpec {
    /// The rectangle from (0, 0) to (width, height): `nx` × `ny` cells of two triangles, diagonals alternating.
    Grid(GridSpec),
    /// The grid with its inner vertices moved at random.
    Jittered(JitteredSpec),
    /// A polygon filled with equilateral triangles that are turned by an angle.
    Lattice(LatticeSpec),
    /// A polygon filled with triangles without any order.
    Unstructured(UnstructuredSpec),
    /// A flat disc about the origin.
    Disc(DiscSpec),
    /// A spherical cap, its pole at the origin, its rim below.
    Cap(CapSpec),
    /// The square from (−5, −5) to (5, 5) with a hole of radius 1 about the origin.
    PlateWithHole(PlateWithHoleSpec),
    /// A quadrilateral, mapped bilinearly.
    Quad(QuadSpec),
    /// Vertices and triangles written out.
    Inline(InlineSpec),
    /// A mesh file.
    File(FileSpec),
}

/// A structured rectangle.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GridSpec {
    /// Along x \[mm\].
    pub width: f64,
    /// Along y \[mm\].
    pub height: f64,
    /// Cells along x.
    pub nx: usize,
    /// Cells along y.
    pub ny: usize,
}

/// A rectangle whose structure is disturbed.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JitteredSpec {
    /// Along x \[mm\].
    pub width: f64,
    /// Along y \[mm\].
    pub height: f64,
    /// Cells along x.
    pub nx: usize,
    /// Cells along y.
    pub ny: usize,
    /// The same seed, the same mesh. Default 0.
    #[serde(default)]
    pub seed: u64,
}

/// A turned lattice.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LatticeSpec {
    /// The polygon's corners in order \[mm\].
    pub corners: Vec<Point>,
    /// Length of the edges \[mm\].
    pub edge: f64,
    /// Angle from x to one of its three directions.
    pub degrees: f64,
}

/// A mesh without order.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct UnstructuredSpec {
    /// The polygon's corners in order \[mm\].
    pub corners: Vec<Point>,
    /// Length of the edges \[mm\], about.
    pub edge: f64,
    /// The same seed, the same mesh. Default 0.
    #[serde(default)]
    pub seed: u64,
}

/// A disc.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DiscSpec {
    /// Radius \[mm\].
    pub radius: f64,
    /// About so many triangles.
    pub triangles: usize,
}

/// A cap.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CapSpec {
    /// Radius of the sphere \[mm\].
    pub curvature_radius: f64,
    /// Straight across the rim \[mm\].
    pub diameter: f64,
    /// About so many triangles.
    pub triangles: usize,
}

/// A square with a hole.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlateWithHoleSpec {
    /// Points round the hole, a multiple of 8.
    pub points: usize,
}

/// A mapped quadrilateral.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct QuadSpec {
    /// Its corners counter-clockwise \[mm\]: (0,0), (1,0), (1,1), (0,1) of the grid.
    pub corners: Exactly<Point, 4>,
    /// Cells between the first and the second corner.
    pub nx: usize,
    /// Cells between the second and the third corner.
    pub ny: usize,
}

/// A mesh in the scene file itself.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InlineSpec {
    /// Vertices \[mm\].
    pub positions: Vec<Point>,
    /// Corners, counted from 0, counter-clockwise.
    pub triangles: Vec<Exactly<u32, 3>>,
}

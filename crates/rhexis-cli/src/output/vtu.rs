//! One body at one moment as a ParaView file (.vtu): triangles with displacement, stress, fibre and criterion.
//!
//! Values are `f64` in little-endian base64 blocks, so reading a file back gives the same bits.

use super::{OutputError, file, shape};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::DVec3;
use rhexis::frame::{BodyFrame, SolidFrame, SolidKind};
use std::path::Path;

/// Writes one body as an unstructured grid.
///
/// Point data: `displacement` \[mm\] and, where the frame holds them, `velocity` \[mm/ms\] and `force` \[N\]. Cell data: `stress` (9 components by rows, \[MPa\]), `principal_stress` (2, \[MPa\]),
/// `fibre` (3) and, for a body that can tear, `criterion`. A body without triangles gives a valid grid without cells.
///
/// # Errors
/// The arrays of the body do not belong together, or the file cannot be written.
pub fn write_vtu(path: &Path, body: &BodyFrame) -> Result<(), OutputError> {
    shape::check_shape(path, body)?;
    file::replace(path, grid(body).as_bytes())
}

/// Cell type of a triangle in VTK.
const TRIANGLE: u8 = 5;

/// Writes obstacles and jaws as one unstructured grid. Cell data: `solid`, the place in the list; `kind`, 0 for an obstacle and 1 for jaws; `at` \[mm\], the
/// middle of the solid; `force` \[N\], that of the solid on the bodies.
///
/// # Errors
/// The file cannot be written.
pub fn write_solids(path: &Path, solids: &[SolidFrame]) -> Result<(), OutputError> {
    let positions: Vec<DVec3> = solids.iter().flat_map(|solid| &solid.positions).copied().collect();
    let mut triangles = Vec::new();
    let mut first = 0;
    for solid in solids {
        triangles.extend(solid.triangles.iter().map(|corners| corners.map(|v| first + v)));
        first += solid.positions.len() as u32;
    }
    let cells = || (0..).zip(solids).flat_map(|(place, solid)| solid.triangles.iter().map(move |_| (place, solid)));
    let mut text = begin(positions.len(), triangles.len());
    text.push_str("</PointData><CellData>");
    floats(&mut text, "solid", 1, cells().map(|(place, _): (u32, _)| f64::from(place)));
    floats(&mut text, "kind", 1, cells().map(|(_, solid)| if solid.kind == SolidKind::Jaws { 1.0 } else { 0.0 }));
    vectors(&mut text, "at", cells().map(|(_, solid)| solid.at));
    vectors(&mut text, "force", cells().map(|(_, solid)| solid.force));
    end(&mut text, &positions, &triangles);
    file::replace(path, text.as_bytes())
}

/// The beginning of a file, up to its point data.
fn begin(points: usize, cells: usize) -> String {
    // Version 1.0 is the first with 64-bit block headers. VTK refuses a piece without its two counts.
    format!(
        "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\
         <UnstructuredGrid><Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\" NumberOfLines=\"0\" \
         NumberOfStrips=\"0\" NumberOfPolys=\"0\" NumberOfVerts=\"0\"><PointData>"
    )
}

/// The end of a file, from its points on.
fn end(text: &mut String, positions: &[DVec3], triangles: &[[u32; 3]]) {
    let cells = triangles.len();
    text.push_str("</CellData><Points>");
    vectors(text, "", positions.iter().copied());
    text.push_str("</Points><Cells>");
    // Signed, as VTK has its own: readers take unsigned indices through floating-point numbers.
    let corners = triangles.iter().flatten().map(|&v| i64::from(v).to_le_bytes());
    array(text, ["Int64", "connectivity"], 1, corners);
    array(text, ["Int64", "offsets"], 1, (1..=cells as i64).map(|k| (3 * k).to_le_bytes()));
    array(text, ["UInt8", "types"], 1, (0..cells).map(|_| [TRIANGLE]));
    text.push_str("</Cells></Piece></UnstructuredGrid></VTKFile>");
}

fn grid(body: &BodyFrame) -> String {
    let (points, cells) = (body.positions.len(), body.triangles.len());
    let mut text = begin(points, cells);
    let displacement = body.positions.iter().zip(&body.rest_positions).map(|(x, rest)| *x - *rest);
    vectors(&mut text, "displacement", displacement);
    for (name, of_points) in [("velocity", &body.velocities), ("force", &body.forces)] {
        // An array of the wrong length makes ParaView refuse the file: a frame without the values has no array.
        if of_points.len() == points {
            vectors(&mut text, name, of_points.iter().copied());
        }
    }
    text.push_str("</PointData><CellData>");
    floats(&mut text, "stress", 9, body.stress.iter().flat_map(|s| s.transpose().to_cols_array()));
    floats(&mut text, "principal_stress", 2, body.principal_stress.iter().flat_map(|p| p.to_array()));
    vectors(&mut text, "fibre", body.fibres.iter().copied());
    if body.criterion.len() == cells {
        floats(&mut text, "criterion", 1, body.criterion.iter().copied());
    }
    end(&mut text, &body.positions, &body.triangles);
    text
}

fn vectors(text: &mut String, name: &str, values: impl Iterator<Item = DVec3>) {
    floats(text, name, 3, values.flat_map(|v| v.to_array()));
}

fn floats(text: &mut String, name: &str, components: usize, values: impl Iterator<Item = f64>) {
    array(text, ["Float64", name], components, values.map(f64::to_le_bytes));
}

/// Appends an array of this type and name, the latter left out where it is empty: a block header with the number of bytes, and the bytes.
fn array<const N: usize>(
    text: &mut String,
    [kind, name]: [&str; 2],
    components: usize,
    values: impl Iterator<Item = [u8; N]>,
) {
    let mut block = vec![0; size_of::<u64>()];
    values.for_each(|value| block.extend(value));
    let (header, content) = block.split_at_mut(size_of::<u64>());
    header.copy_from_slice(&(content.len() as u64).to_le_bytes());
    let name = if name.is_empty() { String::new() } else { format!(" Name=\"{name}\"") };
    text.push_str(&format!("<DataArray type=\"{kind}\"{name} format=\"binary\" NumberOfComponents=\"{components}\">"));
    STANDARD.encode_string(&block, text);
    text.push_str("</DataArray>");
}

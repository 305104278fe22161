//! Cells of a file become triangles here.

use glam::DVec3;

use crate::storage::TriangleMesh;

/// How the corners of a cell make triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A flat polygon, cut into a fan about its first corner.
    Polygon,
    /// A strip: each corner after the second makes a triangle with the two before it.
    Strip,
    /// A quad in raster order: the last two corners swapped.
    Pixel,
    /// A point or a line: makes none.
    Thin,
}

/// The shape of a VTK cell type; an error for curved and solid ones.
pub fn vtk_shape(cell_type: u64) -> Result<Shape, String> {
    match cell_type {
        0..=4 => Ok(Shape::Thin),
        5 | 7 | 9 => Ok(Shape::Polygon),
        6 => Ok(Shape::Strip),
        8 => Ok(Shape::Pixel),
        _ => Err(format!(
            "VTK cell type {cell_type} is curved or solid; extract the surface and save it as linear triangles \
             (ParaView: Extract Surface, then Triangulate)"
        )),
    }
}

/// Appends the triangles of one cell, each with the cell's fibre if there is one. Fewer than three corners make none.
pub fn push_cell(mesh: &mut TriangleMesh, shape: Shape, corners: &[u32], fibre: Option<DVec3>) {
    let before = mesh.triangles.len();
    match (shape, corners) {
        (Shape::Pixel, &[a, b, c, d]) => mesh.triangles.extend([[a, b, d], [a, d, c]]),
        (Shape::Polygon, &[first, ref rest @ ..]) => {
            mesh.triangles.extend(rest.windows(2).map(|pair| [first, pair[0], pair[1]]));
        }
        (Shape::Strip, _) => mesh.triangles.extend(corners.windows(3).enumerate().map(|(number, three)| {
            let [a, b, c] = [three[0], three[1], three[2]];
            if number % 2 == 0 { [a, b, c] } else { [b, a, c] }
        })),
        _ => {}
    }
    if let Some(fibre) = fibre {
        let added = mesh.triangles.len() - before;
        mesh.fibres.get_or_insert_default().extend(std::iter::repeat_n(fibre, added));
    }
}

/// Points from a flat list of coordinates.
pub fn points(coordinates: &[f64]) -> Vec<DVec3> {
    coordinates.chunks_exact(3).map(|p| DVec3::new(p[0], p[1], p[2])).collect()
}

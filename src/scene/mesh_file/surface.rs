//! Cells of a file become triangles here.

use glam::DVec3;

use crate::storage::TriangleMesh;

/// How the corners of a cell make triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// Three corners.
    Triangle,
    /// A flat polygon of four corners.
    Quad,
    /// A flat polygon, cut into a fan about one of its corners.
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

/// Appends the triangles of one cell, each with the cell's fibre if there is one. The positions of its corners stand in the mesh.
///
/// # Errors
/// For a number of corners that does not make the shape, and for a polygon that neither fan about its first two corners fills:
/// triangles outside of it would be silently wrong.
pub fn push_cell(mesh: &mut TriangleMesh, shape: Shape, corners: &[u32], fibre: Option<DVec3>) -> Result<(), String> {
    let before = mesh.triangles.len();
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
        (Shape::Strip, _) => mesh.triangles.extend(corners.windows(3).enumerate().map(|(number, three)| {
            let [a, b, c] = [three[0], three[1], three[2]];
            if number % 2 == 0 { [a, b, c] } else { [b, a, c] }
        })),
        (Shape::Pixel, &[a, b, c, d]) => push_polygon(mesh, &[a, b, d, c])?,
        _ => push_polygon(mesh, corners)?,
    }
    if let Some(fibre) = fibre {
        let added = mesh.triangles.len() - before;
        mesh.fibres.get_or_insert_default().extend(std::iter::repeat_n(fibre, added));
    }
    Ok(())
}

/// The fan about the first corner, or else about the second, whose triangles all face one way.
fn push_polygon(mesh: &mut TriangleMesh, corners: &[u32]) -> Result<(), String> {
    let fan = |start: usize| {
        let corner = move |i: usize| corners[(start + i) % corners.len()];
        (1..corners.len() - 1).map(move |i| [corner(0), corner(i), corner(i + 1)])
    };
    let areas = |start: usize| -> Option<Vec<DVec3>> {
        let area = |t: [u32; 3]| {
            let at = |corner: u32| mesh.positions.get(corner as usize).copied();
            let [a, b, c] = [at(t[0])?, at(t[1])?, at(t[2])?];
            Some((b - a).cross(c - a))
        };
        fan(start).map(area).collect()
    };
    let faces_one_way = |areas: Vec<DVec3>| {
        let whole: DVec3 = areas.iter().sum();
        areas.iter().all(|area| area.dot(whole) > 0.0)
    };
    // A single triangle, and corners that are no vertices or lie nowhere, are judged with the mesh as a whole.
    let is_judged_later = |areas: &Option<Vec<DVec3>>| areas.as_ref().is_none_or(|a| a.iter().any(|a| !a.is_finite()));
    let start = [0, 1].into_iter().find(|&start| {
        let areas = areas(start);
        corners.len() == 3 || is_judged_later(&areas) || areas.is_some_and(faces_one_way)
    });
    let start = start.ok_or_else(|| {
        format!(
            "its {} corners make a polygon that crosses itself, is folded or too far from convex; save it as triangles",
            corners.len()
        )
    })?;
    mesh.triangles.extend(fan(start));
    Ok(())
}

/// Points from a flat list of coordinates.
pub fn points(coordinates: &[f64]) -> Vec<DVec3> {
    coordinates.chunks_exact(3).map(|p| DVec3::new(p[0], p[1], p[2])).collect()
}

//! A body's surface as it lies, for other programs: Wavefront OBJ and Stanford PLY, with vertex normals and texture coordinates.

use super::corners::{Rows, Textured};
use super::gltf::vertex_normals;
use super::{OutputError, file, shape};
use rhexis::frame::BodyFrame;
use std::fmt::Write;
use std::path::Path;

/// Writes positions \[mm\], unit vertex normals, texture coordinates where vertices carry them, and triangles as OBJ text; numbers read back to
/// the same bits.
///
/// # Errors
/// The arrays of the body do not belong together, or the file cannot be written.
pub fn write_obj(path: &Path, body: &BodyFrame) -> Result<(), OutputError> {
    write_textured_obj(path, body, None)
}

/// Writes OBJ text with a texture coordinate for each corner, where the texture has seams.
pub(crate) fn write_textured_obj(
    path: &Path,
    body: &BodyFrame,
    textured: Option<&Textured>,
) -> Result<(), OutputError> {
    shape::check_shape(path, body)?;
    let mut text = String::from("# positions in mm\n");
    // Writing to a String cannot fail.
    body.positions.iter().for_each(|p| _ = writeln!(text, "v {} {} {}", p.x, p.y, p.z));
    vertex_normals(body).iter().for_each(|n| _ = writeln!(text, "vn {} {} {}", n.x, n.y, n.z));
    let rows = Rows::of(body, textured);
    rows.texture.iter().for_each(|[u, v]| _ = writeln!(text, "vt {u} {v}"));
    for (corners, textured) in body.triangles.iter().zip(&rows.triangles) {
        let [a, b, c] = corners.map(|v| u64::from(v) + 1);
        let [d, e, f] = textured.map(|v| u64::from(v) + 1);
        let _ = match rows.texture.is_empty() {
            true => writeln!(text, "f {a}//{a} {b}//{b} {c}//{c}"),
            false => writeln!(text, "f {a}/{d}/{a} {b}/{e}/{b} {c}/{f}/{c}"),
        };
    }
    file::replace(path, text.as_bytes())
}

/// Writes the same as binary little-endian PLY with `double` coordinates.
///
/// # Errors
/// As [`write_obj`].
pub fn write_ply(path: &Path, body: &BodyFrame) -> Result<(), OutputError> {
    write_textured_ply(path, body, None)
}

/// Writes PLY with a vertex for each of its texture coordinates, where the texture has seams.
pub(crate) fn write_textured_ply(
    path: &Path,
    body: &BodyFrame,
    textured: Option<&Textured>,
) -> Result<(), OutputError> {
    shape::check_shape(path, body)?;
    let rows = Rows::of(body, textured);
    let names: &[&str] = if rows.texture.is_empty() { &[] } else { &["s", "t"] };
    let names = ["x", "y", "z", "nx", "ny", "nz"].iter().chain(names);
    let properties: String = names.map(|name| format!("property double {name}\n")).collect();
    let head = format!(
        "ply\nformat binary_little_endian 1.0\ncomment positions in mm\nelement vertex {}\n{properties}element face {}\n\
         property list uchar uint vertex_indices\nend_header\n",
        rows.vertices.len(),
        body.triangles.len()
    );
    let mut bytes = head.into_bytes();
    let normals = rows.spread(&vertex_normals(body));
    for (row, (position, normal)) in rows.spread(&body.positions).into_iter().zip(normals).enumerate() {
        let numbers = position
            .to_array()
            .into_iter()
            .chain(normal.to_array())
            .chain(rows.texture.get(row).copied().into_iter().flatten());
        numbers.for_each(|number| bytes.extend(number.to_le_bytes()));
    }
    for corners in &rows.triangles {
        bytes.push(3);
        corners.iter().for_each(|v| bytes.extend(v.to_le_bytes()));
    }
    file::replace(path, &bytes)
}

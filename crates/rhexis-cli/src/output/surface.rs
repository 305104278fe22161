//! A body's surface as it lies, for other programs: Wavefront OBJ and Stanford PLY, with vertex normals and texture coordinates.

use super::gltf::vertex_normals;
use super::{OutputError, file, shape};
use rhexis::components::Channel;
use rhexis::frame::BodyFrame;
use std::fmt::Write;
use std::path::Path;

/// Writes positions \[mm\], unit vertex normals, texture coordinates where vertices carry them, and triangles as OBJ text; numbers read back to
/// the same bits.
///
/// # Errors
/// The arrays of the body do not belong together, or the file cannot be written.
pub fn write_obj(path: &Path, body: &BodyFrame) -> Result<(), OutputError> {
    shape::check_shape(path, body)?;
    let mut text = String::from("# positions in mm\n");
    // Writing to a String cannot fail.
    body.positions.iter().for_each(|p| _ = writeln!(text, "v {} {} {}", p.x, p.y, p.z));
    vertex_normals(body).iter().for_each(|n| _ = writeln!(text, "vn {} {} {}", n.x, n.y, n.z));
    let texture = texture(body);
    texture.iter().for_each(|[u, v]| _ = writeln!(text, "vt {u} {v}"));
    for corners in &body.triangles {
        let [a, b, c] = corners.map(|v| u64::from(v) + 1);
        let _ = match texture.is_empty() {
            true => writeln!(text, "f {a}//{a} {b}//{b} {c}//{c}"),
            false => writeln!(text, "f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}"),
        };
    }
    file::replace(path, text.as_bytes())
}

/// Writes the same as binary little-endian PLY with `double` coordinates.
///
/// # Errors
/// As [`write_obj`].
pub fn write_ply(path: &Path, body: &BodyFrame) -> Result<(), OutputError> {
    shape::check_shape(path, body)?;
    let texture = texture(body);
    let names: &[&str] = if texture.is_empty() { &[] } else { &["s", "t"] };
    let names = ["x", "y", "z", "nx", "ny", "nz"].iter().chain(names);
    let properties: String = names.map(|name| format!("property double {name}\n")).collect();
    let head = format!(
        "ply\nformat binary_little_endian 1.0\ncomment positions in mm\nelement vertex {}\n{properties}element face {}\n\
         property list uchar uint vertex_indices\nend_header\n",
        body.positions.len(),
        body.triangles.len()
    );
    let mut bytes = head.into_bytes();
    for (row, (position, normal)) in body.positions.iter().zip(vertex_normals(body)).enumerate() {
        let numbers = position
            .to_array()
            .into_iter()
            .chain(normal.to_array())
            .chain(texture.get(row).copied().into_iter().flatten());
        numbers.for_each(|number| bytes.extend(number.to_le_bytes()));
    }
    for corners in &body.triangles {
        bytes.push(3);
        corners.iter().for_each(|v| bytes.extend(v.to_le_bytes()));
    }
    file::replace(path, &bytes)
}

/// Texture coordinates of the vertices; none where they carry none.
fn texture(body: &BodyFrame) -> Vec<[f64; 2]> {
    let rows = body.attributes.as_ref().and_then(|attributes| attributes.channel(Channel::TextureCoordinates));
    rows.into_iter().flatten().map(|row| [row[0], row[1]]).collect()
}

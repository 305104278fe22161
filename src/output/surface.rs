//! A body's surface as it lies, for other programs: Wavefront OBJ and Stanford PLY, with vertex normals.

use super::{OutputError, error, file};
use crate::frame::BodyFrame;
use crate::simulation::normals;
use glam::DVec3;
use std::fmt::Write;
use std::path::Path;

/// Writes positions \[mm\], unit vertex normals and triangles as OBJ text; numbers read back to the same bits.
///
/// # Errors
/// The arrays of the body do not belong together, or the file cannot be written.
pub fn write_obj(path: &Path, body: &BodyFrame) -> Result<(), OutputError> {
    error::check_shape(path, body)?;
    let mut text = String::from("# positions in mm\n");
    // Writing to a String cannot fail.
    body.positions.iter().for_each(|p| _ = writeln!(text, "v {} {} {}", p.x, p.y, p.z));
    vertex_normals(body).iter().for_each(|n| _ = writeln!(text, "vn {} {} {}", n.x, n.y, n.z));
    for corners in &body.triangles {
        let [a, b, c] = corners.map(|v| u64::from(v) + 1);
        let _ = writeln!(text, "f {a}//{a} {b}//{b} {c}//{c}");
    }
    file::replace(path, text.as_bytes())
}

/// Writes the same as binary little-endian PLY with `double` coordinates.
///
/// # Errors
/// As [`write_obj`].
pub fn write_ply(path: &Path, body: &BodyFrame) -> Result<(), OutputError> {
    error::check_shape(path, body)?;
    let properties: String = ["x", "y", "z", "nx", "ny", "nz"].map(|name| format!("property double {name}\n")).concat();
    let head = format!(
        "ply\nformat binary_little_endian 1.0\ncomment positions in mm\nelement vertex {}\n{properties}element face {}\n\
         property list uchar uint vertex_indices\nend_header\n",
        body.positions.len(),
        body.triangles.len()
    );
    let mut bytes = head.into_bytes();
    for (position, normal) in body.positions.iter().zip(vertex_normals(body)) {
        let numbers = position.to_array().into_iter().chain(normal.to_array());
        numbers.for_each(|number| bytes.extend(number.to_le_bytes()));
    }
    for corners in &body.triangles {
        bytes.push(3);
        corners.iter().for_each(|v| bytes.extend(v.to_le_bytes()));
    }
    file::replace(path, &bytes)
}

fn vertex_normals(body: &BodyFrame) -> Vec<DVec3> {
    let mut list = Vec::new();
    normals(&body.positions, &body.triangles, &mut list);
    list
}

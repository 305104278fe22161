//! The image that a body's texture coordinates refer to: no step reads it, glTF files carry it.

use super::error::Fault;
use super::files::Files;
use super::mesh_file::MeshFile;
use super::schema::BodySpec;
use rhexis::components::Channel;
use std::sync::Arc;

/// The largest image that is read \[bytes\].
const MOST_BYTES: u64 = 64 << 20;

/// Reads a body's texture; `key` is the body's path in the scene.
///
/// # Errors
/// For a file that cannot be read, and for a mesh without texture coordinates.
pub(super) fn read(spec: &BodySpec, file: &MeshFile, files: &Files, key: &str) -> Result<Option<Arc<Vec<u8>>>, Fault> {
    let Some(path) = &spec.texture else { return Ok(None) };
    let key = format!("{key}.texture");
    let has_coordinates =
        file.attributes.iter().flat_map(|a| &a.channels).any(|(channel, _)| *channel == Channel::TextureCoordinates);
    if !has_coordinates {
        let what = "the mesh has no texture coordinates at every vertex";
        return Err(Fault::new(key, what, "read an OBJ, PLY or glTF file that has them, or remove this key"));
    }
    let bytes = files.read(path, MOST_BYTES).map_err(|error| {
        let what = format!("cannot read {}: {error}", files.path(path).display());
        Fault::new(&key, what, "a relative path begins at the scene file's folder")
    })?;
    if bytes.starts_with(b"\x89PNG\r\n\x1a\n") || bytes.starts_with(b"\xff\xd8\xff") {
        return Ok(Some(bytes));
    }
    Err(Fault::new(key, "it is neither a PNG nor a JPEG image", "save the texture as one of the two"))
}

//! A body's surface as it lies as binary glTF 2.0 (.glb): positions, normals, texture coordinates, colours, triangles and a texture.

use super::corners::{Rows, Textured};
use super::{OutputError, file, shape};
use glam::{DQuat, DVec3, Vec3};
use rhexis::components::{Attributes, Channel};
use rhexis::frame::BodyFrame;
use rhexis::simulation::normals;
use serde_json::{Value, json};
use std::path::Path;

/// Metres in the millimetre of positions.
const METRES: f64 = 1e-3;

/// Numbers of the format.
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;

/// Writes one body with its vertex normals, and with texture coordinates and colours where its vertices carry them. Positions are in mm under a
/// node that scales them to the metres of the format. Normals that the vertices carry are turned as the surface around them has been. The
/// texture is the bytes of a PNG or JPEG file.
///
/// # Errors
/// The arrays of the body do not belong together or are empty, it is too large for the format, or the file cannot be written.
pub fn write_gltf(path: &Path, body: &BodyFrame, texture: Option<&[u8]>) -> Result<(), OutputError> {
    write_textured_gltf(path, body, texture, None)
}

/// Writes glTF with a vertex for each of its texture coordinates, where the texture has seams.
pub(crate) fn write_textured_gltf(
    path: &Path,
    body: &BodyFrame,
    texture: Option<&[u8]>,
    textured: Option<&Textured>,
) -> Result<(), OutputError> {
    shape::check_shape(path, body)?;
    let attributes = body.attributes.as_ref();
    if body.triangles.is_empty() {
        return Err(OutputError::content(path, format!("body '{}' has no triangles; let some of it be", body.name)));
    }
    let mut binary = Binary::default();
    let rows = Rows::of(body, textured);
    let positions: Vec<Vec3> = body.positions.iter().map(|p| p.as_vec3()).collect();
    let (low, high) =
        positions.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
    let of_vertices = |binary: &mut Binary, width, numbers: &mut dyn Iterator<Item = f64>| {
        binary.floats(rows.vertices.len(), width, numbers)
    };
    let position = of_vertices(&mut binary, 3, &mut rows.spread(&body.positions).iter().flat_map(|p| p.to_array()));
    binary.accessors[position]["min"] = json!(low.to_array());
    binary.accessors[position]["max"] = json!(high.to_array());
    let normal = of_vertices(&mut binary, 3, &mut rows.spread(&vertex_normals(body)).iter().flat_map(|n| n.to_array()));
    let mut semantics = json!({ "POSITION": position, "NORMAL": normal });
    if !rows.texture.is_empty() {
        // The format counts v downwards.
        let mut numbers = rows.texture.iter().flat_map(|[u, v]| [*u, 1.0 - *v]);
        semantics["TEXCOORD_0"] = json!(of_vertices(&mut binary, 2, &mut numbers));
    }
    if let Some(colours) = attributes.and_then(|attributes| attributes.channel(Channel::Colour)) {
        let colours = rows.spread(&colours.collect::<Vec<_>>());
        let mut numbers = colours.iter().flat_map(|row| row.iter().map(|part| part.clamp(0.0, 1.0)));
        semantics["COLOR_0"] = json!(of_vertices(&mut binary, 4, &mut numbers));
    }
    let indices = binary.indices(&rows.triangles);
    let mut material = json!({
        "doubleSided": true,
        "pbrMetallicRoughness": { "metallicFactor": 0.0, "roughnessFactor": 0.8 },
    });
    let mut root = json!({
        "asset": { "version": "2.0", "generator": concat!("rhexis ", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "name": body.name, "mesh": 0, "scale": [METRES, METRES, METRES] }],
        "meshes": [{ "name": body.name, "primitives": [{ "attributes": semantics, "indices": indices, "material": 0 }] }],
    });
    if let Some(texture) = texture {
        let kind = if texture.starts_with(b"\x89PNG") { "image/png" } else { "image/jpeg" };
        root["images"] = json!([{ "bufferView": binary.view(texture, None), "mimeType": kind }]);
        root["samplers"] = json!([{}]);
        root["textures"] = json!([{ "source": 0, "sampler": 0 }]);
        material["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": 0 });
    }
    root["materials"] = json!([material]);
    root["accessors"] = Value::Array(binary.accessors);
    root["bufferViews"] = Value::Array(binary.views);
    root["buffers"] = json!([{ "byteLength": binary.bytes.len() }]);
    let bytes = packed(root.to_string().into_bytes(), binary.bytes);
    let bytes = bytes
        .ok_or_else(|| OutputError::content(path, "4 GiB are the most that a .glb file holds; write .vtu frames"))?;
    file::replace(path, &bytes)
}

/// The chunks of a .glb file behind its head; `None` where they are longer than its lengths can say.
fn packed(mut json: Vec<u8>, binary: Vec<u8>) -> Option<Vec<u8>> {
    json.resize(json.len().next_multiple_of(4), b' ');
    let total = u32::try_from(12 + 8 + json.len() + 8 + binary.len()).ok()?;
    let mut bytes = Vec::with_capacity(total as usize);
    bytes.extend(b"glTF");
    [2, total].iter().for_each(|word: &u32| bytes.extend(word.to_le_bytes()));
    for (kind, chunk) in [(b"JSON", json), (b"BIN\0", binary)] {
        bytes.extend(u32::try_from(chunk.len()).ok()?.to_le_bytes());
        bytes.extend(kind);
        bytes.extend(chunk);
    }
    Some(bytes)
}

/// The binary chunk, with what stands where in it.
#[derive(Default)]
struct Binary {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Binary {
    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        let mut view = json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(view);
        self.views.len() - 1
    }

    fn floats(&mut self, count: usize, width: usize, numbers: &mut dyn Iterator<Item = f64>) -> usize {
        let bytes: Vec<u8> = numbers.flat_map(|number| (number as f32).to_le_bytes()).collect();
        let view = self.view(&bytes, Some(34_962));
        let kind = format!("VEC{width}");
        self.accessors.push(json!({ "bufferView": view, "componentType": FLOAT, "count": count, "type": kind }));
        self.accessors.len() - 1
    }

    fn indices(&mut self, triangles: &[[u32; 3]]) -> usize {
        let bytes: Vec<u8> = triangles.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
        let view = self.view(&bytes, Some(34_963));
        let count = 3 * triangles.len();
        self.accessors
            .push(json!({ "bufferView": view, "componentType": UNSIGNED_INT, "count": count, "type": "SCALAR" }));
        self.accessors.len() - 1
    }
}

/// Unit normals of the vertices: those that they carry, turned from the rest shape's to the present one's, or the present ones.
pub(super) fn vertex_normals(body: &BodyFrame) -> Vec<DVec3> {
    let of = |positions: &[DVec3]| {
        let mut list = Vec::new();
        normals(positions, &body.triangles, &mut list);
        list
    };
    let mut present = of(&body.positions);
    if let Some(carried) =
        body.attributes.as_ref().and_then(|attributes: &Attributes| attributes.channel(Channel::Normal))
    {
        for ((present, rest), own) in present.iter_mut().zip(of(&body.rest_positions)).zip(carried) {
            if present.length_squared() > 0.5 && rest.length_squared() > 0.5 {
                *present = DQuat::from_rotation_arc(rest, *present) * DVec3::from_slice(own);
            }
        }
    }
    // What cancels has some normal: the format asks for unit vectors.
    present.into_iter().map(|normal| normal.normalize_or(DVec3::Z)).collect()
}

//! glTF 2.0, binary (.glb) and as text (.gltf), by `gltf-json`: triangles, strips and fans of all meshes in the scene.

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::{DMat3, DMat4, DQuat, DVec3};
use gltf_json::accessor::{ComponentType, Type};
use gltf_json::mesh::{Mode, Primitive, Semantic};
use gltf_json::validation::Checked;
use gltf_json::{Index, Mesh, Node, Root};

use super::draft::{Draft, Origin, Shape, Wanted};
use super::fault::Fault;
use crate::files::Files;
use rhexis::components::Channel;

/// Vertices and corners per byte of file that nodes may make of shared meshes.
const MOST_SHARING: usize = 4;

/// Reads the meshes where their nodes place them.
pub(super) fn parse(bytes: Vec<u8>, wanted: &Wanted) -> Result<Draft, Fault> {
    let size = bytes.len();
    let (json, binary) = if bytes.starts_with(b"glTF") { chunks(&bytes)? } else { (&bytes[..], None) };
    let root: Root = gltf_json::deserialize::from_slice(json).map_err(|error| {
        Fault::at(error.line(), format!("{error}; not the JSON of glTF 2.0: export the file again"))
    })?;
    if let Some(needed) = root.extensions_required.iter().find(|name| !name.starts_with("KHR_materials")) {
        let what = format!("the file needs the extension {needed}, which is not read; export it without compression");
        return Err(Fault::new(what));
    }
    // Buffers that name one file share its content.
    let mut contents = BTreeMap::new();
    for uri in root.buffers.iter().filter_map(|buffer| buffer.uri.as_deref()) {
        if let Entry::Vacant(place) = contents.entry(uri) {
            place.insert(content(uri, wanted.beside)?);
        }
    }
    let bytes_of = |uri: &str| contents.get(uri).map_or(&[][..], |content| content.as_slice());
    let buffers = root.buffers.iter().map(|buffer| buffer.uri.as_deref().map_or(binary.unwrap_or_default(), bytes_of));
    let budget = MOST_SHARING * (size + contents.values().map(|content| content.len()).sum::<usize>());
    let mut file = File { root: &root, buffers: buffers.collect(), budget };
    let mut draft = Draft { is_soup: true, origin: Origin::Number("triangle"), ..Draft::default() };
    let scene = root.scene.map_or(0, |scene| scene.value());
    let tops: Vec<usize> = match root.scenes.get(scene) {
        Some(scene) => scene.nodes.iter().map(Index::value).collect(),
        None => {
            let children = root.nodes.iter().flat_map(|node| node.children.iter().flatten());
            let children: BTreeSet<usize> = children.map(Index::value).collect();
            (0..root.nodes.len()).filter(|node| !children.contains(node)).collect()
        }
    };
    let mut seen = BTreeSet::new();
    let mut queue: Vec<(usize, DMat4)> = tops.into_iter().rev().map(|node| (node, DMat4::IDENTITY)).collect();
    while let Some((number, above)) = queue.pop() {
        let missing =
            || Fault::new(format!("node {number} does not exist, or stands in two places; export the file again"));
        let node = root.nodes.get(number).filter(|_| seen.insert(number)).ok_or_else(missing)?;
        let placed = above * placing(node);
        if let Some(mesh) = node.mesh {
            let mesh = root
                .meshes
                .get(mesh.value())
                .ok_or_else(|| Fault::new(format!("node {number} names no mesh; export the file again")))?;
            file.mesh(mesh, node.name.as_deref(), placed, &mut draft)?;
        }
        queue.extend(node.children.iter().flatten().rev().map(|child| (child.value(), placed)));
    }
    if root.nodes.is_empty() {
        root.meshes.iter().try_for_each(|mesh| file.mesh(mesh, None, DMat4::IDENTITY, &mut draft))?;
    }
    Ok(draft)
}

/// Files beside a glTF file that its buffers name; none where it cannot be read.
pub(super) fn buffers(bytes: &[u8]) -> Vec<PathBuf> {
    let json = if bytes.starts_with(b"glTF") { chunks(bytes).map_or(&[][..], |(json, _)| json) } else { bytes };
    let Ok(root) = gltf_json::deserialize::from_slice::<Root>(json) else { return Vec::new() };
    let uris = root.buffers.iter().filter_map(|buffer| buffer.uri.as_deref());
    uris.filter(|uri| is_beside(uri)).map(PathBuf::from).collect()
}

/// Whether a buffer names a file beside its own.
fn is_beside(uri: &str) -> bool {
    let mut parts = Path::new(uri).components();
    parts.all(|part| matches!(part, Component::Normal(_) | Component::CurDir)) && !uri.contains(':')
}

/// The JSON and the binary chunk of a .glb file.
fn chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), Fault> {
    let cut_off = || Fault::new("the binary glTF is cut off or no version 2; export it again");
    let word = |at: usize| {
        bytes.get(at..at + 4).and_then(|four| four.first_chunk::<4>()).map(|four| u32::from_le_bytes(*four))
    };
    if word(4) != Some(2) {
        return Err(cut_off());
    }
    let (mut json, mut binary, mut at) = (None, None, 12);
    while let (Some(length), Some(kind)) = (word(at), bytes.get(at + 4..at + 8)) {
        let content = bytes.get(at + 8..).and_then(|rest| rest.get(..length as usize)).ok_or_else(cut_off)?;
        match kind {
            b"JSON" if json.is_none() => json = Some(content),
            b"BIN\0" if binary.is_none() => binary = Some(content),
            _ => {}
        }
        at += 8 + content.len();
    }
    Ok((json.ok_or_else(cut_off)?, binary))
}

/// A node's own matrix.
fn placing(node: &Node) -> DMat4 {
    if let Some(matrix) = node.matrix {
        return DMat4::from_cols_array(&matrix.map(f64::from));
    }
    let vector = |v: [f32; 3]| DVec3::from(v.map(f64::from));
    let turn = node.rotation.map_or(DQuat::IDENTITY, |q| DQuat::from_array(q.0.map(f64::from)));
    let turn = if turn.length_squared() > 0.0 { turn.normalize() } else { DQuat::IDENTITY };
    DMat4::from_scale_rotation_translation(
        node.scale.map_or(DVec3::ONE, vector),
        turn,
        node.translation.map_or(DVec3::ZERO, vector),
    )
}

/// Numbers in a row of an accessor.
fn components_of(kind: Type) -> usize {
    match kind {
        Type::Scalar => 1,
        Type::Vec2 => 2,
        Type::Vec3 => 3,
        Type::Vec4 | Type::Mat2 => 4,
        Type::Mat3 => 9,
        Type::Mat4 => 16,
    }
}

struct File<'a> {
    root: &'a Root,
    buffers: Vec<&'a [u8]>,
    /// Vertices and corners that may still be made.
    budget: usize,
}

/// Content of a buffer that the file names or holds as text.
fn content(uri: &str, beside: Option<(&Path, &Files)>) -> Result<Arc<Vec<u8>>, Fault> {
    if let Some((_, text)) = uri.strip_prefix("data:").and_then(|rest| rest.split_once("base64,")) {
        let what = "a buffer is no base64 text; export the file again";
        return STANDARD.decode(text).map(Arc::new).map_err(|_| Fault::new(what));
    }
    let Some((file, files)) = beside.filter(|_| is_beside(uri)) else {
        return Err(Fault::new(format!("the buffer {uri:?} lies elsewhere; export one .glb file")));
    };
    files
        .read(&file.with_file_name(uri), super::MOST_BYTES)
        .map_err(|error| Fault::new(format!("cannot read the buffer {uri:?}: {error}; export one .glb file")))
}

impl File<'_> {
    fn mesh(&mut self, mesh: &Mesh, name: Option<&str>, placed: DMat4, draft: &mut Draft) -> Result<(), Fault> {
        let first_of_mesh = draft.positions.len();
        for primitive in &mesh.primitives {
            let Checked::Valid(mode) = primitive.mode else {
                return Err(Fault::new("a primitive has no valid mode; export the file again"));
            };
            if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
                continue;
            }
            let positions = primitive.attributes.get(&Checked::Valid(Semantic::Positions));
            let positions =
                positions.ok_or_else(|| Fault::new("a primitive has no positions; export the file again"))?;
            let positions = self.numbers(positions.value(), Type::Vec3)?;
            let first = draft.positions.len() as u32;
            draft
                .positions
                .extend(positions.chunks_exact(3).map(|p| placed.transform_point3(DVec3::new(p[0], p[1], p[2]))));
            let count = (positions.len() / 3) as u32;
            self.decorate(primitive, (first, count), placed, draft);
            let corners: Vec<u32> = match primitive.indices {
                Some(indices) => {
                    self.numbers(indices.value(), Type::Scalar)?.into_iter().map(|index| index as u32).collect()
                }
                None => (0..count).collect(),
            };
            if let Some(index) = corners.iter().find(|index| **index >= count) {
                return Err(Fault::new(format!(
                    "a triangle names vertex {index}, but there are only {count}; export the file again"
                )));
            }
            let corner = |i: usize| first + corners[i];
            // A mirrored node turns its triangles over.
            let is_mirrored = placed.determinant() < 0.0;
            let mut push = |[a, b, c]: [u32; 3]| -> Result<(), Fault> {
                let number = draft.triangles.len();
                let corners = if is_mirrored { [a, c, b] } else { [a, b, c] };
                draft.push_cell(Shape::Triangle, &corners, number, number).map_err(Fault::new)
            };
            match mode {
                Mode::TriangleStrip => (2..corners.len()).try_for_each(|i| {
                    let [a, b] = if i % 2 == 0 { [i - 2, i - 1] } else { [i - 1, i - 2] };
                    // Strips are joined by triangles without area.
                    let three = [corner(a), corner(b), corner(i)];
                    if three[0] == three[1] || three[1] == three[2] || three[0] == three[2] {
                        Ok(())
                    } else {
                        push(three)
                    }
                })?,
                Mode::TriangleFan => {
                    (2..corners.len()).try_for_each(|i| push([corner(0), corner(i - 1), corner(i)]))?
                }
                _ => corners.chunks_exact(3).try_for_each(|three| push([0, 1, 2].map(|i| first + three[i])))?,
            }
        }
        let members = (first_of_mesh as u32..draft.positions.len() as u32).collect::<Vec<_>>();
        for name in [name, mesh.name.as_deref()].into_iter().flatten() {
            draft.groups.push((name.to_owned(), members.clone()));
        }
        Ok(())
    }

    /// Gives the vertices of a primitive its texture coordinates (their v turned up), normals and colours, of several sets the first. What cannot
    /// be read is none.
    fn decorate(&mut self, primitive: &Primitive, (first, count): (u32, u32), placed: DMat4, draft: &mut Draft) {
        for semantic in primitive.attributes.keys() {
            if let Checked::Valid(further @ (Semantic::TexCoords(1..) | Semantic::Colors(1..))) = semantic {
                draft.passed_over.insert(format!("{} (of its kind the first set stands)", further.to_string()));
            }
        }
        let normals = DMat3::from_mat4(placed).inverse().transpose();
        let kinds = [
            (Semantic::TexCoords(0), Type::Vec2),
            (Semantic::Normals, Type::Vec3),
            (Semantic::Colors(0), Type::Vec4),
            (Semantic::Colors(0), Type::Vec3),
        ];
        for (semantic, kind) in kinds {
            let is_normal = semantic == Semantic::Normals;
            let Some(accessor) = primitive.attributes.get(&Checked::Valid(semantic)) else { continue };
            let Ok(numbers) = self.scaled_numbers(accessor.value(), kind) else { continue };
            for (row, own) in (first..first + count).zip(numbers.chunks_exact(components_of(kind))) {
                match (kind, own) {
                    (Type::Vec2, [u, v]) => {
                        _ = draft.decoration.give(Channel::TextureCoordinates, row, &[*u, 1.0 - *v])
                    }
                    (Type::Vec3, &[x, y, z]) if is_normal => {
                        let normal = (normals * DVec3::new(x, y, z)).normalize_or_zero();
                        draft.decoration.give(Channel::Normal, row, &normal.to_array());
                    }
                    (Type::Vec3, [r, g, b]) => _ = draft.decoration.give(Channel::Colour, row, &[*r, *g, *b, 1.0]),
                    (_, own) => _ = draft.decoration.give(Channel::Colour, row, own),
                }
            }
        }
    }

    /// The numbers of an accessor of this type, as they are.
    fn numbers(&mut self, accessor: usize, expected: Type) -> Result<Vec<f64>, Fault> {
        if self.root.accessors.get(accessor).is_some_and(|found| found.normalized) {
            return Err(Fault::new(format!("accessor {accessor} is normalized; export the file again")));
        }
        self.scaled_numbers(accessor, expected)
    }

    /// The numbers of an accessor of this type; normalized ones from −1 or 0 to 1.
    fn scaled_numbers(&mut self, accessor: usize, expected: Type) -> Result<Vec<f64>, Fault> {
        let broken = |what: &str| Fault::new(format!("accessor {accessor} {what}; export the file again"));
        let found = self.root.accessors.get(accessor).ok_or_else(|| broken("does not exist"))?;
        if found.type_ != Checked::Valid(expected) || found.sparse.is_some() {
            return Err(broken("is sparse or of another type"));
        }
        let Checked::Valid(component) = found.component_type else { return Err(broken("has no type")) };
        let component = component.0;
        let size = match component {
            ComponentType::I8 | ComponentType::U8 => 1,
            ComponentType::I16 | ComponentType::U16 => 2,
            ComponentType::U32 | ComponentType::F32 => 4,
        };
        let components = components_of(expected);
        let full = match component {
            _ if !found.normalized => 1.0,
            ComponentType::I8 => 127.0,
            ComponentType::U8 => 255.0,
            ComponentType::I16 => 32767.0,
            ComponentType::U16 => 65535.0,
            ComponentType::U32 | ComponentType::F32 => 1.0,
        };
        let view = found.buffer_view.and_then(|view| self.root.buffer_views.get(view.value()));
        let view = view.ok_or_else(|| broken("has no data"))?;
        let bytes = self.buffers.get(view.buffer.value()).ok_or_else(|| broken("names no buffer"))?;
        let beyond = || broken("reaches beyond its buffer: the file is cut off");
        let place =
            |offset: Option<gltf_json::validation::USize64>| usize::try_from(offset.map_or(0, |offset| offset.0)).ok();
        let length = usize::try_from(view.byte_length.0).ok();
        let bytes = place(view.byte_offset).and_then(|start| bytes.get(start..)?.get(..length?)).ok_or_else(beyond)?;
        let bytes = place(found.byte_offset).and_then(|start| bytes.get(start..)).ok_or_else(beyond)?;
        let stride = view.byte_stride.map_or(size * components, |stride| stride.0).max(size * components);
        let count = usize::try_from(found.count.0).map_err(|_| beyond())?;
        let end = count.checked_sub(1).map_or(Some(0), |last| last.checked_mul(stride)?.checked_add(size * components));
        if end.is_none_or(|end| end > bytes.len()) {
            return Err(beyond());
        }
        self.budget = self.budget.checked_sub(count).ok_or_else(|| {
            Fault::new("its nodes make far more triangles than the file holds; export fewer copies of its meshes")
        })?;
        let mut numbers = Vec::with_capacity(count * components);
        for row in 0..count {
            for place in 0..components {
                let at = row * stride + place * size;
                let mut four = [0; 4];
                four[..size].copy_from_slice(&bytes[at..at + size]);
                let low = u32::from_le_bytes(four);
                let number = match component {
                    ComponentType::I8 => f64::from(low as i8),
                    ComponentType::I16 => f64::from(low as i16),
                    ComponentType::F32 => f64::from(f32::from_bits(low)),
                    _ => f64::from(low),
                };
                numbers.push(number / full);
            }
        }
        Ok(numbers)
    }
}

//! What bodies look like: arrays lent to C.

use crate::pointer::Out;
use crate::status::{Answer, Failure, RhexisStatus, call, refused};
use crate::types::*;
use crate::world::{World, with};
use glam::DVec3;
use rhexis::components::{ChangeSet, Changes};
use rhexis::simulation::BodyView;
use rhexis::storage::BodyId;
use slotmap::Key;
use std::ops::Range;

/// Copies that a world keeps for C, of one body. Each keeps its memory.
#[derive(Default)]
pub(crate) struct Shown {
    positions: Vec<f32>,
    before: Vec<DVec3>,
    normals: Vec<DVec3>,
    single_normals: Vec<f32>,
    attributes: Vec<f32>,
    vertex_keys: Vec<u64>,
    triangle_keys: Vec<u64>,
    changes: ChangeSet,
    vertex_ranges: Vec<u32>,
    triangle_ranges: Vec<u32>,
}

// Points are lent as their numbers.
const _: () = assert!(size_of::<DVec3>() == 3 * size_of::<f64>() && align_of::<DVec3>() == align_of::<f64>());

fn points(points: &[DVec3]) -> RhexisViewF64 {
    RhexisViewF64 { data: points.as_ptr().cast(), count: 3 * points.len() }
}

fn singles(numbers: &[f32]) -> RhexisViewF32 {
    RhexisViewF32 { data: numbers.as_ptr(), count: numbers.len() }
}

fn rows(rows: &[u32]) -> RhexisViewU32 {
    RhexisViewU32 { data: rows.as_ptr(), count: rows.len() }
}

fn keys(keys: &[u64]) -> RhexisViewU64 {
    RhexisViewU64 { data: keys.as_ptr(), count: keys.len() }
}

fn narrow<'a>(points: impl IntoIterator<Item = &'a DVec3>, into: &mut Vec<f32>) {
    into.clear();
    into.extend(points.into_iter().flat_map(|point| point.as_vec3().to_array()));
}

fn flat(ranges: &[Range<u32>], into: &mut Vec<u32>) {
    into.clear();
    into.extend(ranges.iter().flat_map(|range| [range.start, range.end]));
}

/// Looks at a body and writes what is to be seen.
fn show<V: Copy>(
    (world, body): (RhexisWorld, RhexisEntity),
    view: Out<V>,
    look: impl FnOnce(&BodyView<'_>, &mut Shown) -> Answer<V>,
) -> RhexisStatus {
    call(|| {
        view.check("view")?;
        let seen = with(world, |world| {
            let body = world.body(body)?;
            borrowed(world, body, look)
        })?;
        view.write(seen);
        Ok(())
    })
}

fn borrowed<V>(
    world: &mut World,
    body: BodyId,
    look: impl FnOnce(&BodyView<'_>, &mut Shown) -> Answer<V>,
) -> Answer<V> {
    let mut shown = world.shown.remove(&body).unwrap_or_default();
    let seen = world.simulation().view(body).map_err(refused).and_then(|view| look(&view, &mut shown));
    // Moved, its arrays stay where they are.
    world.shown.insert(body, shown);
    seen
}

/// Lends the positions \[mm\], three numbers per vertex.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_positions(world: RhexisWorld, body: RhexisEntity, view: Out<RhexisViewF64>) -> RhexisStatus {
    show((world, body), view, |body, _| Ok(points(body.positions)))
}

/// Lends a copy of the positions \[mm\] in single precision, three numbers per vertex.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_positions_f32(
    world: RhexisWorld,
    body: RhexisEntity,
    view: Out<RhexisViewF32>,
) -> RhexisStatus {
    show((world, body), view, |body, shown| {
        narrow(body.positions, &mut shown.positions);
        Ok(singles(&shown.positions))
    })
}

/// Lends the positions \[mm\] at a time `behind` \[ms\] before now, on straight lines from where the last step began: for pictures between two
/// steps.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_positions_before(
    world: RhexisWorld,
    body: RhexisEntity,
    behind: f64,
    view: Out<RhexisViewF64>,
) -> RhexisStatus {
    show((world, body), view, |body, shown| {
        if !behind.is_finite() {
            return Err(Failure::argument(format!("a time of {behind} ms: it must be finite")));
        }
        body.positions_before(behind, &mut shown.before);
        Ok(points(&shown.before))
    })
}

/// Lends the positions of the rest shape \[mm\], three numbers per vertex.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_rest_positions(
    world: RhexisWorld,
    body: RhexisEntity,
    view: Out<RhexisViewF64>,
) -> RhexisStatus {
    show((world, body), view, |body, _| Ok(points(body.rest_positions)))
}

/// Lends the velocities \[mm/ms\], three numbers per vertex.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_velocities(world: RhexisWorld, body: RhexisEntity, view: Out<RhexisViewF64>) -> RhexisStatus {
    show((world, body), view, |body, _| Ok(points(body.velocities)))
}

/// Lends unit normals by vertex, three numbers each: means of the triangles around it, weighted by area.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_normals(world: RhexisWorld, body: RhexisEntity, view: Out<RhexisViewF64>) -> RhexisStatus {
    show((world, body), view, |body, shown| {
        body.normals(&mut shown.normals);
        Ok(points(&shown.normals))
    })
}

/// Lends unit normals by vertex in single precision, three numbers each.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_normals_f32(world: RhexisWorld, body: RhexisEntity, view: Out<RhexisViewF32>) -> RhexisStatus {
    show((world, body), view, |body, shown| {
        let mut normals = Vec::new();
        body.normals(&mut normals);
        narrow(&normals, &mut shown.single_normals);
        Ok(singles(&shown.single_normals))
    })
}

/// Lends the corners of the triangles, three rows each, counter-clockwise seen from where the normal points.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_indices(world: RhexisWorld, body: RhexisEntity, view: Out<RhexisViewU32>) -> RhexisStatus {
    show((world, body), view, |body, _| Ok(rows(body.triangles.as_flattened())))
}

/// Lends the keys of the vertices: they name a vertex as long as it lives, wherever its row is.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_vertex_keys(world: RhexisWorld, body: RhexisEntity, view: Out<RhexisViewU64>) -> RhexisStatus {
    show((world, body), view, |body, shown| {
        shown.vertex_keys.clear();
        shown.vertex_keys.extend(body.vertex_keys.iter().map(|key| key.data().as_ffi()));
        Ok(keys(&shown.vertex_keys))
    })
}

/// Lends the keys of the triangles.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_triangle_keys(
    world: RhexisWorld,
    body: RhexisEntity,
    view: Out<RhexisViewU64>,
) -> RhexisStatus {
    show((world, body), view, |body, shown| {
        shown.triangle_keys.clear();
        shown.triangle_keys.extend(body.triangle_keys.iter().map(|key| key.data().as_ffi()));
        Ok(keys(&shown.triangle_keys))
    })
}

/// Lends the host's own numbers per vertex of a body with the component "Attributes", and how many belong to a vertex. `stride` may be NULL.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_attributes(
    world: RhexisWorld,
    body: RhexisEntity,
    view: Out<RhexisViewF64>,
    stride: Out<usize>,
) -> RhexisStatus {
    let mut width = 0;
    let status = show((world, body), view, |body, _| {
        stride.check_if_any("stride")?;
        let attributes = body.attributes.ok_or_else(no_attributes)?;
        width = attributes.stride;
        Ok(RhexisViewF64 { data: attributes.values.as_ptr(), count: attributes.values.len() })
    });
    if status == RhexisStatus::Ok {
        stride.write(width);
    }
    status
}

/// Lends a copy of the host's own numbers per vertex in single precision. `stride` may be NULL.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_attributes_f32(
    world: RhexisWorld,
    body: RhexisEntity,
    view: Out<RhexisViewF32>,
    stride: Out<usize>,
) -> RhexisStatus {
    let mut width = 0;
    let status = show((world, body), view, |body, shown| {
        stride.check_if_any("stride")?;
        let attributes = body.attributes.ok_or_else(no_attributes)?;
        width = attributes.stride;
        shown.attributes.clear();
        shown.attributes.extend(attributes.values.iter().map(|&value| value as f32));
        Ok(singles(&shown.attributes))
    });
    if status == RhexisStatus::Ok {
        stride.write(width);
    }
    status
}

fn no_attributes() -> Failure {
    Failure::new(RhexisStatus::NotFound, "the body has no component Attributes: give it one by rhexis_set")
}

/// Keeps from now on what changes in a body's mesh, for `rhexis_changes`; the first answer is the whole mesh.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_track_changes(world: RhexisWorld, body: RhexisEntity) -> RhexisStatus {
    call(|| {
        with(world, |world| {
            let body = world.body(body)?;
            // It is there.
            let _ = world.simulation().world_mut().insert_one(body.entity(), Changes::default());
            Ok(())
        })
    })
}

/// Tells which rows of a body's mesh have changed since the last call: what a renderer has to copy again of its indices, texture coordinates
/// and colours. For a body of `rhexis_track_changes`.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_changes(world: RhexisWorld, body: RhexisEntity, changes: Out<RhexisChanges>) -> RhexisStatus {
    call(|| {
        changes.check("changes")?;
        let told = with(world, |world| {
            let body = world.body(body)?;
            let mut shown = world.shown.remove(&body).unwrap_or_default();
            let drained = world.simulation().drain_changes(body, &mut shown.changes);
            let Shown { changes: set, vertex_ranges, triangle_ranges, .. } = &mut shown;
            flat(&set.vertices, vertex_ranges);
            flat(&set.triangles, triangle_ranges);
            let told = RhexisChanges {
                is_whole: u8::from(set.is_whole),
                vertex_count: set.vertex_count,
                triangle_count: set.triangle_count,
                vertices: rows(vertex_ranges),
                triangles: rows(triangle_ranges),
            };
            // Moved, its arrays stay where they are.
            world.shown.insert(body, shown);
            drained.map_err(|error| refused(format!("{error}: call rhexis_track_changes first"))).map(|()| told)
        })?;
        changes.write(told);
        Ok(())
    })
}

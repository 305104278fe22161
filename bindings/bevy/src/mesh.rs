//! A mesh of Bevy's that follows a body by what has changed in it.

use crate::world::RhexisWorld;
use bevy::asset::{AssetId, RenderAssetUsages};
use bevy::ecs::component::Component;
use bevy::mesh::{Indices, Mesh, MeshAccessError, MeshVertexAttribute, PrimitiveTopology, VertexAttributeValues};
use rhexis::components::{Attributes, ChangeSet, Channel, Sleeping};
use rhexis::glam::DVec3;
use rhexis::simulation::normals;
use rhexis::storage::BodyId;
use std::ops::Range;

/// What has been written into a tissue's mesh so far, counted in elements.
#[derive(Component, Clone, Debug, Default)]
pub struct MeshUpdates {
    /// Number of frames in which the mesh was written.
    pub frames: u64,
    /// Number of positions written.
    pub positions: u64,
    /// Number of normals written.
    pub normals: u64,
    /// Number of triangles whose indices were written.
    pub triangles: u64,
    /// Number of vertices whose texture coordinates or colours were written.
    pub attributes: u64,
    changes: ChangeSet,
    drawn: Vec<DVec3>,
    shades: Vec<DVec3>,
    shown: Option<Shown>,
    /// Whether the mesh has not taken what was last to be written.
    is_behind: bool,
    is_lost: bool,
}

/// What a mesh shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shown {
    mesh: AssetId<Mesh>,
    step: u64,
    behind: f64,
    revision: u64,
    is_asleep: bool,
}

/// A mesh of nothing, to be written.
pub(crate) fn empty() -> Mesh {
    // Kept in the main world, where the changed parts of it are written.
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
}

impl MeshUpdates {
    /// What the mesh is to show, unless it does already.
    pub(crate) fn due(&mut self, world: &mut RhexisWorld, body: BodyId, mesh: AssetId<Mesh>) -> Option<Shown> {
        // A body that is gone is seen elsewhere.
        world.quietly().drain_changes(body, &mut self.changes).ok()?;
        let is_another = self.shown.is_some_and(|shown| shown.mesh != mesh);
        self.changes.is_whole |= self.is_behind || is_another;
        let simulation = world.simulation();
        let is_asleep = simulation.world().get::<&Sleeping>(body.entity()).is_ok_and(|sleeping| sleeping.is_asleep());
        let behind = if is_asleep { 0.0 } else { world.behind() };
        let now = Shown { mesh, step: simulation.report().step, behind, revision: world.revision(), is_asleep };
        let is_same = self.shown.is_some_and(|shown| {
            let is_still = shown.is_asleep && is_asleep && shown.revision == now.revision;
            is_still || shown == now
        });
        self.is_behind = !is_same || !self.changes.is_empty();
        self.is_behind.then_some(now)
    }

    pub(crate) fn is_lost(&self) -> bool {
        self.is_lost
    }

    /// Writes positions and normals, and what else has changed.
    pub(crate) fn write(
        &mut self,
        world: &mut RhexisWorld,
        body: BodyId,
        mesh: &mut Mesh,
        has_normals: bool,
        now: Shown,
    ) -> Result<(), MeshAccessError> {
        let Ok(view) = world.quietly().view(body) else { return Ok(()) };
        self.is_lost = true;
        view.positions_before(now.behind, &mut self.drawn);
        write_vectors(mesh, Mesh::ATTRIBUTE_POSITION, &self.drawn)?;
        self.positions += self.drawn.len() as u64;
        if has_normals {
            normals(&self.drawn, view.triangles, &mut self.shades);
            write_vectors(mesh, Mesh::ATTRIBUTE_NORMAL, &self.shades)?;
            self.normals += self.shades.len() as u64;
        }
        if !self.changes.is_empty() {
            self.triangles += write_indices(mesh, view.triangles, &self.changes)?;
            if let Some(attributes) = view.attributes {
                self.attributes += write_attributes(mesh, attributes, &self.changes)?;
            }
        }
        self.frames += 1;
        self.shown = Some(now);
        (self.is_lost, self.is_behind) = (false, false);
        Ok(())
    }
}

fn write_vectors(mesh: &mut Mesh, attribute: MeshVertexAttribute, values: &[DVec3]) -> Result<(), MeshAccessError> {
    let values = values.iter().map(|value| value.as_vec3().to_array());
    match mesh.try_attribute_mut_option(attribute)? {
        Some(VertexAttributeValues::Float32x3(there)) => {
            there.clear();
            there.extend(values);
            Ok(())
        }
        _ => mesh.try_insert_attribute(attribute, values.collect::<Vec<_>>()),
    }
}

/// Writes the indices of the changed triangles, or of all where the mesh has others; how many.
fn write_indices(mesh: &mut Mesh, triangles: &[[u32; 3]], changes: &ChangeSet) -> Result<u64, MeshAccessError> {
    if !changes.is_whole
        && let Some(Indices::U32(there)) = mesh.try_indices_mut_option()?
    {
        there.resize(3 * triangles.len(), 0);
        for range in &changes.triangles {
            let Range { start, end } = range.start as usize..range.end as usize;
            if let (Some(to), Some(from)) = (there.get_mut(3 * start..3 * end), triangles.get(start..end)) {
                to.copy_from_slice(from.as_flattened());
            }
        }
        return Ok(count(&changes.triangles));
    }
    mesh.try_insert_indices(Indices::U32(triangles.as_flattened().to_vec()))?;
    Ok(triangles.len() as u64)
}

/// Writes texture coordinates and colours of the changed vertices; of how many.
fn write_attributes(mesh: &mut Mesh, from: &Attributes, changes: &ChangeSet) -> Result<u64, MeshAccessError> {
    let mut written = 0;
    for &(channel, first) in &from.channels {
        // From the bottom up in the engine, from the top down in Bevy.
        let uv = |row: &[f64]| [row[first] as f32, 1.0 - row[first + 1] as f32];
        let colour = |row: &[f64]| [0, 1, 2, 3].map(|i| row[first + i] as f32);
        if first + channel.width() > from.stride {
            continue;
        }
        written += match channel {
            Channel::TextureCoordinates => {
                let there = match mesh.try_attribute_mut_option(Mesh::ATTRIBUTE_UV_0)? {
                    Some(VertexAttributeValues::Float32x2(there)) if !changes.is_whole => Some(there),
                    _ => None,
                };
                match there {
                    Some(there) => write_rows(there, from, changes, uv),
                    None => {
                        let all: Vec<[f32; 2]> = from.values.chunks_exact(from.stride).map(uv).collect();
                        mesh.try_insert_attribute(Mesh::ATTRIBUTE_UV_0, all)?;
                        u64::from(changes.vertex_count)
                    }
                }
            }
            Channel::Colour => {
                let there = match mesh.try_attribute_mut_option(Mesh::ATTRIBUTE_COLOR)? {
                    Some(VertexAttributeValues::Float32x4(there)) if !changes.is_whole => Some(there),
                    _ => None,
                };
                match there {
                    Some(there) => write_rows(there, from, changes, colour),
                    None => {
                        let all: Vec<[f32; 4]> = from.values.chunks_exact(from.stride).map(colour).collect();
                        mesh.try_insert_attribute(Mesh::ATTRIBUTE_COLOR, all)?;
                        u64::from(changes.vertex_count)
                    }
                }
            }
            // Those of the rest shape; the mesh has those of the shape as it is.
            Channel::Normal => 0,
        };
    }
    Ok(written)
}

fn write_rows<const N: usize>(
    there: &mut Vec<[f32; N]>,
    from: &Attributes,
    changes: &ChangeSet,
    value: impl Fn(&[f64]) -> [f32; N],
) -> u64 {
    there.resize(changes.vertex_count as usize, [0.0; N]);
    for row in changes.vertices.iter().cloned().flatten() {
        let numbers = from.of(row);
        if let Some(to) = there.get_mut(row as usize).filter(|_| numbers.len() == from.stride) {
            *to = value(numbers);
        }
    }
    count(&changes.vertices)
}

fn count(ranges: &[Range<u32>]) -> u64 {
    ranges.iter().map(|range| u64::from(range.end - range.start)).sum()
}

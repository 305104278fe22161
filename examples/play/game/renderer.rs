//! What a renderer keeps of every body: indices, texture coordinates and rest shape that follow the changes of the mesh, positions and
//! normals that are written anew for each picture.

use super::Result;
use glam::{DVec2, DVec3};
use rhexis::components::{Change, ChangeSet};
use rhexis::simulation::{FixedStep, Simulation, normals};
use rhexis::storage::BodyId;
use std::collections::BTreeMap;

/// What lies in its memory of one body.
#[derive(Clone, Default)]
struct Buffers {
    indices: Vec<[u32; 3]>,
    texture: Vec<DVec2>,
    rest: Vec<DVec3>,
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
}

impl Buffers {
    fn follow(&mut self, change: &Change) {
        match *change {
            Change::VertexAdded { row, parents } => {
                assert_eq!(row as usize, self.rest.len());
                self.texture.push(parents.blend(|parent| self.texture[parent as usize]));
                self.rest.push(parents.blend(|parent| self.rest[parent as usize]));
            }
            Change::VertexMoved { row, parents } => {
                self.texture[row as usize] = parents.blend(|parent| self.texture[parent as usize]);
                self.rest[row as usize] = parents.blend(|parent| self.rest[parent as usize]);
            }
            Change::VertexRemoved { row } => {
                self.texture.swap_remove(row as usize);
                self.rest.swap_remove(row as usize);
            }
            Change::TriangleChanged { row, corners } => self.indices[row as usize] = corners,
            Change::TriangleAdded { corners, .. } => self.indices.push(corners),
            Change::TriangleRemoved { row } => _ = self.indices.swap_remove(row as usize),
        }
    }
}

#[derive(Clone, Default)]
pub struct Renderer {
    bodies: BTreeMap<BodyId, Buffers>,
    changes: ChangeSet,
    drawn: Vec<DVec3>,
    shades: Vec<DVec3>,
}

impl Renderer {
    /// A body as it was spawned, with its texture coordinates: what is torn before the first picture is a change already.
    pub fn add(&mut self, simulation: &mut Simulation, body: BodyId, texture: Vec<DVec2>) -> Result<()> {
        simulation.drain_changes(body, &mut self.changes)?;
        let view = simulation.view(body)?;
        let (indices, rest) = (view.triangles.to_vec(), view.rest_positions.to_vec());
        self.bodies.insert(body, Buffers { indices, texture, rest, ..Buffers::default() });
        Ok(())
    }

    pub fn remove(&mut self, body: BodyId) {
        self.bodies.remove(&body);
    }

    /// Takes in what has changed in the mesh of a body. Returns how many changes there were.
    pub fn follow(&mut self, simulation: &mut Simulation, body: BodyId) -> Result<usize> {
        let Self { bodies, changes, .. } = self;
        let buffers = bodies.get_mut(&body).ok_or("a body that the renderer does not know")?;
        simulation.drain_changes(body, changes)?;
        changes.list.iter().for_each(|change| buffers.follow(change));
        // After a way back, to a mesh that was followed when it was saved.
        if changes.is_whole {
            let view = simulation.view(body)?;
            buffers.indices.clear();
            buffers.indices.extend_from_slice(view.triangles);
            buffers.rest.clear();
            buffers.rest.extend_from_slice(view.rest_positions);
        }
        Ok(changes.list.len())
    }

    /// Draws a body between its last two steps. Returns how many changes of the mesh there were.
    pub fn draw(&mut self, simulation: &mut Simulation, clock: &FixedStep, body: BodyId) -> Result<usize> {
        let count = self.follow(simulation, body)?;
        let Self { bodies, drawn, shades, .. } = self;
        let buffers = bodies.get_mut(&body).ok_or("a body that the renderer does not know")?;
        clock.positions(simulation, body, drawn)?;
        let view = simulation.view(body)?;
        normals(drawn, view.triangles, shades);
        for (to, from) in [(&mut buffers.positions, drawn), (&mut buffers.normals, shades)] {
            to.clear();
            to.extend(from.iter().map(|v| v.as_vec3().to_array()));
        }
        Ok(count)
    }

    /// Asserts that what it keeps of a body is the mesh.
    pub fn check(&self, simulation: &mut Simulation, body: BodyId, frame: u64) -> Result<()> {
        let (buffers, view) = (&self.bodies[&body], simulation.view(body)?);
        assert_eq!(buffers.indices, view.triangles, "frame {frame}: triangles");
        assert_eq!(buffers.rest, view.rest_positions, "frame {frame}: rest positions");
        assert_eq!(buffers.texture.len(), view.positions.len(), "frame {frame}: texture coordinates");
        let is_square = |uv: &DVec2| uv.cmpge(DVec2::splat(-1e-9)).all() && uv.cmple(DVec2::splat(1.0 + 1e-9)).all();
        assert!(buffers.texture.iter().all(is_square), "frame {frame}: texture coordinates stay on the picture");
        let mut drawn = buffers.positions.iter().chain(&buffers.normals).flatten();
        assert!(drawn.all(|value| value.is_finite()), "frame {frame}: positions and normals");
        Ok(())
    }
}

//! A body as slices of its own arrays, and the changes in them.

use super::{Simulation, SimulationError};
use crate::components::{Attributes, ChangeSet, Changes, Increment, Sleeping};
use crate::storage::{BodyId, TriangleKey, Triangles, VertexKey, Vertices};
use glam::DVec3;

/// A body's arrays as they are: nothing is copied or computed. Rows change in steps and cuts, as
/// [`Simulation::drain_changes`] reports.
#[derive(Clone, Copy, Debug)]
pub struct BodyView<'a> {
    /// Positions \[mm\] by vertex.
    pub positions: &'a [DVec3],
    /// Positions in the rest shape \[mm\].
    pub rest_positions: &'a [DVec3],
    /// Velocities \[mm/ms\].
    pub velocities: &'a [DVec3],
    /// Keys of the vertices.
    pub vertex_keys: &'a [VertexKey],
    /// Rows of the three vertices of every triangle, counter-clockwise seen from the side that the normal points to.
    pub triangles: &'a [[u32; 3]],
    /// Keys of the triangles.
    pub triangle_keys: &'a [TriangleKey],
    /// Numbers per vertex of the host's own, if the body carries any.
    pub attributes: Option<&'a Attributes>,
    /// Where the last step began; empty before the first.
    start: &'a [DVec3],
    /// Length of the last step, or of the last part of one that was halved \[ms\].
    start_dt: f64,
    is_asleep: bool,
}

impl BodyView<'_> {
    /// Unit normals by vertex: the mean of those of the triangles around it, weighted by area; zero where they cancel. The buffer
    /// is filled anew and keeps its memory.
    pub fn normals(&self, into: &mut Vec<DVec3>) {
        normals(self.positions, self.triangles, into);
    }

    /// Positions \[mm\] in single precision, as vertex buffers have them. The buffer is filled anew and keeps its memory.
    pub fn positions_f32(&self, into: &mut Vec<[f32; 3]>) {
        single(self.positions, into);
    }

    /// [`normals`](Self::normals) in single precision.
    pub fn normals_f32(&self, into: &mut Vec<[f32; 3]>) {
        let mut normals = Vec::new();
        self.normals(&mut normals);
        single(&normals, into);
    }

    /// Positions \[mm\] at `behind` \[ms\] before now, on a straight line from where the last step of `dt` \[ms\] began: those a
    /// picture between two steps shows. A vertex that is new has begun between its parents, one that has never moved where it is.
    /// The buffer is filled anew and keeps its memory.
    pub fn positions_before(&self, behind: f64, into: &mut Vec<DVec3>) {
        into.clear();
        let back = if self.start_dt > 0.0 { (behind / self.start_dt).clamp(0.0, 1.0) } else { 0.0 };
        if self.is_asleep || back == 0.0 || self.start.len() != self.positions.len() {
            return into.extend_from_slice(self.positions);
        }
        into.extend(self.positions.iter().zip(self.start).map(|(now, start)| now.lerp(*start, back)));
    }
}

fn single(values: &[DVec3], into: &mut Vec<[f32; 3]>) {
    into.clear();
    into.extend(values.iter().map(|value| value.as_vec3().to_array()));
}

/// Unit normals by vertex, weighted by area, for positions of your own, such as those [between two
/// steps](BodyView::positions_before).
pub fn normals(positions: &[DVec3], triangles: &[[u32; 3]], into: &mut Vec<DVec3>) {
    into.clear();
    into.resize(positions.len(), DVec3::ZERO);
    for corners in triangles {
        let [a, b, c] = corners.map(|v| positions[v as usize]);
        let twice_area = (b - a).cross(c - a);
        for v in corners {
            into[*v as usize] += twice_area;
        }
    }
    into.iter_mut().for_each(|normal| *normal = normal.normalize_or_zero());
}

impl Simulation {
    /// A body's arrays.
    ///
    /// # Errors
    /// If there is no such body.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// let view = simulation.view(body)?;
    /// let mut buffer = Vec::new();
    /// view.positions_f32(&mut buffer);
    /// assert_eq!(buffer.len(), view.vertex_keys.len());
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn view(&mut self, body: BodyId) -> Result<BodyView<'_>, SimulationError> {
        type Query<'a> = (&'a Vertices, &'a Triangles, &'a Increment, Option<&'a Sleeping>, Option<&'a Attributes>);
        let found = self.world.query_one_mut::<Query>(body.entity()).map_err(|_| SimulationError::NoSuchBody)?;
        let (vertices, triangles, increment, sleeping, attributes) = found;
        Ok(BodyView {
            positions: &vertices.position,
            rest_positions: &vertices.rest_position,
            velocities: &vertices.velocity,
            vertex_keys: vertices.keys(),
            triangles: &triangles.corners,
            triangle_keys: triangles.keys(),
            attributes,
            start: &increment.start,
            start_dt: increment.last.dt,
            is_asleep: sleeping.is_some_and(Sleeping::is_asleep),
        })
    }

    /// Takes the changes in the mesh of a body with [`Changes`] since the last call; the first time all of it.
    ///
    /// # Errors
    /// If there is no such body, and for one without [`Changes`].
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// let mut changes = rhexis::components::ChangeSet::default();
    /// simulation.drain_changes(body, &mut changes)?;
    /// assert!(changes.is_whole);
    /// simulation.cut(body, &[DVec3::new(0.0, 5.0, 0.0), DVec3::new(4.0, 5.0, 0.0)])?;
    /// simulation.drain_changes(body, &mut changes)?;
    /// assert!(changes.copies().count() > 0);
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn drain_changes(&mut self, body: BodyId, into: &mut ChangeSet) -> Result<(), SimulationError> {
        type Query<'a> = (&'a Vertices, &'a Triangles, Option<&'a mut Changes>);
        let found = self.world.query_one_mut::<Query>(body.entity()).map_err(|_| SimulationError::NoSuchBody)?;
        let (vertices, triangles, changes) = found;
        let changes = changes.ok_or(SimulationError::NoSuchComponents)?;
        into.take(changes, vertices.len() as u32, triangles.len() as u32);
        Ok(())
    }
}

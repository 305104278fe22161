//! Starting a tear inside the surface: a slit of two edges with a tip at each end.

use super::advance::Opening;
use super::{Cutter, TearRefusal, TipChart, plan_free};
use crate::storage::{Edit, Refusal};
use glam::DVec3;
use smallvec::SmallVec;

/// Where a tear starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// At the centroid of the triangle in this row.
    Triangle(u32),
    /// At the vertex in this row, inside the surface.
    Vertex(u32),
}

/// A new tear inside the surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Slit {
    /// Rows of the vertices along it; the ones between the ends are now doubled.
    pub path: SmallVec<[u32; 4]>,
    /// Rows of the tips and the directions \[unit, rest shape\] in which they point. An end at a boundary is no tip.
    pub tips: SmallVec<[(u32, DVec3); 2]>,
    /// Smallest angle \[rad\] of the triangles that were touched.
    pub smallest_angle: f64,
    /// Number of triangles of the smaller part, where the slit parts the surface: both ends lie on the boundary.
    pub freed: Option<usize>,
}

impl Cutter<'_, '_> {
    /// Starts a tear that runs both ways from a point inside, along a unit direction of the rest shape.
    ///
    /// # Errors
    /// Why it does not start; the mesh is as it was.
    pub fn start_inside(&mut self, start: Start, direction: DVec3) -> Result<Slit, TearRefusal> {
        let mark = self.scratch.records.len();
        let slit = self.slit(start, direction);
        if slit.is_err() {
            self.roll_back(mark);
        }
        slit
    }

    fn slit(&mut self, start: Start, direction: DVec3) -> Result<Slit, TearRefusal> {
        let mark = self.scratch.records.len();
        let centre = match start {
            Start::Vertex(vertex) => vertex,
            Start::Triangle(triangle) => {
                let centre = self.mesh.vertices.len() as u32;
                self.edit(&Edit::SplitTriangle { triangle, weights: [1.0 / 3.0; 3] })?;
                self.relax(mark, None);
                centre
            }
        };
        let (ahead, ahead_ends) = self.step_inside(centre, direction, &[], &Opening::Later)?;
        let path: SmallVec<[u32; 4]> = SmallVec::from_slice(&[ahead, centre]);
        let (behind, behind_ends) = self.step_inside(centre, -direction, &[ahead], &Opening::After(&path))?;
        let mut tips = SmallVec::new();
        if !ahead_ends {
            tips.push((ahead, self.direction(centre, ahead)));
        }
        if !behind_ends {
            tips.push((behind, self.direction(centre, behind)));
        }
        let freed = if tips.is_empty() { self.freed_piece(centre, behind) } else { None };
        let smallest_angle = self.smallest_touched(mark);
        Ok(Slit { path: SmallVec::from_slice(&[behind, centre, ahead]), tips, smallest_angle, freed })
    }

    /// One step from a vertex inside, whose row and whether it lies on a boundary are returned. Vertices in `held` must not move.
    pub(super) fn step_inside(
        &mut self,
        vertex: u32,
        direction: DVec3,
        held: &[u32],
        opening: &Opening<'_>,
    ) -> Result<(u32, bool), TearRefusal> {
        let tip = TipChart::new(self.mesh, vertex)?;
        if !tip.fan.is_closed {
            return Err(Refusal::BoundaryVertex { vertex }.into());
        }
        let direction = tip.chart.to_chart(direction);
        let is_movable = |row: u32| !held.contains(&row) && (self.is_movable)(row);
        let mut ways = plan_free(self.mesh, &tip, direction, f64::INFINITY, &self.quality, &is_movable)?;
        ways.snaps.retain(|way| !held.contains(&way.reaches));
        let advance = self.take(&tip, &ways, opening)?;
        Ok((advance.vertex, advance.end.is_some()))
    }

    /// Unit direction in the rest shape from one vertex to another.
    pub(super) fn direction(&self, from: u32, to: u32) -> DVec3 {
        let at = |row: u32| self.mesh.vertices.rest_position[row as usize];
        (at(to) - at(from)).normalize_or_zero()
    }
}

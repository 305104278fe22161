//! Starting a tear: a notch of one edge with a tip at its end from the boundary, a slit of two edges with a tip at each end
//! from inside.

use crate::components::{TearMode, TearSite};
use crate::storage::{Edit, Refusal};
use crate::systems::fracture::cut::advance::Opening;
use crate::systems::fracture::{Cutter, EdgePlan, TearRefusal, TipChart, plan_edge, plan_free};
use glam::DVec3;
use smallvec::{SmallVec, smallvec};

/// A tip made by a nucleation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewTip {
    /// Row of its vertex.
    pub vertex: u32,
    /// The direction that was wanted, from the start to here \[unit, rest shape\].
    pub direction: DVec3,
    /// Position that the tip would have \[mm, rest shape\] if it could leave the edges; in free mode its position.
    pub ideal: DVec3,
}

/// A new tear.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Slit {
    /// Rows of the vertices along it; the ones between tips are now doubled.
    pub path: SmallVec<[u32; 4]>,
    /// Tips of the new tear; an end at a boundary has no tip.
    pub tips: SmallVec<[NewTip; 2]>,
    /// Smallest angle \[rad\] of the triangles whose shape has changed; π where it has changed none.
    pub smallest_angle: f64,
    /// Number of triangles of the smaller part, where the slit parts the surface: both ends lie on the boundary.
    pub freed: Option<usize>,
}

impl Cutter<'_, '_> {
    /// Starts a tear along a unit direction of the rest shape: from a vertex of the boundary one way, from inside both ways.
    /// In edge mode a start inside a triangle is moved to that of its corners from which edges lead away most nearly.
    ///
    /// # Errors
    /// Why it does not start; the mesh is as it was.
    pub fn nucleate(&mut self, site: TearSite, direction: DVec3, mode: TearMode) -> Result<Slit, TearRefusal> {
        let mark = self.scratch.records.len();
        let slit = match (site, mode) {
            (TearSite::Vertex(vertex), _) if self.mesh.topology.is_boundary_vertex(vertex) => {
                self.notch(vertex, direction, mode)
            }
            (_, TearMode::Free | TearMode::Glide) => self.slit(site, direction),
            (TearSite::Vertex(vertex), TearMode::Edge) => self.slit_along_edges(&[vertex], direction),
            (TearSite::Triangle(triangle), TearMode::Edge) => {
                let missing = Refusal::NoSuchRow { what: "triangle", row: triangle };
                let corners = *self.mesh.triangles.corners.get(triangle as usize).ok_or(missing)?;
                self.slit_along_edges(&corners, direction)
            }
        };
        if slit.is_err() {
            self.roll_back(mark);
        }
        slit
    }

    fn notch(&mut self, vertex: u32, direction: DVec3, mode: TearMode) -> Result<Slit, TearRefusal> {
        let at = self.mesh.vertices.rest_position[vertex as usize];
        let (advance, ideal) = match mode {
            TearMode::Free | TearMode::Glide => self.advance(vertex, direction).map(|advance| (advance, advance.to))?,
            TearMode::Edge => {
                let step = self.advance_along_edge(vertex, at, direction)?;
                (step.advance, step.ideal)
            }
        };
        let tip = NewTip { vertex: advance.vertex, direction, ideal };
        Ok(Slit {
            path: smallvec![vertex, advance.vertex],
            tips: if advance.end.is_none() { smallvec![tip] } else { SmallVec::new() },
            smallest_angle: advance.smallest_angle,
            freed: advance.end.and_then(|end| end.freed),
        })
    }

    fn slit(&mut self, site: TearSite, direction: DVec3) -> Result<Slit, TearRefusal> {
        let mark = self.scratch.records.len();
        let centre = match site {
            TearSite::Vertex(vertex) => vertex,
            TearSite::Triangle(triangle) => {
                let centre = self.mesh.vertices.len() as u32;
                let before = self.smallest_near(triangle)?;
                let least_edge = self.least_edge(std::iter::once(triangle));
                self.edit(&Edit::SplitTriangle { triangle, weights: [1.0 / 3.0; 3] })?;
                self.relax(mark, &[]);
                let angle = self.smallest_touched(mark);
                if angle < self.quality.least.min(before) || self.leaves_shorter_edges(mark, least_edge) {
                    return Err(TearRefusal::NoRoom { angle });
                }
                centre
            }
        };
        let ahead = self.step_inside(centre, direction, &[], &Opening::Later)?;
        let path = [ahead, centre];
        let behind = self.step_inside(centre, -direction, &[ahead], &Opening::After(&path))?;
        let at = |vertex: u32| self.mesh.vertices.rest_position[vertex as usize];
        let tips = [(ahead, direction, at(ahead)), (behind, -direction, at(behind))];
        Ok(self.slit_between(mark, centre, tips))
    }

    /// From the first of the vertices inside, or that whose two edges turn least from the direction.
    fn slit_along_edges(&mut self, vertices: &[u32], direction: DVec3) -> Result<Slit, TearRefusal> {
        let mark = self.scratch.records.len();
        let mut best: Option<(f64, u32, EdgePlan, EdgePlan)> = None;
        for &vertex in vertices {
            let tip = TipChart::new(self.mesh, vertex)?;
            if !tip.fan.is_closed {
                continue;
            }
            let (at, d) = (self.mesh.vertices.rest_position[vertex as usize], tip.chart.to_chart(direction));
            let plan = |d| plan_edge(self.mesh, &tip, at, d, &self.quality);
            if let (Ok(ahead), Ok(behind)) = (plan(d), plan(-d)) {
                let turn = ahead.deviation + behind.deviation;
                if best.is_none_or(|(least, ..)| turn < least) {
                    best = Some((turn, vertex, ahead, behind));
                }
            }
        }
        let none = TearRefusal::NoForwardEdge { vertex: vertices[0] };
        let (_, centre, ahead, behind) = best.ok_or(none)?;
        self.edit(&Edit::Open { path: smallvec![behind.reaches, centre, ahead.reaches] })?;
        let tips = [(ahead.reaches, direction, ahead.ideal), (behind.reaches, -direction, behind.ideal)];
        Ok(self.slit_between(mark, centre, tips))
    }

    /// A slit that was opened: its ends are tips, except where the opening has parted them.
    fn slit_between(&mut self, mark: usize, centre: u32, ends: [(u32, DVec3, DVec3); 2]) -> Slit {
        let [(ahead, ..), (behind, ..)] = ends;
        let is_parted = |row: u32| self.scratch.records[mark..].iter().any(|record| record.parted().any(|v| v == row));
        let tips = ends.into_iter().filter(|&(vertex, ..)| !is_parted(vertex));
        let tips: SmallVec<_> = tips.map(|(vertex, direction, ideal)| NewTip { vertex, direction, ideal }).collect();
        let freed = if tips.is_empty() { self.freed_fragment(centre, behind) } else { None };
        let smallest_angle = self.smallest_touched(mark);
        Slit { path: smallvec![behind, centre, ahead], tips, smallest_angle, freed }
    }

    /// Advances one step from a vertex inside to the one whose row is returned. Vertices in `held` must not move.
    fn step_inside(
        &mut self,
        vertex: u32,
        direction: DVec3,
        held: &[u32],
        opening: &Opening<'_>,
    ) -> Result<u32, TearRefusal> {
        let tip = TipChart::new(self.mesh, vertex)?;
        if !tip.fan.is_closed {
            return Err(Refusal::BoundaryVertex { vertex }.into());
        }
        let direction = tip.chart.to_chart(direction);
        let is_movable = |row: u32| !held.contains(&row) && (self.is_movable)(row);
        let mut ways = plan_free(self.mesh, &tip, direction, &self.quality, &is_movable)?;
        ways.snaps.retain(|way| !held.contains(&way.reaches));
        ways.detours.retain(|way| !held.contains(&way.reaches));
        self.take(&tip, &ways, opening).map(|advance| advance.vertex)
    }

    /// Unit direction in the rest shape from one vertex to another.
    pub(in crate::systems::fracture) fn direction(&self, from: u32, to: u32) -> DVec3 {
        let at = |row: u32| self.mesh.vertices.rest_position[row as usize];
        (at(to) - at(from)).normalize_or_zero()
    }
}

//! Carrying out an advance: each way is done, judged by the triangles it leaves, and taken back if another may be better.

use crate::math::{SmallestAngle, smallest_angle};
use crate::storage::{Edit, EditRecord, NONE, Refusal, measure::rest_corners};
use crate::systems::fracture::{Advance, Cutter, End, TearRefusal, TearScratch, TipChart, Tried, Way, Ways, plan_free};
use glam::DVec3;
use smallvec::{SmallVec, smallvec};

/// Opening of the edge of a step.
pub(in crate::systems::fracture) enum Opening<'p> {
    /// The path that leads up to the tip, and this edge, are opened.
    After(&'p [u32]),
    /// The edge stays whole, to be opened with a later step.
    Later,
    /// The edge and the path that leads up to the tip stay whole.
    Whole(&'p [u32]),
}

impl Opening<'_> {
    /// The path that is opened now or later and must not be flipped away.
    fn path(&self, tip: u32, reaches: u32) -> SmallVec<[u32; 4]> {
        let mut path: SmallVec<[u32; 4]> = match self {
            Self::After(prefix) | Self::Whole(prefix) => (*prefix).into(),
            Self::Later => smallvec![tip],
        };
        path.push(reaches);
        path
    }
}

impl Cutter<'_, '_> {
    /// Advances a tear in free mode by at most one triangle: from a tip, or from any vertex of the boundary, in a unit
    /// direction of the rest shape.
    ///
    /// # Errors
    /// Why it does not advance; the mesh is as it was.
    pub fn advance(&mut self, vertex: u32, direction: DVec3) -> Result<Advance, TearRefusal> {
        let tip = TipChart::new(self.mesh, vertex)?;
        self.advance_from(&tip, direction)
    }

    /// Advances a tear in free mode by at most one triangle, from a tip whose chart fits the present mesh.
    ///
    /// # Errors
    /// As [`advance`](Self::advance).
    pub fn advance_from(&mut self, tip: &TipChart, direction: DVec3) -> Result<Advance, TearRefusal> {
        if tip.fan.is_closed {
            return Err(TearRefusal::NotATip { vertex: tip.vertex });
        }
        let direction = tip.chart.to_chart(direction);
        let ways = plan_free(self.mesh, tip, direction, &self.quality, self.is_movable)?;
        self.take(tip, &ways, &Opening::After(&[tip.vertex]))
    }

    /// Takes the first of the ways that leaves good enough triangles, in this order:
    /// - an exact one with good angles;
    /// - the best exact one with fair angles;
    /// - a near snap;
    /// - the best exact one with poor angles;
    /// - a detour.
    pub(in crate::systems::fracture) fn take(
        &mut self,
        tip: &TipChart,
        ways: &Ways,
        opening: &Opening<'_>,
    ) -> Result<Advance, TearRefusal> {
        let start = self.scratch.records.len();
        let before = self.smallest_around(tip);
        let mut tried = Tried::default();
        // The best attempt so far stands until another one is made.
        let mut best: Option<Advance> = None;
        for way in &ways.exact {
            self.lay_aside(start);
            let Some(advance) = self.attempt(tip, way, opening, &mut tried) else { continue };
            if advance.smallest_angle >= self.quality.good.min(before) {
                return self.finish(start, advance, tip, opening);
            }
            if best.is_none_or(|best| advance.smallest_angle > best.smallest_angle) {
                best = Some(advance);
            } else {
                self.roll_back(start);
            }
        }
        let least = self.quality.least.min(before);
        if let Some(advance) = best.filter(|best| best.smallest_angle >= self.quality.exact.min(before)) {
            return self.finish_best(start, advance, tip, opening);
        }
        self.lay_aside(start);
        for way in &ways.snaps {
            if let Some(advance) = self.attempt_for(least, tip, way, opening, &mut tried) {
                return self.finish(start, advance, tip, opening);
            }
        }
        if let Some(advance) = best.filter(|best| best.smallest_angle >= least) {
            return self.finish_best(start, advance, tip, opening);
        }
        for way in &ways.detours {
            if let Some(advance) = self.attempt_for(least, tip, way, opening, &mut tried) {
                return self.finish(start, advance, tip, opening);
            }
        }
        Err(TearRefusal::NoWay(tried))
    }

    /// Shapes the triangles for one way, without opening it, and notes how good they are; after `None` everything is as it was.
    fn attempt(&mut self, tip: &TipChart, way: &Way, opening: &Opening<'_>, tried: &mut Tried) -> Option<Advance> {
        let start = self.scratch.records.len();
        let least_edge = self.least_edge(tip.fan.sectors.iter().map(|&(triangle, _)| triangle));
        for edit in &way.edits {
            if let Err(refusal) = self.edit(edit) {
                tried.note(way.course, 0.0);
                tried.refusal = Some(refusal);
                self.roll_back(start);
                return None;
            }
        }
        self.relax(start, &opening.path(tip.vertex, way.reaches));
        if self.leaves_shorter_edges(start, least_edge) {
            tried.note(way.course, 0.0);
            self.roll_back(start);
            return None;
        }
        let advance = Advance {
            from: self.mesh.vertices.rest_position[tip.vertex as usize],
            to: self.mesh.vertices.rest_position[way.reaches as usize],
            vertex: way.reaches,
            deviation: way.deviation,
            course: way.course,
            smallest_angle: self.smallest_touched(start),
            end: None,
        };
        tried.note(way.course, advance.smallest_angle);
        Some(advance)
    }

    /// Attempts a way that leaves a smallest angle \[rad\] of at least `least`; after `None` everything is as it was.
    fn attempt_for(
        &mut self,
        least: f64,
        tip: &TipChart,
        way: &Way,
        opening: &Opening<'_>,
        tried: &mut Tried,
    ) -> Option<Advance> {
        let start = self.scratch.records.len();
        let advance = self.attempt(tip, way, opening, tried)?;
        if advance.smallest_angle < least {
            self.roll_back(start);
            return None;
        }
        Some(advance)
    }

    /// Rolls the standing best attempt back and keeps its edits, flips included, for replay.
    fn lay_aside(&mut self, start: usize) {
        let TearScratch { records, best, .. } = &mut *self.scratch;
        if records.len() > start {
            best.clear();
            best.extend(records[start..].iter().map(|record| record.edit.clone()));
            self.roll_back(start);
        }
    }

    /// Opens the way of the best attempt, which is done again if it was laid aside; after an error everything is as it was.
    fn finish_best(
        &mut self,
        start: usize,
        advance: Advance,
        tip: &TipChart,
        opening: &Opening<'_>,
    ) -> Result<Advance, TearRefusal> {
        let laid_aside = if self.scratch.records.len() > start { 0 } else { self.scratch.best.len() };
        for place in 0..laid_aside {
            let edit = self.scratch.best[place].clone();
            if let Err(refusal) = self.edit(&edit) {
                self.roll_back(start);
                return Err(refusal.into());
            }
        }
        self.finish(start, advance, tip, opening)
    }

    /// Opens the way that was taken, whose shaping began with record `start`; after an error everything is as it was.
    fn finish(
        &mut self,
        start: usize,
        advance: Advance,
        tip: &TipChart,
        opening: &Opening<'_>,
    ) -> Result<Advance, TearRefusal> {
        self.make_room_to_walk();
        let ends = self.mesh.topology.is_boundary_vertex(advance.vertex);
        if let Opening::Later | Opening::Whole(_) = opening {
            return Ok(Advance { end: ends.then_some(End { freed: None }), ..advance });
        }
        if let Err(refusal) = self.edit(&Edit::Open { path: opening.path(tip.vertex, advance.vertex) }) {
            self.roll_back(start);
            return Err(refusal.into());
        }
        let end = ends.then(|| End { freed: self.freed_fragment(tip.vertex, advance.vertex) });
        Ok(Advance { end, ..advance })
    }

    /// Applies an edit and keeps its record.
    pub(in crate::systems::fracture) fn edit(&mut self, edit: &Edit) -> Result<(), Refusal> {
        let record = crate::storage::apply(self.mesh, edit)?;
        self.scratch.records.push(record);
        Ok(())
    }

    /// Undoes the records from `start` on.
    pub(in crate::systems::fracture) fn roll_back(&mut self, start: usize) {
        for record in self.scratch.records[start..].iter().rev() {
            // The records are this mesh's last edits, in order, so the undo cannot be refused.
            let undone = crate::storage::undo(self.mesh, record);
            debug_assert_eq!(undone, Ok(()));
        }
        self.scratch.records.truncate(start);
    }

    /// The smallest rest angle \[rad\] of the triangles shaped by the records from `start` on that are still there; π where there are none.
    pub(in crate::systems::fracture) fn smallest_touched(&self, start: usize) -> f64 {
        let count = self.mesh.triangles.len() as u32;
        let shaped = self.shaped(start).flat_map(EditRecord::shaped_triangles);
        self.smallest_among(shaped.filter(|&row| row < count))
    }

    /// The records from `start` on that have changed the shape of triangles: an opening does not.
    pub(in crate::systems::fracture) fn shaped(&self, start: usize) -> impl Iterator<Item = &EditRecord> {
        self.scratch.records[start..].iter().filter(|record| !matches!(record.edit, Edit::Open { .. }))
    }

    pub(in crate::systems::fracture) fn angle_of(&self, triangle: u32) -> f64 {
        smallest_angle(self.rest_of(triangle))
    }

    /// Rest positions \[mm\] of a triangle's corners.
    pub(in crate::systems::fracture) fn rest_of(&self, triangle: u32) -> [DVec3; 3] {
        rest_corners(self.mesh.vertices, self.mesh.triangles.corners[triangle as usize])
    }

    /// The smallest rest angle \[rad\] of some triangles; π where there are none.
    fn smallest_among(&self, triangles: impl Iterator<Item = u32>) -> f64 {
        SmallestAngle::among(triangles.map(|row| self.rest_of(row)))
            .map_or(std::f64::consts::PI, |angle| angle.radians())
    }

    /// The smallest rest angle \[rad\] around the tip, and across the edges opposite to it.
    pub(in crate::systems::fracture) fn smallest_around(&self, tip: &TipChart) -> f64 {
        self.smallest_among(tip.fan.sectors.iter().flat_map(|&(triangle, corner)| {
            let across = self.mesh.topology.neighbours[triangle as usize][(corner + 1) % 3];
            std::iter::once(triangle).chain((across != NONE).then_some(across))
        }))
    }
}

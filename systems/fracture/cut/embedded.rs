//! Exact cuts: the line of a stroke is embedded as mesh edges, whatever triangles that leaves, then opened. In between the
//! triangles along it are mended; the whole line is opened at once.
//!
//! A cut edge by edge leaves the line where a triangle would be poor, and where it does depends on the end from which it comes.
//! An embedded cut stays on the line, so that the lips are the same from either end.

use crate::storage::{Edit, NONE, Refusal};
use crate::systems::fracture::cut::advance::Opening;
use crate::systems::fracture::cut::blade::{CutOutcome, off_line};
use crate::systems::fracture::{Cutter, TearRefusal, TipChart, Ways, plan_free};
use glam::DVec3;
use smallvec::SmallVec;

/// The least angle \[rad\] of a triangle along a line until it is mended; 1°, below which an edit is refused.
const POOREST: f64 = 0.017_453_292_519_943_295;
/// Largest turn \[rad\] to a vertex that is in the way; 2°, below which no angle is left anyhow.
const BESIDE: f64 = 2.0 * POOREST;
/// A mend must raise the smallest angle by this \[rad\].
const MEND_GAIN: f64 = 1e-3;
/// Mends per point of a line.
const MENDS: usize = 6;
/// Parts of an edge by which a vertex beside the line is moved to mend a triangle.
const SLIDES: [f64; 3] = [0.15, 0.3, 0.5];
/// A point of the line may go where its neighbours on the line leave it no farther than this part of their distance.
const STRAIGHT_LINE: f64 = 1e-12;

/// A line in the mesh.
struct EmbeddedCut {
    /// Rows of its vertices, each joined to the next.
    path: Vec<u32>,
    /// Rows of the points that were asked for, which stay.
    points: SmallVec<[u32; 8]>,
}

impl Cutter<'_, '_> {
    /// Cuts one stroke along its line and nowhere else.
    ///
    /// # Errors
    /// Why the line cannot be embedded, or [`TearRefusal::NoRoom`] where a triangle stays poorer than any was or may be; the caller rolls
    /// back. With `miss` above zero, points go to vertices of the boundary that are no farther than this part of an edge, and the line to
    /// vertices in its way, if they must.
    pub(in crate::systems::fracture) fn cut_embedded(
        &mut self,
        stroke: &[DVec3],
        polyline: &[DVec3],
        miss: f64,
    ) -> Result<CutOutcome, TearRefusal> {
        let (quality, start) = (self.quality, self.scratch.records.len());
        let least =
            (0..self.mesh.triangles.corners.len() as u32).map(|t| self.angle_of(t)).fold(quality.least, f64::min);
        (self.quality.least, self.quality.exact) = (POOREST, POOREST);
        let embedded = self.embed(stroke, miss);
        self.quality = quality;
        let mut embedded = embedded?;
        // Vertices moved out of the line's way may have left a poor triangle farther off.
        let angle = self.mend(&mut embedded).min(self.smallest_touched(start));
        if angle < least {
            return Err(TearRefusal::NoRoom { angle });
        }
        let outcome = self.open_embedded(&embedded.path)?;
        let off_line = off_line(&outcome.path, polyline);
        Ok(CutOutcome { off_line, smallest_angle: angle, ..outcome })
    }

    fn embed(&mut self, stroke: &[DVec3], miss: f64) -> Result<EmbeddedCut, TearRefusal> {
        let points = self.place_all(stroke, miss)?;
        let &[first, _, ..] = points.as_slice() else { return Err(TearRefusal::BadPolyline) };
        let mut path = vec![first];
        for (point, &target) in points.iter().enumerate().skip(1) {
            while let Some(&from) = path.last().filter(|from| **from != target) {
                let reached = self.embed_step((&path, &points), from, target, miss > 0.0)?;
                let at = |row: u32| self.mesh.vertices.rest_position[row as usize];
                let is_nearer = at(reached).distance(at(target)) < at(from).distance(at(target)) * (1.0 - 1e-9);
                if !is_nearer || path.contains(&reached) && Some(&reached) != path.first() {
                    return Err(TearRefusal::NoProgress { point });
                }
                path.push(reached);
            }
        }
        let mut embedded = EmbeddedCut { path, points };
        self.halve_single_edge(&mut embedded)?;
        Ok(embedded)
    }

    /// A line of one edge inside the surface could not open: it is given a vertex in its middle.
    fn halve_single_edge(&mut self, embedded: &mut EmbeddedCut) -> Result<(), TearRefusal> {
        let &[first, last] = embedded.path.as_slice() else { return Ok(()) };
        if [first, last].iter().any(|&row| self.mesh.topology.is_boundary_vertex(row)) {
            return Ok(());
        }
        let missing = Refusal::NoSuchEdge { from: first, to: last };
        let edge = self.mesh.topology.directed_edge(&self.mesh.triangles.corners, first, last);
        let (triangle, edge) = edge.ok_or(missing)?;
        let middle = self.mesh.vertices.len() as u32;
        self.edit(&Edit::SplitEdge { triangle, edge, weight: 0.5 })?;
        embedded.path.insert(1, middle);
        Ok(())
    }

    /// The next vertex of the line, which an edge joins to the last one then.
    fn embed_step(
        &mut self,
        (path, points): (&[u32], &[u32]),
        from: u32,
        target: u32,
        may_miss: bool,
    ) -> Result<u32, TearRefusal> {
        let tip = TipChart::new(self.mesh, from)?;
        if (0..tip.spoke_count()).any(|spoke| tip.end(self.mesh, spoke) == Some(target)) {
            return Ok(target);
        }
        let direction = tip.chart.to_chart(self.direction(from, target));
        let is_movable = |row: u32| !path.contains(&row) && !points.contains(&row) && (self.is_movable)(row);
        let ways = plan_free(self.mesh, &tip, direction, &self.quality, &is_movable)?;
        let exact = Ways { exact: ways.exact, ..Ways::default() };
        match self.take(&tip, &exact, &Opening::Whole(path)) {
            Ok(advance) => Ok(advance.vertex),
            // A vertex that cannot be moved, so near to the line that no other fits beside it.
            Err(refusal) => {
                let is_beside = |reaches: u32, turn: f64| may_miss && turn <= BESIDE && !path.contains(&reaches);
                let at_vertex = ways.snaps.into_iter().find(|way| is_beside(way.reaches, way.deviation));
                at_vertex.map(|way| way.reaches).ok_or(refusal)
            }
        }
    }

    /// Raises the smallest angle along the line by flips, slides and collapses beside it; the one \[rad\] that is left.
    fn mend(&mut self, embedded: &mut EmbeddedCut) -> f64 {
        let mut worst = self.worst_along(&embedded.path);
        for _ in 0..MENDS * embedded.path.len() {
            let Some((angle, triangle)) = worst.filter(|(angle, _)| *angle < self.quality.good) else { break };
            let start = self.scratch.records.len();
            let mut best: Option<(f64, Edit)> = None;
            for edit in self.mends(embedded, triangle) {
                let gained = self.try_mend(embedded, &edit).map_or(0.0, |(angle, _)| angle);
                self.roll_back(start);
                if gained > best.as_ref().map_or(angle + MEND_GAIN, |(most, _)| *most) {
                    best = Some((gained, edit));
                }
            }
            let Some((_, edit)) = best else { break };
            let Some((_, path)) = self.try_mend(embedded, &edit) else { break };
            *embedded = path;
            worst = self.worst_along(&embedded.path);
        }
        worst.map_or(std::f64::consts::PI, |(angle, _)| angle)
    }

    /// Does a mend and the flips that follow; the smallest angle \[rad\] along the line and around the moved vertices, and the
    /// line.
    fn try_mend(&mut self, embedded: &EmbeddedCut, edit: &Edit) -> Option<(f64, EmbeddedCut)> {
        let start = self.scratch.records.len();
        self.edit(edit).ok()?;
        let record = self.scratch.records.get(start)?;
        let after = |row: &u32| record.vertex_after(*row);
        let embedded = EmbeddedCut {
            path: embedded.path.iter().filter_map(after).collect(),
            points: embedded.points.iter().filter_map(after).collect(),
        };
        let into = match *edit {
            Edit::Collapse { into, .. } => record.vertex_after(into),
            _ => record.moved().map(|(row, _)| row),
        };
        let around = into.map_or(SmallVec::new(), |row| self.mesh.topology.incident[row as usize].clone());
        let star = around.iter().map(|&entry| self.angle_of(entry / 3)).fold(std::f64::consts::PI, f64::min);
        self.relax(start, &embedded.path);
        let (angle, _) = self.worst_along(&embedded.path)?;
        Some((angle.min(star), embedded))
    }

    /// Edits that may mend a triangle: the other diagonal of an edge, a vertex moved along an edge, or taken out.
    fn mends(&self, embedded: &EmbeddedCut, triangle: u32) -> Vec<Edit> {
        let corners = self.mesh.triangles.corners[triangle as usize];
        let neighbours = self.mesh.topology.neighbours[triangle as usize];
        let is_embedded = |a: u32, b: u32| embedded.path.windows(2).any(|edge| *edge == [a, b] || *edge == [b, a]);
        let mut mends = Vec::new();
        let may_flip =
            |other: u32| other != NONE && crate::systems::fracture::cut::relax::may_flip(self.mesh, triangle, other);
        let flips =
            (0..3).filter(|&edge| !is_embedded(corners[edge], corners[(edge + 1) % 3]) && may_flip(neighbours[edge]));
        mends.extend(flips.map(|edge| Edit::Flip { triangle, edge }));
        let across = neighbours.iter().filter_map(|&n| self.mesh.triangles.corners.get(n as usize)).flatten();
        let mut around: SmallVec<[u32; 8]> = corners.iter().chain(across).copied().collect();
        around.sort_unstable();
        around.dedup();
        for vertex in around {
            let ends = self.mesh.topology.fan(vertex);
            let ends =
                ends.sectors.iter().map(|&(t, corner)| self.mesh.triangles.corners[t as usize][(corner + 1) % 3]);
            if let Some(place) = embedded.path.iter().position(|&row| row == vertex) {
                if self.may_leave(embedded, place) {
                    let beside = [embedded.path[place - 1], embedded.path[place + 1]];
                    mends.extend(beside.map(|into| Edit::Collapse { vertex, into }));
                }
            } else if (self.is_movable)(vertex) && crate::systems::fracture::cut::relax::may_slide(self.mesh, vertex) {
                for end in ends {
                    mends.push(Edit::Collapse { vertex, into: end });
                    mends.extend(SLIDES.map(|weight| Edit::Slide { vertex, towards: end, weight }));
                }
            }
        }
        mends
    }

    /// Whether a vertex of the line is no point that was asked for, and its neighbours on the line keep the line without it.
    fn may_leave(&self, embedded: &EmbeddedCut, place: usize) -> bool {
        let (Some(&before), Some(&after)) =
            (place.checked_sub(1).and_then(|i| embedded.path.get(i)), embedded.path.get(place + 1))
        else {
            return false;
        };
        let row = embedded.path[place];
        let [a, p, b] = [before, row, after].map(|row| self.mesh.vertices.rest_position[row as usize]);
        embedded.path.len() > 3
            && !embedded.points.contains(&row)
            && (self.is_movable)(row)
            && crate::systems::fracture::cut::relax::may_slide(self.mesh, row)
            && crate::systems::fracture::cut::cut_line::distance_to_segment(p, a, b) <= STRAIGHT_LINE * a.distance(b)
    }

    /// The smallest rest angle \[rad\] of the triangles at a line and of their neighbours, with its triangle.
    fn worst_along(&self, path: &[u32]) -> Option<(f64, u32)> {
        let topology = &self.mesh.topology;
        let at_line = path.iter().flat_map(|&row| topology.incident[row as usize].iter().map(|entry| entry / 3));
        let mut rows: Vec<u32> = at_line
            .flat_map(|row| std::iter::once(row).chain(topology.neighbours[row as usize]))
            .filter(|&row| row != NONE)
            .collect();
        rows.sort_unstable();
        rows.dedup();
        rows.into_iter().map(|row| (self.angle_of(row), row)).min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Opens the edges of a line that do not lie on the boundary.
    fn open_embedded(&mut self, path: &[u32]) -> Result<CutOutcome, TearRefusal> {
        let at = |cutter: &Self, row: u32| cutter.mesh.vertices.rest_position[row as usize];
        let mut outcome = CutOutcome { path: path.iter().map(|&row| at(self, row)).collect(), ..CutOutcome::default() };
        let (Some(&first), Some(&last)) = (path.first(), path.last()) else { return Err(TearRefusal::BadPolyline) };
        outcome.ends = [first, last];
        let is_rim = |cutter: &Self, row: u32| cutter.mesh.topology.is_boundary_vertex(row);
        outcome.has_met_boundary = is_rim(self, last) || first == last;
        let towards = |from: DVec3, to: DVec3| (from - to).normalize_or_zero();
        if let [start, second, .., before, end] | [start, second @ before, end] | [start @ before, second @ end] =
            outcome.path.as_slice()
            && first != last
        {
            let tips = [(first, towards(*start, *second)), (last, towards(*end, *before))];
            outcome.tips.extend(tips.into_iter().filter(|&(row, _)| !is_rim(self, row)));
        }
        let mut pieces: Vec<Vec<u32>> = Vec::new();
        let mut piece = vec![first];
        for edge in path.windows(2) {
            let corners = &self.mesh.triangles.corners;
            let sides = [(edge[0], edge[1]), (edge[1], edge[0])];
            let is_inside = sides.iter().all(|&(a, b)| self.mesh.topology.directed_edge(corners, a, b).is_some());
            if is_inside {
                piece.push(edge[1]);
            }
            if !is_inside || is_rim(self, edge[1]) {
                pieces.push(std::mem::replace(&mut piece, vec![edge[1]]));
            }
        }
        pieces.push(piece);
        for piece in pieces.into_iter().filter(|piece| piece.len() > 1) {
            self.open_piece(piece, &mut outcome)?;
        }
        Ok(outcome)
    }

    fn open_piece(&mut self, mut piece: Vec<u32>, outcome: &mut CutOutcome) -> Result<(), TearRefusal> {
        // The opening before may have parted the vertex at which this one begins.
        if !self.mesh.topology.is_edge(&self.mesh.triangles.corners, piece[0], piece[1]) {
            let end = self.mesh.vertices.rest_position[piece[0] as usize];
            let fan = self.mesh.topology.fan(piece[1]);
            let spokes = fan.sectors.iter().flat_map(|&(t, _)| self.mesh.triangles.corners[t as usize]);
            let twin = spokes.into_iter().find(|&row| self.mesh.vertices.rest_position[row as usize] == end);
            piece[0] = twin.ok_or(Refusal::NoSuchEdge { from: piece[0], to: piece[1] })?;
        }
        let (first, last) = (piece[0], piece[piece.len() - 1]);
        let starts_at_rim = self.mesh.topology.is_boundary_vertex(first);
        let ends_at_rim = self.mesh.topology.is_boundary_vertex(last);
        self.make_room_to_walk();
        let before = piece[piece.len() - 2];
        self.edit(&Edit::Open { path: piece.as_slice().into() })?;
        if starts_at_rim && ends_at_rim || first == last {
            outcome.freed.extend(self.freed_fragment(before, last));
        }
        Ok(())
    }
}

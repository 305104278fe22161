//! The blade: a cut along a polyline in the rest shape. From the boundary it is a notch, from inside a slit with two tips.
//!
//! The line is coarsened to the resolution of the mesh and broken into strokes where it meets a boundary or itself; each stroke
//! is cut by itself. Its points become vertices first; then the cut runs from one to the next like a tear on a given path, so
//! that it ends exactly where it should. Where that would leave the line, the line is embedded into the mesh before it opens.

use crate::event::Course;
use crate::storage::{Edit, Refusal};
use crate::systems::fracture::cut::advance::Opening;
use crate::systems::fracture::cut::cut_line::{distance_to_segment, length, thinned};
use crate::systems::fracture::cut::place::{NEAR_END, TOO_NEAR_END};
use crate::systems::fracture::{Advance, Cutter, TearRefusal, TipChart, Way, Ways, plan_free};
use glam::DVec3;
use smallvec::{SmallVec, smallvec};

/// Points this near to the line through their neighbours, as a part of its length, say nothing.
const COLLINEAR: f64 = 1e-9;
/// Parts of the mean edge by which a line that is too fine for the mesh is thinned, one after the other.
const COARSER: [f64; 4] = [0.03, 0.06, 0.12, 0.25];
/// Part of a cut's length in the body that may be left out, where strokes find no room between lips.
const MOST_LEFT_OUT: f64 = 0.5;

/// Deviations allowed to a cut for the sake of good triangles, the best first.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Manner {
    /// The cut stays on its line.
    OnTheLine,
    /// Ends go to boundary vertices that are all but there, the line to vertices in its way.
    EndsMoved,
    /// The cut leaves its line.
    BesideTheLine,
}

/// All manners, the best first.
const MANNERS: [Manner; 3] = [Manner::OnTheLine, Manner::EndsMoved, Manner::BesideTheLine];

/// Outcome of one stroke of a cut.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CutOutcome {
    /// Points along the cut \[mm, rest shape\].
    pub path: Vec<DVec3>,
    /// Rows of the vertices where it begins and ends.
    pub ends: [u32; 2],
    /// Rows of the tips and the directions \[unit, rest shape\] in which they point.
    pub tips: SmallVec<[(u32, DVec3); 2]>,
    /// Numbers of triangles of the fragments cut free.
    pub freed: SmallVec<[usize; 2]>,
    /// Whether the stroke has run into a boundary.
    pub has_met_boundary: bool,
    /// Largest distance \[mm\] of a point of the cut from the polyline.
    pub off_line: f64,
    /// Smallest angle \[rad\] of the triangles whose shape has changed.
    pub smallest_angle: f64,
}

impl CutOutcome {
    /// Reverses the stroke, so that it begins at its end.
    fn reversed(mut self) -> Self {
        self.path.reverse();
        self.tips.reverse();
        self.ends.reverse();
        self.has_met_boundary = !self.tips.iter().any(|(row, _)| *row == self.ends[1]);
        self
    }
}

impl Cutter<'_, '_> {
    /// Cuts along a polyline of at least two points \[mm, rest shape\], taken at the nearest points of the surface. A first
    /// point on the boundary, or nearer to it than a tenth of a triangle's height, starts a notch there. Parts outside the body
    /// are left out, and behind a boundary the cut goes on: one outcome per stroke, at least one. An end that finds no room
    /// goes up to half an edge along its line, to the boundary if that is there, or else to a vertex within an edge. Strokes that find
    /// no room are left out, up to half of the length.
    ///
    /// # Errors
    /// Why the cut cannot be made; the mesh is as it was.
    pub fn cut(&mut self, polyline: &[DVec3]) -> Result<Vec<CutOutcome>, TearRefusal> {
        if polyline.iter().any(|point| !point.is_finite()) {
            return Err(TearRefusal::BadPolyline);
        }
        let edge = self.mean_edge();
        let rounding = COLLINEAR * length(polyline);
        let tolerances = std::iter::once(rounding).chain(COARSER.map(|part| part * edge));
        let is_reversed = self.is_cut_backwards(polyline);
        let turned: Vec<DVec3> = if is_reversed { polyline.iter().rev().copied().collect() } else { polyline.to_vec() };
        let mut lines: Vec<Vec<DVec3>> = tolerances.map(|t| thinned(&turned, t.max(rounding))).collect();
        lines.dedup_by(|coarser, finer| coarser.len() >= finer.len());
        let mut outcomes = self.cut_lines(&lines, polyline);
        let lacks_room = |why: &TearRefusal| !matches!(why, TearRefusal::BadPolyline | TearRefusal::OutsideBody);
        if outcomes.as_ref().is_err_and(lacks_room) {
            // The first refusal is reported: it is that of the line as it was asked for.
            for variants in [Self::shifted, Self::at_vertices] {
                let moved = variants(self, &lines, edge).into_iter().find_map(|(lines, shift)| {
                    let mut moved = self.cut_lines(&lines, polyline).ok()?;
                    moved.iter_mut().for_each(|outcome| outcome.off_line = outcome.off_line.max(shift));
                    Some(moved)
                });
                if let Some(moved) = moved {
                    outcomes = Ok(moved);
                    break;
                }
            }
            if outcomes.is_err()
                && let Some(line) = lines.first().filter(|line| self.has_free_ends(line, edge))
                && let Some(parts) = self.cut_parts(line, polyline)
            {
                outcomes = Ok(parts);
            }
        }
        let outcomes = outcomes?;
        Ok(if is_reversed { outcomes.into_iter().rev().map(CutOutcome::reversed).collect() } else { outcomes })
    }

    /// Cuts along the first of several lines that can be cut, in the best manner that can be. After an error everything is as it was.
    fn cut_lines(&mut self, lines: &[Vec<DVec3>], polyline: &[DVec3]) -> Result<Vec<CutOutcome>, TearRefusal> {
        let mark = self.scratch.records.len();
        let mut refused = None;
        for manner in MANNERS {
            for line in lines {
                match self.cut_strokes(line, polyline, manner) {
                    Ok(outcomes) => return Ok(outcomes),
                    Err(refusal) => {
                        self.roll_back(mark);
                        refused.get_or_insert(refusal);
                    }
                }
            }
        }
        Err(refused.unwrap_or(TearRefusal::BadPolyline))
    }

    /// Cuts the strokes of a line that can be cut, more than half of its length at the least. After `None` everything is as it was.
    fn cut_parts(&mut self, line: &[DVec3], polyline: &[DVec3]) -> Option<Vec<CutOutcome>> {
        let (mark, strokes) = (self.scratch.records.len(), self.strokes(line));
        let (mut outcomes, mut left_out) = (Vec::new(), 0.0);
        for stroke in &strokes {
            let mut made = None;
            for manner in MANNERS {
                let before = self.scratch.records.len();
                made = self.cut_stroke(stroke, polyline, manner).ok();
                if made.is_some() {
                    break;
                }
                self.roll_back(before);
            }
            left_out += if made.is_some() { 0.0 } else { length(stroke) };
            outcomes.extend(made);
        }
        let is_most = left_out < MOST_LEFT_OUT * strokes.iter().map(|stroke| length(stroke)).sum::<f64>();
        if !is_most {
            self.roll_back(mark);
        }
        is_most.then_some(outcomes)
    }

    /// Whether a line is cut from its last point: from the end on the boundary, else from the one nearer to the body's middle. The
    /// same line given from its other end leaves the same lips, also where vertices moved on a curved surface change it.
    fn is_cut_backwards(&self, polyline: &[DVec3]) -> bool {
        let (Some(&first), Some(&last)) = (polyline.first(), polyline.last()) else { return false };
        let [enters, leaves] = [first, last].map(|point| !self.is_tissue(point));
        if enters != leaves {
            return leaves;
        }
        let rest = &self.mesh.vertices.rest_position;
        let middle = rest.iter().sum::<DVec3>() / rest.len().max(1) as f64;
        let (here, there) = (first.distance(middle), last.distance(middle));
        let is_tied = (here - there).abs() <= COLLINEAR * here.max(there);
        if is_tied { first.to_array() < last.to_array() } else { here > there }
    }

    fn cut_strokes(
        &mut self,
        line: &[DVec3],
        polyline: &[DVec3],
        manner: Manner,
    ) -> Result<Vec<CutOutcome>, TearRefusal> {
        if line.len() < 2 {
            return Err(TearRefusal::BadPolyline);
        }
        let strokes = self.strokes(line);
        if strokes.is_empty() {
            return Err(TearRefusal::OutsideBody);
        }
        strokes.iter().map(|stroke| self.cut_stroke(stroke, polyline, manner)).collect()
    }

    fn cut_stroke(&mut self, stroke: &[DVec3], polyline: &[DVec3], manner: Manner) -> Result<CutOutcome, TearRefusal> {
        let mark = self.scratch.records.len();
        match manner {
            Manner::OnTheLine => {
                if let Ok((outcome, true)) = self.cut_through(stroke, polyline, 0.0) {
                    return Ok(outcome);
                }
                self.roll_back(mark);
                self.cut_embedded(stroke, polyline, 0.0).or_else(|refusal| {
                    // A stroke that finds no way from one end may find it from the other.
                    self.roll_back(mark);
                    let reversed: Vec<DVec3> = stroke.iter().rev().copied().collect();
                    self.cut_embedded(&reversed, polyline, 0.0).map(CutOutcome::reversed).map_err(|_| refusal)
                })
            }
            Manner::EndsMoved => self.cut_embedded(stroke, polyline, TOO_NEAR_END),
            Manner::BesideTheLine => self.cut_through(stroke, polyline, NEAR_END).map(|(outcome, _)| outcome),
        }
    }

    /// Mean length \[mm\] of the edges in the rest shape: the resolution of the mesh.
    fn mean_edge(&self) -> f64 {
        let triangles = 0..self.mesh.triangles.corners.len() as u32;
        let count = (3 * triangles.len()).max(1) as f64;
        let around = |x: [DVec3; 3]| x[0].distance(x[1]) + x[1].distance(x[2]) + x[2].distance(x[0]);
        triangles.map(|row| around(self.rest_of(row))).sum::<f64>() / count
    }

    /// The rows of vertices at the points of a stroke, in their order.
    pub(in crate::systems::fracture) fn place_all(
        &mut self,
        stroke: &[DVec3],
        miss: f64,
    ) -> Result<SmallVec<[u32; 8]>, TearRefusal> {
        let mut targets: SmallVec<[u32; 8]> = SmallVec::new();
        for (i, &point) in stroke.iter().enumerate() {
            // The lip at which it begins or ends is the one on its own side.
            let inwards = match i {
                0 => stroke.get(1),
                _ if i + 1 == stroke.len() => stroke.get(i - 1),
                _ => None,
            };
            let row = self.place(point, inwards.copied(), &targets, miss)?;
            if targets.last() != Some(&row) {
                targets.push(row);
            }
        }
        Ok(targets)
    }

    /// Cuts one stroke, edge by edge; also returns whether it has kept to its line.
    fn cut_through(
        &mut self,
        stroke: &[DVec3],
        polyline: &[DVec3],
        miss: f64,
    ) -> Result<(CutOutcome, bool), TearRefusal> {
        let mark = self.scratch.records.len();
        let targets = self.place_all(stroke, miss)?;
        let &[first, second, ..] = targets.as_slice() else { return Err(TearRefusal::BadPolyline) };
        let mut run = Run { outcome: CutOutcome::default(), held: targets.clone(), tip: first, is_exact: true };
        run.outcome.path.push(self.at(first));
        let mut next = 1;
        let starts_inside = !self.mesh.topology.is_boundary_vertex(first);
        if starts_inside {
            next = self.begin_slit(&mut run, &targets)?;
        }
        while let Some(&target) = targets.get(next) {
            if run.outcome.has_met_boundary || run.tip == target {
                // Points behind a boundary are not reached this way.
                run.is_exact &= run.tip == target;
                next += 1;
                continue;
            }
            let from = run.tip;
            let advance = self.step_towards(from, target, next, &run.held, &Opening::After(&[from]))?;
            self.pass(&mut run, advance);
        }
        let mut outcome = std::mem::take(&mut run.outcome);
        outcome.ends = [first, run.tip];
        if !outcome.has_met_boundary {
            let count = outcome.path.len();
            outcome.tips.push((run.tip, (outcome.path[count - 1] - outcome.path[count - 2]).normalize_or_zero()));
        }
        let has_closed = outcome.has_met_boundary && run.tip == first;
        if starts_inside && !has_closed {
            let towards = outcome.path.get(1).copied().unwrap_or(self.at(second));
            outcome.tips.insert(0, (first, (self.at(first) - towards).normalize_or_zero()));
        }
        outcome.off_line = off_line(&outcome.path, polyline);
        outcome.smallest_angle = self.smallest_touched(mark);
        Ok((outcome, run.is_exact))
    }

    /// Opens the first two edges of a slit at once, since one edge inside the surface cannot open. Returns the index of
    /// the point the cut is on its way to.
    fn begin_slit(&mut self, run: &mut Run, targets: &[u32]) -> Result<usize, TearRefusal> {
        let (first, mut next) = (targets[0], 1);
        let start = self.scratch.records.len();
        let second = targets[next];
        let is_adjacent = self.mesh.topology.is_edge(&self.mesh.triangles.corners, first, second);
        let advance = if is_adjacent && targets.len() == 2 {
            let corners = &self.mesh.triangles.corners;
            let missing = Refusal::NoSuchEdge { from: first, to: second };
            let (triangle, edge) = self.mesh.topology.directed_edge(corners, first, second).ok_or(missing)?;
            let edits = smallvec![Edit::SplitEdge { triangle, edge, weight: 0.5 }];
            let reaches = self.mesh.vertices.len() as u32;
            let way = Way { edits, reaches, deviation: 0.0, course: Course::Exact };
            let tip = TipChart::new(self.mesh, first)?;
            self.take(&tip, &Ways::only(way), &Opening::Later)?
        } else {
            self.step_towards(first, second, next, &run.held, &Opening::Later)?
        };
        run.held.push(advance.vertex);
        if advance.end.is_some() {
            // The first step has met the boundary already: a notch from its other end.
            self.edit(&Edit::Open { path: smallvec![advance.vertex, first] })?;
            self.relax(start, &[]);
            self.pass(run, advance);
            return Ok(next);
        }
        self.pass(run, advance);
        if run.tip == second {
            next += 1;
        }
        let &target = targets.get(next).ok_or(TearRefusal::BadPolyline)?;
        let path = [first, run.tip];
        let advance = self.step_towards(run.tip, target, next, &run.held, &Opening::After(&path))?;
        self.pass(run, advance);
        Ok(next)
    }

    fn pass(&self, run: &mut Run, advance: Advance) {
        run.tip = advance.vertex;
        run.is_exact &= advance.course == Course::Exact;
        run.outcome.path.push(advance.to);
        if let Some(end) = advance.end {
            run.outcome.has_met_boundary = true;
            run.outcome.freed.extend(end.freed);
        }
    }

    /// Cuts one step from a vertex towards another, which it reaches where an edge joins them.
    fn step_towards(
        &mut self,
        from: u32,
        target: u32,
        point: usize,
        held: &[u32],
        opening: &Opening<'_>,
    ) -> Result<Advance, TearRefusal> {
        let tip = TipChart::new(self.mesh, from)?;
        let joining = (0..tip.spoke_count()).find(|&k| tip.end(self.mesh, k) == Some(target));
        let ways = match joining {
            Some(spoke) if tip.is_inside(spoke) => Ways::only(Way::along_edge(target, 0.0, Course::Exact)),
            Some(_) => return Err(TearRefusal::OutsideFan { vertex: from }),
            None => {
                let direction = tip.chart.to_chart(self.direction(from, target));
                let is_movable = |row: u32| !held.contains(&row) && (self.is_movable)(row);
                let ways = plan_free(self.mesh, &tip, direction, &self.quality, &is_movable)?;
                // A blade goes where it is led: on the line if that leaves fair triangles, else beside it; no detours.
                let exact = Ways { exact: ways.exact.clone(), ..Ways::default() };
                if let Ok(advance) = self.take(&tip, &exact, opening) {
                    return self.nearer(advance, target, point);
                }
                Ways { detours: SmallVec::new(), ..ways }
            }
        };
        let advance = self.take(&tip, &ways, opening)?;
        self.nearer(advance, target, point)
    }

    fn nearer(&self, advance: Advance, target: u32, point: usize) -> Result<Advance, TearRefusal> {
        let goal = self.at(target);
        let is_nearer = advance.to.distance(goal) < advance.from.distance(goal) * (1.0 - 1e-9);
        if is_nearer { Ok(advance) } else { Err(TearRefusal::NoProgress { point }) }
    }

    fn at(&self, vertex: u32) -> DVec3 {
        self.mesh.vertices.rest_position[vertex as usize]
    }
}

/// A cut on its way.
struct Run {
    outcome: CutOutcome,
    /// Vertices that must stay where they are.
    held: SmallVec<[u32; 8]>,
    tip: u32,
    is_exact: bool,
}

pub(in crate::systems::fracture) fn off_line(path: &[DVec3], polyline: &[DVec3]) -> f64 {
    let to_line =
        |&p: &DVec3| polyline.windows(2).map(|s| distance_to_segment(p, s[0], s[1])).fold(f64::INFINITY, f64::min);
    path.iter().map(to_line).fold(0.0, f64::max)
}

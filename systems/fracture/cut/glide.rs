//! A tip that glides: its vertex moves within its triangles, in the rest shape and in space, and the mesh around it follows.
//!
//! The field ahead stays as it is and topology changes only now and then: lips that have grown long are halved, a vertex near ahead is
//! collapsed into the tip, poor angles are flipped away.

use super::relax::{is_flat, may_slide};
use crate::event::Course;
use crate::math::SmallestAngle;
use crate::storage::{Edit, NONE};
use crate::systems::fracture::{Advance, Cutter, TearRefusal, TipChart};
use glam::DVec3;

/// Largest part of the way to the far edge of its triangle that a tip goes at once.
const PART: f64 = 0.5;
/// Length of lip edges from which on both are halved, in edges of the mesh.
const LONG: f64 = 1.2;
/// Distance of a vertex ahead below which it is collapsed into the tip, in edges.
const NEAR: f64 = 0.5;
/// Vertices so far behind the tip are not ahead: cosine of the angle to the direction.
const BEHIND: f64 = -0.3;
/// Distance from the boundary \[edges\] at which a tip no longer glides towards it.
const RIM: f64 = 0.6;
/// Largest sine of the angle between two lips, and their largest relative difference in length.
const ALONGSIDE: f64 = 1e-6;
const EVEN: f64 = 1e-9;
/// Maximum parts of one glide, changes of lips included.
const PARTS: usize = 8;

/// The lips at a tip.
enum Lips {
    /// They meet there, of equal length.
    Even,
    /// An edit has evened or halved them.
    Edited,
    /// The tip has none, or they cannot be evened.
    None,
}

impl Cutter<'_, '_> {
    /// Lets a tip glide at most `length` \[mm\] in a unit direction of the rest shape; `edge` \[mm\] is the size of the triangles there.
    ///
    /// # Errors
    /// Why it does not glide at all; the mesh is as it was but for lips that were evened.
    pub fn glide(&mut self, vertex: u32, direction: DVec3, length: f64, edge: f64) -> Result<Advance, TearRefusal> {
        let from = self.mesh.vertices.rest_position[vertex as usize];
        let (mut tip, mut left, mut smallest_angle) = (vertex, length, std::f64::consts::PI);
        let mut refusal = TearRefusal::OutsideFan { vertex };
        for _ in 0..PARTS {
            let chart = TipChart::new(self.mesh, tip)?;
            match self.even_lips(&chart, edge) {
                Lips::Even => {}
                Lips::Edited => continue,
                Lips::None => break,
            }
            match self.glide_once(&chart, direction, left, edge) {
                Ok((moved, to, angle)) => {
                    (tip, left, smallest_angle) = (to, left - moved, smallest_angle.min(angle));
                }
                Err(reason) => {
                    refusal = reason;
                    break;
                }
            }
            if left <= EVEN * edge {
                break;
            }
        }
        if left == length {
            return Err(refusal);
        }
        let to = self.mesh.vertices.rest_position[tip as usize];
        Ok(Advance { from, to, vertex: tip, deviation: 0.0, course: Course::Exact, smallest_angle, end: None })
    }

    /// One part of a glide, within one triangle: its length \[mm\], the row of the tip after it and the smallest angle \[rad\] left. After an
    /// error everything is as it was.
    fn glide_once(
        &mut self,
        tip: &TipChart,
        direction: DVec3,
        left: f64,
        edge: f64,
    ) -> Result<(f64, u32, f64), TearRefusal> {
        let vertex = tip.vertex;
        let outside = TearRefusal::OutsideFan { vertex };
        let exit = tip.chart.exit(tip.chart.to_chart(direction)).ok_or(outside)?;
        let (triangle, corner) = tip.fan.sectors[exit.sector];
        let moved = left.min(PART * exit.distance);
        let across = self.mesh.topology.neighbours[triangle as usize][(corner + 1) % 3];
        let is_near_rim = across == NONE && exit.distance - moved < RIM * edge;
        // Over a border of materials their values would smear.
        let own = self.mesh.triangles.at(triangle);
        let is_uniform = tip.fan.sectors.iter().all(|&(other, _)| own.is_alike(&self.mesh.triangles.at(other)));
        // On a ridge a glide would take the protruding part off.
        if is_near_rim || !is_uniform || !is_flat(self.mesh, vertex) {
            return Err(outside);
        }
        let start = self.scratch.records.len();
        let before = self.smallest_around(tip);
        let least_edge = self.least_edge(tip.fan.sectors.iter().map(|&(triangle, _)| triangle));
        let part = moved / exit.distance;
        let mut weights = [0.0; 3];
        weights[(corner + 1) % 3] = part * (1.0 - exit.along);
        weights[(corner + 2) % 3] = part * exit.along;
        weights[corner] = 1.0 - weights[(corner + 1) % 3] - weights[(corner + 2) % 3];
        self.edit(&Edit::Glide { vertex, triangle, weights })?;
        self.relax(start, &[]);
        let to = self.clear_ahead(vertex, direction, edge);
        let angle = self.smallest_touched(start);
        if !self.is_sound(start, before, least_edge) {
            self.roll_back(start);
            return Err(TearRefusal::NoRoom { angle });
        }
        Ok((moved, to, angle))
    }

    /// Whether the records from `start` on leave no angle and no edge smaller than is allowed or was there before \[rad, mm\].
    fn is_sound(&self, start: usize, before: f64, least_edge: f64) -> bool {
        self.smallest_touched(start) >= self.quality.least.min(before) && !self.leaves_shorter_edges(start, least_edge)
    }

    /// Evens the lips at a tip: the longer is split at the length of the shorter, and both are halved where they are long.
    fn even_lips(&mut self, tip: &TipChart, edge: f64) -> Lips {
        if tip.fan.is_closed {
            return Lips::None;
        }
        let ends = (tip.end(self.mesh, 0), tip.end(self.mesh, tip.spoke_count() - 1));
        let (Some(a), Some(b)) = ends else { return Lips::None };
        let at = |row: u32| self.mesh.vertices.rest_position[row as usize];
        let (to_a, to_b) = (at(a) - at(tip.vertex), at(b) - at(tip.vertex));
        let (long_a, long_b) = (to_a.length(), to_b.length());
        let is_alongside = to_a.dot(to_b) > 0.0 && to_a.cross(to_b).length() < ALONGSIDE * long_a * long_b;
        if a == b || !is_alongside {
            return Lips::None;
        }
        let start = self.scratch.records.len();
        let before = self.smallest_around(tip);
        let least_edge = self.least_edge(tip.fan.sectors.iter().map(|&(triangle, _)| triangle));
        let is_done = if (long_a - long_b).abs() > EVEN * long_a.max(long_b) {
            let (lip, distance) = if long_a > long_b { (a, long_b) } else { (b, long_a) };
            self.split_lip(tip.vertex, lip, distance)
        } else if long_a > LONG * edge {
            self.split_lip(tip.vertex, a, 0.5 * long_a) && self.split_lip(tip.vertex, b, 0.5 * long_b)
        } else {
            return Lips::Even;
        };
        self.relax(start, &[]);
        if !is_done || !self.is_sound(start, before, least_edge) {
            self.roll_back(start);
            return Lips::None;
        }
        Lips::Edited
    }

    /// Splits the boundary edge between a tip and a lip's vertex at a distance \[mm\] from the tip; whether it did.
    fn split_lip(&mut self, tip: u32, lip: u32, distance: f64) -> bool {
        let (corners, topology) = (&self.mesh.triangles.corners, &*self.mesh.topology);
        let length = {
            let at = |row: u32| self.mesh.vertices.rest_position[row as usize];
            at(tip).distance(at(lip))
        };
        let edges = topology.incident[tip as usize].iter().flat_map(|entry| (0..3).map(move |edge| (entry / 3, edge)));
        let found = edges
            .map(|(t, edge)| (t, edge, corners[t as usize][edge], corners[t as usize][(edge + 1) % 3]))
            .find(|&(t, edge, from, to)| {
                topology.neighbours[t as usize][edge] == NONE && ((from, to) == (tip, lip) || (to, from) == (tip, lip))
            });
        let Some((triangle, edge, from, _)) = found else { return false };
        let weight = if from == tip { distance / length } else { 1.0 - distance / length };
        self.edit(&Edit::SplitEdge { triangle, edge, weight }).is_ok()
    }

    /// Collapses the nearest vertex ahead of a tip into it where that is near and leaves good angles; the tip's row after it.
    fn clear_ahead(&mut self, vertex: u32, direction: DVec3, edge: f64) -> u32 {
        let Ok(tip) = TipChart::new(self.mesh, vertex) else { return vertex };
        let at = |row: u32| self.mesh.vertices.rest_position[row as usize];
        let is_ahead = |&row: &u32| {
            let way = at(row) - at(vertex);
            way.length() < NEAR * edge && way.dot(direction) > BEHIND * way.length()
        };
        let inner = (1..tip.spoke_count().saturating_sub(1)).filter_map(|spoke| tip.end(self.mesh, spoke));
        let movable = inner.filter(is_ahead).filter(|&row| may_slide(self.mesh, row) && (self.is_movable)(row));
        let distance_sq = |row: &u32| at(*row).distance_squared(at(vertex));
        let Some(near) = movable.min_by(|a, b| distance_sq(a).total_cmp(&distance_sq(b))) else { return vertex };
        let around = self.mesh.topology.incident[near as usize].iter().map(|entry| self.rest_of(entry / 3));
        let before = SmallestAngle::among(around).map_or(0.0, |angle| angle.radians());
        let start = self.scratch.records.len();
        if self.edit(&Edit::Collapse { vertex: near, into: vertex }).is_err() {
            return vertex;
        }
        let after = self.scratch.records[start].vertex_after(vertex).unwrap_or(vertex);
        self.relax(start, &[]);
        if self.smallest_touched(start) < before.min(self.quality.exact) {
            self.roll_back(start);
            return vertex;
        }
        after
    }
}

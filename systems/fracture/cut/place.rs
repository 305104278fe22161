//! Bringing a vertex to a given point of the rest surface.

use crate::math::nearest_in_triangle;
use crate::storage::{Edit, NONE, Refusal};
use crate::systems::fracture::cut::locate::{SurfacePoint, distance_to_triangle};
use crate::systems::fracture::cut::relax::may_slide;
use crate::systems::fracture::{Cutter, TearRefusal};
use glam::DVec3;
use smallvec::{SmallVec, smallvec};

/// A barycentric weight below this is zero: over a triangle of 1 mm that is 1e-9 mm.
const ON_EDGE: f64 = 1e-9;
/// A point nearer to a boundary edge than this part of the triangle's height is put on it: no ligament so thin could be meshed.
pub(in crate::systems::fracture) const ON_BOUNDARY: f64 = 0.1;
/// A point on a boundary edge may be moved to an end of the edge if that is nearer than this part of its length.
pub(in crate::systems::fracture) const NEAR_END: f64 = 0.25;
/// A point from which a cut should not be moved may be put to an end of its edge only if that is nearer than this part of the
/// length: nearer, no vertex can be put beside the end.
pub(in crate::systems::fracture) const TOO_NEAR_END: f64 = 0.03;
/// A corner is moved to a point inside its triangle if its barycentric weight there is at least this.
const NEAR_CORNER: f64 = 0.4;

/// Distance over which a lip is probed for the tissue behind it, as a part of its triangle's size.
const PROBE: f64 = 1e-3;

/// Edits that bring a vertex to a point, and its row.
struct Placement {
    edits: SmallVec<[Edit; 2]>,
    vertex: u32,
}

impl Cutter<'_, '_> {
    /// The row of a vertex at the point of the surface nearest to `point`: one that is there, or a new or moved one.
    /// Vertices in `held` stay where they are; of two lips at the same place that on the side of `inwards` is taken. A vertex of the
    /// boundary will do that is no farther than the part `miss` of its edge.
    pub(in crate::systems::fracture) fn place(
        &mut self,
        point: DVec3,
        inwards: Option<DVec3>,
        held: &[u32],
        miss: f64,
    ) -> Result<u32, TearRefusal> {
        let nearest = self.nearest(point).ok_or(TearRefusal::BadPolyline)?;
        let at = inwards.and_then(|inwards| self.on_side(nearest, inwards)).unwrap_or(nearest);
        let corners = self.mesh.triangles.corners[at.triangle as usize];
        if let Some(corner) = (0..3).find(|&i| at.weights[i] >= 1.0 - ON_EDGE) {
            return Ok(corners[corner]);
        }
        let before = self.smallest_near(at.triangle)?;
        // A point on the boundary stays where it is if it can at all.
        let stays = miss < NEAR_END && self.is_near_rim(&at);
        let mut best: Option<(f64, Placement)> = None;
        for placement in self.placements(&at, held, miss) {
            if stays && best.as_ref().is_some_and(|(angle, _)| *angle >= self.quality.least.min(before)) {
                break;
            }
            let start = self.scratch.records.len();
            let Ok(angle) = self.try_placement(&placement) else { continue };
            if angle >= self.quality.good.min(before) {
                return Ok(placement.vertex);
            }
            self.roll_back(start);
            if best.as_ref().is_none_or(|(least, _)| angle > *least) {
                best = Some((angle, placement));
            }
        }
        let angle = best.as_ref().map_or(0.0, |(angle, _)| *angle);
        match best {
            Some((_, placement)) if angle >= self.quality.least.min(before) => {
                self.try_placement(&placement)?;
                Ok(placement.vertex)
            }
            _ => Err(TearRefusal::NoRoom { angle }),
        }
    }

    /// The coinciding place of the boundary on the lip that lies towards a point; `None` inside the surface.
    fn on_side(&self, at: SurfacePoint, inwards: DVec3) -> Option<SurfacePoint> {
        if !self.is_on_rim(&at) {
            return None;
        }
        let place = self.position(&at);
        let size = self.rest_of(at.triangle).iter().map(|x| x.distance(place)).fold(0.0, f64::max);
        let probe = place + (inwards - place).normalize_or_zero() * (PROBE * size);
        let mut best: Option<(f64, SurfacePoint)> = None;
        for triangle in 0..self.mesh.triangles.corners.len() as u32 {
            let x = self.rest_of(triangle);
            let weights = nearest_in_triangle(x, place);
            let here = SurfacePoint { triangle, weights };
            if self.position(&here).distance(place) > ON_EDGE * size {
                continue;
            }
            let distance = distance_to_triangle(x, probe);
            if best.is_none_or(|(least, _)| distance < least - ON_EDGE * size) {
                best = Some((distance, here));
            }
        }
        best.map(|(_, at)| at)
    }

    /// Whether a point is so near to the boundary that it is put onto it.
    fn is_near_rim(&self, at: &SurfacePoint) -> bool {
        let neighbours = self.mesh.topology.neighbours[at.triangle as usize];
        (0..3).any(|edge| neighbours[edge] == NONE && at.weights[(edge + 2) % 3] < ON_BOUNDARY)
    }

    fn placements(&self, at: &SurfacePoint, held: &[u32], miss: f64) -> SmallVec<[Placement; 6]> {
        let SurfacePoint { triangle, weights } = *at;
        let corners = self.mesh.triangles.corners[triangle as usize];
        let neighbours = self.mesh.topology.neighbours[triangle as usize];
        let new = self.mesh.vertices.len() as u32;
        let split = |edge: usize| {
            let (a, b) = (weights[edge], weights[(edge + 1) % 3]);
            let edit = Edit::SplitEdge { triangle, edge, weight: b / (a + b) };
            Placement { edits: smallvec![edit], vertex: new }
        };
        let mut placements = SmallVec::new();
        // The weight of the corner opposite to an edge is the part of the height.
        let opposite = |edge: usize| weights[(edge + 2) % 3];
        let rim = (0..3).filter(|&e| neighbours[e] == NONE && opposite(e) < ON_BOUNDARY);
        if let Some(edge) = rim.min_by(|&e, &f| opposite(e).total_cmp(&opposite(f))) {
            let (a, b) = (weights[edge], weights[(edge + 1) % 3]);
            placements.push(split(edge));
            let near = if a >= b { edge } else { (edge + 1) % 3 };
            if a.min(b) <= miss * (a + b) {
                placements.push(Placement { edits: SmallVec::new(), vertex: corners[near] });
            }
            return placements;
        }
        match (0..3).find(|&edge| opposite(edge) < ON_EDGE) {
            Some(edge) => placements.push(split(edge)),
            None => {
                let edits = smallvec![Edit::SplitTriangle { triangle, weights }];
                placements.push(Placement { edits, vertex: new });
            }
        }
        let mut near: SmallVec<[usize; 3]> = (0..3).filter(|&i| weights[i] >= NEAR_CORNER).collect();
        near.sort_by(|&i, &j| weights[j].total_cmp(&weights[i]));
        for i in near {
            let vertex = corners[i];
            let is_free = !held.contains(&vertex) && (self.is_movable)(vertex) && may_slide(self.mesh, vertex);
            if is_free {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                let slides = [(corners[j], weights[j] / (1.0 - weights[k])), (corners[k], weights[k])];
                let slides = slides.into_iter().filter(|&(_, weight)| weight > ON_EDGE);
                let edits = slides.map(|(towards, weight)| Edit::Slide { vertex, towards, weight }).collect();
                placements.push(Placement { edits, vertex });
            }
        }
        placements
    }

    /// Does the edits and flips around them; the smallest angle \[rad\] that is left. After an error everything is as it was.
    fn try_placement(&mut self, placement: &Placement) -> Result<f64, TearRefusal> {
        let start = self.scratch.records.len();
        for edit in &placement.edits {
            if let Err(refusal) = self.edit(edit) {
                self.roll_back(start);
                return Err(refusal.into());
            }
        }
        self.relax(start, &[]);
        Ok(self.smallest_touched(start))
    }

    /// The smallest rest angle \[rad\] of a triangle and its neighbours.
    pub(in crate::systems::fracture) fn smallest_near(&self, triangle: u32) -> Result<f64, Refusal> {
        let missing = Refusal::NoSuchRow { what: "triangle", row: triangle };
        let neighbours = self.mesh.topology.neighbours.get(triangle as usize).ok_or(missing)?;
        let around = neighbours.iter().filter(|&&n| n != NONE);
        Ok(around.map(|&n| self.angle_of(n)).fold(self.angle_of(triangle), f64::min))
    }
}

//! The search for tissue that fails without a tip: strands narrower than the disc, and tissue stretched too far.

use super::{Surface, strength};
use crate::components::{PartedBy, Parting, TearSite, Tearing};
use crate::math::elementary;
use crate::storage::NONE;
use crate::systems::kernels::failure::{self, Strength};
use glam::{DVec2, DVec3};
use smallvec::{SmallVec, smallvec};
use std::f64::consts::FRAC_PI_2;

/// Triangles on a way across a strand: R has some ten edges at most.
const MOST_CROSSED: usize = 64;
/// Fewest triangles on it: a spike of one or two carries what just they do, and swings.
const FEWEST_CROSSED: usize = 3;
/// Ways into a sector, by where they meet the edge across: some 20° apart, which lengthens the shortest by 2 % at most.
const WAYS: [f64; 3] = [1.0 / 6.0, 0.5, 5.0 / 6.0];

/// Where tissue may part.
pub struct PartingSites<'a> {
    /// Whether a strand whose middle lies here \[mm, rest shape\] may part.
    pub may_part: &'a dyn Fn(DVec3) -> bool,
    /// Vertices of tips.
    pub tips: &'a [u32],
    /// Whether a hold or grip has hold of a vertex.
    pub is_held: &'a dyn Fn(u32) -> bool,
    /// Whether strands are to be looked for: the body has been torn or cut, and not in vain since.
    pub has_strands: bool,
}

/// The place that is farthest beyond what it bears: of strands narrower than R and of triangles beyond the ultimate stretch, those
/// at tips first. Of equal ones strands come first, then the lowest row.
pub fn parting(surface: &Surface, tearing: &Tearing, sites: &PartingSites<'_>) -> Option<Parting> {
    let mut best: Option<Parting> = None;
    let mut offer = |found: Option<Parting>| {
        if let Some(found) = found.filter(|found| found.value > best.map_or(1.0, |best| best.value)) {
            best = Some(found);
        }
    };
    if sites.has_strands {
        let strength = strength(tearing);
        for (t, neighbours) in surface.topology.neighbours.iter().enumerate() {
            for edge in (0..3).filter(|&edge| neighbours[edge] == NONE) {
                let found = across_strand(surface, surface.triangles.corners[t][edge], &strength, tearing.radius);
                offer(found.filter(|found| (sites.may_part)((found.ends[0] + found.ends[1]) * 0.5)));
            }
        }
    }
    if let Some(ultimate) = tearing.ultimate_stretch {
        // Where a tip is at hand it goes on, or openings would stand side by side and nothing would part.
        let mut ahead: Option<Parting> = None;
        for t in 0..surface.triangles.len() {
            let corners = surface.triangles.corners[t];
            let Some(found) = beyond_stretch(surface, t, ultimate) else { continue };
            match corners.iter().find(|corner| sites.tips.contains(corner)) {
                _ if corners.iter().any(|&corner| (sites.is_held)(corner)) => {}
                None => offer(Some(found)),
                Some(&tip) if found.value > ahead.map_or(1.0, |best| best.value) => {
                    let way = found.ends[0] - surface.vertices.rest_position[tip as usize];
                    let direction = found.direction * way.dot(found.direction).signum();
                    ahead = Some(Parting { site: TearSite::Vertex(tip), direction, ..found });
                }
                Some(_) => {}
            }
        }
        best = ahead.or(best);
    }
    best
}

/// A triangle whose greatest principal stretch, one plus the Biot strain from the stress-free state, exceeds the ultimate one.
fn beyond_stretch(surface: &Surface, t: usize, ultimate: f64) -> Option<Parting> {
    let strain = surface.state(t).polar.stretch - surface.triangles.unstretched(t, surface.unstretched);
    let value = (1.0 + strain.principal_values().0) / ultimate;
    if !(value > 1.0) {
        return None;
    }
    let direction = in_space(surface, t, elementary::unit_at(strain.principal_angle() + FRAC_PI_2));
    Some(Parting {
        site: TearSite::Triangle(t as u32),
        fibre: surface.triangles.fibre[t],
        direction,
        value,
        ends: [centroid(surface, t); 2],
        by: PartedBy::Stretch,
    })
}

/// The strand that a vertex of the rim lies at: of straight ways from it that meet the rim again within R, that with the largest criterion,
/// which every triangle on it exceeds. The tension at a rim follows the rim, so that its own direction says little about the way across.
fn across_strand(surface: &Surface, vertex: u32, strength: &Strength, radius: f64) -> Option<Parting> {
    let from = surface.vertices.rest_position[vertex as usize];
    let mut best: Option<Parting> = None;
    for (t, corner) in surface.topology.fan(vertex).sectors {
        if failure::cannot_tear(surface.stress(t as usize), &strength.times(surface.triangles.strength[t as usize])) {
            continue;
        }
        let x = corners(surface, t as usize);
        for part in WAYS {
            let direction = (x[(corner + 1) % 3].lerp(x[(corner + 2) % 3], part) - from).normalize_or_zero();
            let start = Start { triangle: t as usize, at: from, edge: (corner + 1) % 3 };
            let Some((end, value)) = to_rim(surface, &start, direction, strength, radius) else { continue };
            if value > best.map_or(1.0, |best| best.value) {
                let (fibre, ends) = (surface.triangles.fibre[t as usize], [from, end]);
                best = Some(Parting {
                    site: TearSite::Vertex(vertex),
                    fibre,
                    direction,
                    value,
                    ends,
                    by: PartedBy::Strand,
                });
            }
        }
    }
    best
}

/// Where a way leads from a corner of a triangle over the edge across.
struct Start {
    triangle: usize,
    at: DVec3,
    edge: usize,
}

/// Walks straight on over the rest surface: the point of the rim that is met within `most` \[mm\], and the smallest criterion on the
/// way, above 1.
fn to_rim(surface: &Surface, start: &Start, direction: DVec3, strength: &Strength, most: f64) -> Option<(DVec3, f64)> {
    let &Start { triangle: mut t, mut at, edge } = start;
    let (mut way, mut value) = (0.0, f64::INFINITY);
    // The edges that may be left by: not the one that was entered by.
    let mut exits: SmallVec<[usize; 3]> = smallvec![edge];
    for crossed in 1..=MOST_CROSSED {
        let x = corners(surface, t);
        let normal = (x[1] - x[0]).cross(x[2] - x[0]).try_normalize()?;
        let d = (direction - normal * normal.dot(direction)).try_normalize()?;
        let fibre = surface.triangles.fibre[t];
        let in_frame = DVec2::new(d.dot(fibre), d.dot(normal.cross(fibre)));
        let strength = &strength.times(surface.triangles.strength[t]);
        value = f64::min(value, failure::direction_value(surface.stress(t), DVec2::X, strength, in_frame));
        // The nearest edge ahead: where the distance from its line falls to zero.
        let mut exit: Option<(f64, usize)> = None;
        for &edge in &exits {
            let out = (x[(edge + 1) % 3] - x[edge]).cross(normal);
            let (speed, gap) = (out.dot(d), out.dot(x[edge] - at));
            if speed > 0.0 && exit.is_none_or(|(least, _)| gap / speed < least) {
                exit = Some((gap / speed, edge));
            }
        }
        let (length, edge) = exit?;
        (at, way) = (at + d * length.max(0.0), way + length.max(0.0));
        if !(way < most) || !(value > 1.0) {
            return None;
        }
        let next = surface.topology.neighbours[t][edge];
        if next == NONE {
            return (crossed >= FEWEST_CROSSED).then_some((at, value));
        }
        exits = (0..3).filter(|&e| surface.topology.neighbours[next as usize][e] != t as u32).collect();
        t = next as usize;
    }
    None
}

fn corners(surface: &Surface, t: usize) -> [DVec3; 3] {
    surface.triangles.corners[t].map(|v| surface.vertices.rest_position[v as usize])
}

fn centroid(surface: &Surface, t: usize) -> DVec3 {
    let x = corners(surface, t);
    (x[0] + x[1] + x[2]) / 3.0
}

/// A direction of a triangle's frame (fibre, transverse) in the rest shape.
fn in_space(surface: &Surface, t: usize, direction: DVec2) -> DVec3 {
    let (x, fibre) = (corners(surface, t), surface.triangles.fibre[t]);
    let normal = (x[1] - x[0]).cross(x[2] - x[0]).normalize_or_zero();
    (fibre * direction.x + normal.cross(fibre) * direction.y).normalize_or_zero()
}

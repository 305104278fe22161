//! Ligaments: tissue narrower than the disc, between two rims.
//!
//! The places of ligaments follow from the rest shape, so they are found once after each edit; their stress is evaluated in
//! each step.

use crate::components::{LigamentFailure, PartedBy, TearSite};
use crate::math::elementary;
use crate::storage::{NONE, Revision};
use crate::systems::fracture::Surface;
use crate::systems::kernels::failure::{self, Strength};
use glam::{DVec2, DVec3};
use smallvec::{SmallVec, smallvec};

/// Most triangles on a way across a ligament: R has some ten edges at most.
const MOST_CROSSED_BY_LIGAMENT: usize = 64;
/// Fewest triangles on a way across a ligament: a spike of one or two carries only its own load, and swings.
const FEWEST_CROSSED: usize = 3;
/// Ways from one vertex of the rim, the shortest first: which of them is the weakest depends on the fibres.
const WAYS: usize = 3;
/// Ways tried from one vertex: some meet a rim on their way, or cross too few triangles.
const MOST_TRIED: usize = 16;
/// Ways for which there is room.
const ROOM_FOR_WAYS: usize = 256;
/// Largest lean of a way, at either end, from the line halfway between the rim's two edges, over half the angle between those: 60° at
/// a straight rim. Ways along the rim, as the chords of a round one, cut off no ligament.
const LEAN: f64 = 2.0 / 3.0;

/// *Derived.* The ligaments of a body.
#[derive(Clone, Debug, Default)]
pub struct Ligaments {
    /// When, and for which radius \[mm\], they were found.
    found_for: Option<(Revision, f64)>,
    ways: Vec<Way>,
    /// The triangles of all ways, each with the way's direction in its frame (fibre, transverse).
    crossed: Vec<(u32, DVec2)>,
    /// Vertices of the rim by their x, with their ways into the body, while ligaments are looked for.
    rim: Vec<(u32, Option<Inwards>)>,
    /// Lengths \[mm\] of the ways from one of them, with their other ends.
    facing: Vec<(f64, u32)>,
}

/// A straight way over the rest surface from a vertex of the rim to one that faces it.
#[derive(Clone, Debug)]
struct Way {
    vertices: [u32; 2],
    /// Triangles of the way in [`Ligaments::crossed`].
    crossed: std::ops::Range<u32>,
}

/// The way into the body at a vertex of the rim.
#[derive(Clone, Copy, Debug)]
struct Inwards {
    direction: DVec3,
    /// Cosine of the most that a way may lean from it.
    least: f64,
}

impl Ligaments {
    /// Finds the ligaments narrower than `radius` \[mm\], unless they are known.
    pub fn find(&mut self, surface: &Surface, radius: f64) {
        let wanted = Some((surface.topology.log.now(), radius));
        if self.found_for == wanted {
            return;
        }
        self.found_for = wanted;
        self.ways.clear();
        self.crossed.clear();
        let rest = &surface.vertices.rest_position;
        // Room from the start, so that lists do not grow while a tear goes on.
        self.ways.reserve(ROOM_FOR_WAYS);
        self.crossed.reserve(4 * ROOM_FOR_WAYS);
        self.facing.reserve(ROOM_FOR_WAYS);
        let mut rim = std::mem::take(&mut self.rim);
        rim.clear();
        let of_rim = (0..rest.len() as u32).filter(|&v| surface.topology.is_boundary_vertex(v));
        rim.extend(of_rim.map(|v| (v, inwards(surface, v))));
        rim.sort_unstable_by(|(a, _), (b, _)| rest[*a as usize].x.total_cmp(&rest[*b as usize].x).then(a.cmp(b)));
        for place in 0..rim.len() {
            self.find_from(surface, &rim, place, radius);
        }
        self.rim = rim;
    }

    /// Finds the shortest ways from a vertex of the rim. A way is found from both of its ends.
    fn find_from(&mut self, surface: &Surface, rim: &[(u32, Option<Inwards>)], place: usize, radius: f64) {
        let rest = &surface.vertices.rest_position;
        let (from, Some(inwards)) = rim[place] else { return };
        let at = rest[from as usize];
        let mut facing = std::mem::take(&mut self.facing);
        facing.clear();
        let near = |(to, _): &&(u32, Option<Inwards>)| (rest[*to as usize].x - at.x).abs() < radius;
        let after = rim[place + 1..].iter().take_while(near);
        for &(to, other) in rim[..place].iter().rev().take_while(near).chain(after) {
            let (way, Some(other)) = (rest[to as usize] - at, other) else { continue };
            let length = way.length();
            let leads = |inwards: &Inwards, way: DVec3| way.dot(inwards.direction) >= inwards.least * length;
            if length > 0.0 && length < radius && leads(&inwards, way) && leads(&other, -way) {
                facing.push((length, to));
            }
        }
        facing.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut count = 0;
        for &(_, to) in facing.iter().take(MOST_TRIED) {
            let first = self.crossed.len();
            if cross(surface, from, to, &mut self.crossed) {
                self.ways.push(Way { vertices: [from, to], crossed: first as u32..self.crossed.len() as u32 });
                count += 1;
            } else {
                self.crossed.truncate(first);
            }
            if count == WAYS {
                break;
            }
        }
        self.facing = facing;
    }

    /// The ligament with the largest criterion above 1, of those whose middle \[mm, rest shape\] may part: every triangle on
    /// the way across it exceeds it. The tension at a rim follows the rim, so that its own direction says little about the way
    /// across.
    pub(crate) fn weakest(
        &self,
        surface: &Surface,
        strength: &Strength,
        may_part: &dyn Fn(DVec3) -> bool,
    ) -> Option<LigamentFailure> {
        let rest = &surface.vertices.rest_position;
        let mut best: Option<LigamentFailure> = None;
        for way in &self.ways {
            let crossed = &self.crossed[way.crossed.start as usize..way.crossed.end as usize];
            let least = best.map_or(1.0, |best| best.value);
            let value = weakest_of(surface, crossed, strength, least);
            let ends = way.vertices.map(|v| rest[v as usize]);
            if !(value > least) || !may_part((ends[0] + ends[1]) * 0.5) {
                continue;
            }
            let [(first, _), ..] = crossed else { continue };
            best = Some(LigamentFailure {
                site: TearSite::Vertex(way.vertices[0]),
                fibre: surface.triangles.fibre[*first as usize],
                direction: (ends[1] - ends[0]).normalize_or_zero(),
                value,
                ends,
                by: PartedBy::Ligament,
            });
        }
        best
    }
}

/// The smallest criterion on a way; any value up to `least` where it is no larger.
fn weakest_of(surface: &Surface, crossed: &[(u32, DVec2)], strength: &Strength, least: f64) -> f64 {
    let mut value = f64::INFINITY;
    for &(t, direction) in crossed {
        let t = t as usize;
        let strength = strength.times(surface.triangles.strength[t]);
        value = value.min(failure::direction_value(surface.stress(t), DVec2::X, &strength, direction));
        if !(value > least) {
            break;
        }
    }
    value
}

/// The way into the body halfway between the rim's two edges at a vertex; `None` where several rims touch or the fan is degenerate.
fn inwards(surface: &Surface, vertex: u32) -> Option<Inwards> {
    let fan = surface.topology.fan(vertex);
    if fan.is_closed || fan.sectors.is_empty() {
        return None;
    }
    let at = surface.vertices.rest_position[vertex as usize];
    let angles = fan.sectors.iter().map(|&(t, corner)| {
        let x = corners(surface, t as usize);
        let (a, b) = (x[(corner + 1) % 3] - at, x[(corner + 2) % 3] - at);
        (a, b, elementary::atan2(a.cross(b).length(), a.dot(b)))
    });
    let all: SmallVec<[(DVec3, DVec3, f64); 24]> = angles.collect();
    let half = 0.5 * all.iter().map(|sector| sector.2).sum::<f64>();
    let mut left = half;
    for (a, b, angle) in all {
        if left <= angle {
            let (a, across) = (a.try_normalize()?, (b - a * (a.dot(b) / a.length_squared())).try_normalize()?);
            let (sin, cos) = elementary::sin_cos(left);
            let direction = a * cos + across * sin;
            return Some(Inwards { direction, least: elementary::cos(half * LEAN) });
        }
        left -= angle;
    }
    None
}

/// Walks straight from a vertex of the rim to another over the rest surface. Whether it is met, through three triangles or more; lists
/// those.
fn cross(surface: &Surface, from: u32, to: u32, crossed: &mut Vec<(u32, DVec2)>) -> bool {
    let rest = &surface.vertices.rest_position;
    let (mut at, end) = (rest[from as usize], rest[to as usize]);
    let direction = end - at;
    let first = crossed.len();
    let sectors = surface.topology.fan(from).sectors;
    let Some((mut t, corner)) = sectors.into_iter().find(|&(t, corner)| is_ahead(surface, t, corner, direction)) else {
        return false;
    };
    // The edges that may be left by: not the one that was entered by.
    let mut exits: SmallVec<[usize; 3]> = smallvec![(corner + 1) % 3];
    for _ in 0..MOST_CROSSED_BY_LIGAMENT {
        let x = corners(surface, t as usize);
        let Some(normal) = (x[1] - x[0]).cross(x[2] - x[0]).try_normalize() else { return false };
        let Some(d) = (direction - normal * normal.dot(direction)).try_normalize() else { return false };
        let fibre = surface.triangles.fibre[t as usize];
        crossed.push((t, DVec2::new(d.dot(fibre), d.dot(normal.cross(fibre)))));
        if surface.triangles.corners[t as usize].contains(&to) {
            return crossed.len() - first >= FEWEST_CROSSED;
        }
        // The nearest edge ahead: where the distance from its line falls to zero.
        let mut exit: Option<(f64, usize)> = None;
        for &edge in &exits {
            let out = (x[(edge + 1) % 3] - x[edge]).cross(normal);
            let (speed, gap) = (out.dot(d), out.dot(x[edge] - at));
            if speed > 0.0 && exit.is_none_or(|(least, _)| gap / speed < least) {
                exit = Some((gap / speed, edge));
            }
        }
        let Some((length, edge)) = exit else { return false };
        at += d * length.max(0.0);
        let next = surface.topology.neighbours[t as usize][edge];
        if next == NONE {
            return false;
        }
        exits = (0..3).filter(|&e| surface.topology.neighbours[next as usize][e] != t).collect();
        t = next;
    }
    false
}

/// Whether a direction from a corner of a triangle leads over the edge across.
fn is_ahead(surface: &Surface, t: u32, corner: usize, direction: DVec3) -> bool {
    let x = corners(surface, t as usize);
    let (a, b) = (x[(corner + 1) % 3] - x[corner], x[(corner + 2) % 3] - x[corner]);
    let normal = a.cross(b);
    a.cross(direction).dot(normal) >= 0.0 && direction.cross(b).dot(normal) >= 0.0
}

fn corners(surface: &Surface, t: usize) -> [DVec3; 3] {
    surface.triangles.corners[t].map(|v| surface.vertices.rest_position[v as usize])
}

//! Contact of a body with itself: springs between layers that come nearer than a radius, and a proof for every pair that none has passed through
//! another.
//!
//! A pair is a vertex and a triangle, or two edges. Within the radius r it has the force k·(r − d)·(r/d)² along the shortest way between
//! its parts, with that derivative as stiffness in the operator: of rank one, so that layers that move together do not resist. It counts only where no
//! other pair has the same part of the surface's offset: the nearest point lies within the triangle or both edges, or on a rim. After the solve every
//! pair is proved apart, or held back.

mod bodies;
mod candidates;
mod closest;
mod edits;
mod groups;
mod proof;
mod search;
mod separate;

pub use bodies::{hold_bodies_apart, penetrating, push_bodies_apart};
pub(in crate::systems) use edits::may_collapse;
pub use groups::{find_groups, lists, select_together};
pub(in crate::systems) use groups::{give_back, take_groups};
pub(super) use separate::asks;
pub use separate::keep_apart;

use crate::components::{
    Bending, Contact, ExternalStiffness, Forces, Frames, FreeAxes, Grips, Increment, Layers, Pair, PairSpring, Planar,
    SolveResult, SolverScratch,
};
use crate::math::{Sym2, Sym3, nearest_in_triangle};
use crate::storage::{NONE, Topology, Triangles, Vertices};
use crate::systems::{StepContext, parallel, work};
use closest::Nearest;
use glam::DVec3;
use hecs::World;
use separate::Motion;

/// Maximum stiffness of a pair, over that of the body there, which it has at the radius.
const MOST_STIFFNESS: f64 = 30.0;

/// Stiffness of a plane over that of the body there.
const PLANE_STIFFNESS: f64 = 10.0;

/// Least stiffness over that of the membrane: of slack tissue in a static solve.
const LEAST_STIFFNESS: f64 = 1e-6;

/// Least distance in the law, over the radius.
const LEAST_DISTANCE: f64 = 0.02;

/// Maximum radius of parts that an edge joins, over their distance at rest, which in a narrow triangle is less than the radius.
const PART_OF_REST: f64 = 0.5;

/// Target distance of the further solve between parts that the solve before has carried through each other, over the radius.
const GOAL: f64 = 0.7;

/// Box tests that take as long as the proof of a pair, and as the spring of one.
const TESTS_PER_PROOF: usize = 4;
const TESTS_PER_SPRING: usize = 20;

/// A weight below which a nearest point lies on the edge, or at the end, of a part.
const ON_EDGE: f64 = 1e-9;

/// Tables of a body.
type Mesh<'a> = (&'a Vertices, &'a Triangles, &'a Topology);

/// Pushes layers apart that are nearer than the radius, or that a solve of the step has carried through each other.
pub fn push_apart(world: &mut World, step: &StepContext) -> usize {
    type Query<'a> = (
        (Mesh<'a>, &'a Increment, &'a mut SolveResult, &'a Contact, Option<&'a Grips>),
        (&'a Frames, Option<&'a Bending>),
        (&'a mut Forces, &'a mut ExternalStiffness, &'a mut SolverScratch),
    );
    parallel::for_bodies::<hecs::Without<Query, &Planar>>(
        world,
        |((mesh, _, result, contact, _), ..)| contact.self_contact.map_or(0, |_| result.rows_to_solve(mesh.0.len())),
        |((mesh, increment, result, contact, grips), (frames, bending), (forces, external, scratch))| {
            let Some(own) = &contact.self_contact else { return };
            let SolverScratch { free, contact: memory, .. } = scratch;
            let layers = &mut **memory.layers.get_or_insert_default();
            let (x, start) = (&mesh.0.position[..], &increment.start[..]);
            let held = HeldTogether::new(x.len(), free, grips);
            Motion::of_body(mesh, start, own, &held).sweep(x, false).find(layers);
            layers.touching = 0;
            if result.newton_iterations == 0 {
                layers.through.clear();
            }
            let inertia = if step.is_static { 0.0 } else { step.inertia() };
            let backing = Backing { mesh, frames: Some(frames), bending, inertia };
            let resistance = |v: u32, normal: DVec3| backing.at(v, normal);
            let count = planes_at(&layers.through, x.len());
            let shared = |v: u32, normal: DVec3| resistance(v, normal) / count[v as usize];
            let of_through = layers.through.iter().map(|pair| plane(pair, [start, x], own.radius, &shared));
            let is_touching = |pair: &&Pair| !held.all(pair) && layers.through.binary_search(pair).is_err();
            let share = |pair: &Pair, weights: &[f64; 4], distance: f64| {
                let place = (pair.rows[0], x[pair.rows[0] as usize]);
                share(pair, weights, (place, distance), mesh)
            };
            let radius = |pair: &Pair| match are_neighbours(pair, mesh) {
                true => own.radius.min(PART_OF_REST * pair.nearest(&mesh.0.rest_position).way.length()),
                false => own.radius,
            };
            let touching = layers.pairs.iter().filter(is_touching);
            let of_others = touching.map(|pair| spring(pair, x, (own.radius, &radius), (&share, &resistance)));
            for (spring, force) in of_through.chain(of_others).flatten() {
                layers.touching += 1;
                for (row, weight) in spring.rows.into_iter().zip(spring.weights) {
                    forces.nodal[row as usize] += spring.normal * (force * weight);
                }
                external.add_pair(spring, x.len());
            }
            layers.tests += TESTS_PER_SPRING * layers.touching as usize;
            layers.count_work(result, mesh.1.len());
        },
    )
}

impl Layers {
    /// Adds the tests since the last count to the work of the body's step.
    fn count_work(&mut self, result: &mut SolveResult, triangles: usize) {
        let tests = std::mem::take(&mut self.tests);
        result.work = result.work.saturating_add(work::of_layers(tests, triangles));
    }
}

/// Vertices that cannot move against each other; those that jaws draw by springs can.
struct HeldTogether {
    /// Number of the holder of each vertex; zero for none.
    by: Vec<u32>,
}

impl HeldTogether {
    fn new(count: usize, free: &FreeAxes, grips: Option<&Grips>) -> Self {
        let mut by: Vec<u32> = free.iter().map(|free| u32::from(*free == DVec3::ZERO)).collect();
        by.resize(count, 0);
        for (name, pinch) in (2..).zip(grips.iter().flat_map(|grips| &grips.pinches)) {
            let rows = pinch.held.rows().iter().map(|&row| row as usize);
            rows.for_each(|row| by[row] = if by[row] > 0 { name } else { 0 });
        }
        Self { by }
    }

    /// Whether one holds all of a pair.
    fn all(&self, pair: &Pair) -> bool {
        let [first, others @ ..] = pair.rows.map(|row| self.by[row as usize]);
        first > 0 && others.iter().all(|other| *other == first)
    }
}

/// The body's stiffness at its vertices.
struct Backing<'a> {
    mesh: Mesh<'a>,
    /// State of the triangles, where it is one of this step.
    frames: Option<&'a Frames>,
    bending: Option<&'a Bending>,
    /// 1/s² \[1/ms²\] of the step.
    inertia: f64,
}

impl Backing<'_> {
    /// Stiffness \[N/mm\] of a vertex along a normal: membrane stiffness in its plane, tension and bending across it, and mass over s².
    fn at(&self, v: u32, normal: DVec3) -> f64 {
        let (vertices, triangles, topology) = self.mesh;
        let of_triangle = |entry: &u32| {
            let t = *entry as usize / 3;
            let [a, b, c] = triangles.corners[t].map(|v| vertices.position[v as usize]);
            let cosine = normal.dot((b - a).cross(c - a).normalize_or_zero());
            let across = cosine * cosine;
            let (law, thickness) = (&triangles.stiffness[t], triangles.thickness[t]);
            let stress = self.frames.map_or(Sym2::default(), |frames| frames.state(t).stress);
            let stiffest = law.q11.max(law.q22);
            let bent =
                self.bending.map_or(0.0, |bending| bending.scale(law, thickness) * stiffest / triangles.rest[t].area);
            let in_plane = stiffest * (1.0 - across).max(LEAST_STIFFNESS) + (stress.xx + stress.yy).max(0.0) * across;
            0.5 * thickness * in_plane + bent * across
        };
        topology.incident[v as usize].iter().map(of_triangle).sum::<f64>() + vertices.mass[v as usize] * self.inertia
    }
}

/// Stiffness \[N/mm\] against a spring between both parts of a pair, by that of every vertex along the normal.
fn against(pair: &Pair, weights: [f64; 4], normal: DVec3, resistance: &impl Fn(u32, DVec3) -> f64) -> f64 {
    let softness =
        |(row, weight): (u32, f64)| if weight == 0.0 { 0.0 } else { weight * weight / resistance(row, normal) };
    1.0 / pair.rows.into_iter().zip(weights).map(softness).sum::<f64>()
}

/// The spring of a pair within its own radius, which is `most` or less, and its force \[N\].
fn spring(
    pair: &Pair,
    x: &[DVec3],
    (most, radius): (f64, &impl Fn(&Pair) -> f64),
    (share, resistance): (&impl Fn(&Pair, &[f64; 4], f64) -> f64, &impl Fn(u32, DVec3) -> f64),
) -> Option<(PairSpring, f64)> {
    let Nearest { weights, way } = pair.nearest(x);
    let distance = way.length();
    if !(distance < most && distance > 0.0) {
        return None;
    }
    let radius = radius(pair);
    if distance >= radius {
        return None;
    }
    let share = share(pair, &weights, distance);
    if share == 0.0 {
        return None;
    }
    let normal = way / distance;
    let of_body = against(pair, weights, normal, resistance);
    let (stiffness, ratio) = (share * of_body, (distance / radius).max(LEAST_DISTANCE));
    let force = stiffness * (radius - distance) / (ratio * ratio);
    let slope = stiffness * (1.0 + 2.0 * (1.0 - ratio) / ratio) / (ratio * ratio);
    Some((PairSpring { rows: pair.rows, weights, normal, stiffness: slope.min(MOST_STIFFNESS * of_body) }, force))
}

/// Whether an edge of the mesh joins the parts of a pair.
fn are_neighbours(pair: &Pair, (_, triangles, topology): Mesh<'_>) -> bool {
    let (first, second) = pair.rows.split_at(pair.first());
    let around = |v: &u32| topology.incident[*v as usize].iter().map(|entry| triangles.corners[*entry as usize / 3]);
    first.iter().flat_map(around).any(|corners| corners.iter().any(|v| second.contains(v)))
}

/// Number of planes at every vertex, which bear a part each: the more there are the softer is each, or the solve would not see layers move together.
fn planes_at(through: &[Pair], count: usize) -> Vec<f64> {
    let mut planes = vec![0.0; count];
    through.iter().flat_map(|pair| pair.rows).for_each(|row| planes[row as usize] += 1.0);
    planes
}

/// The spring of a pair that a solve of the step has carried through each other: against the plane between its nearest points at the start.
fn plane(
    pair: &Pair,
    [start, x]: [&[DVec3]; 2],
    radius: f64,
    resistance: &impl Fn(u32, DVec3) -> f64,
) -> Option<(PairSpring, f64)> {
    let (Nearest { weights, way }, rows) = (pair.nearest(start), pair.rows);
    let distance = way.length();
    let normal = way / distance;
    let now: f64 = (0..4).map(|i| normal.dot(x[rows[i] as usize]) * weights[i]).sum();
    let missing = GOAL * radius.min(distance) - now;
    if !(missing > 0.0) {
        return None;
    }
    let stiffness = PLANE_STIFFNESS * against(pair, weights, normal, resistance);
    Some((PairSpring { rows, weights, normal, stiffness }, stiffness * missing))
}

/// The part of a pair that counts: no other has the same part of the offset of faces, edges and corners. `place` is the vertex of the first part, as a row of
/// the mesh that has the second, and its position.
fn share(
    pair: &Pair,
    weights: &[f64; 4],
    ((v, place), distance): ((u32, DVec3), f64),
    (vertices, triangles, topology): Mesh<'_>,
) -> f64 {
    if pair.are_edges {
        return if weights.iter().all(|weight| weight.abs() > ON_EDGE) { 1.0 } else { 0.0 };
    }
    let x = &vertices.position;
    let on_edge = [1, 2, 3].map(|i| -weights[i] <= ON_EDGE);
    let has_vertex = |t: u32| triangles.corners[t as usize].contains(&v);
    let is_nearer = |t: u32| {
        let corners = triangles.corners[t as usize].map(|v| x[v as usize]);
        let [a, b, c] = nearest_in_triangle(corners, place);
        let foot = corners[0] * a + corners[1] * b + corners[2] * c;
        place.distance(foot) < distance * (1.0 - 1e-7)
    };
    match on_edge {
        [false, false, false] => 1.0,
        // At a corner.
        [_, _, _] if on_edge.iter().filter(|on_edge| **on_edge).count() == 2 => {
            let corner = (0..3).find(|&i| !on_edge[i]).unwrap_or(0);
            let around = &topology.incident[pair.rows[1 + corner] as usize];
            let hides = |entry: &u32| has_vertex(entry / 3) || is_nearer(entry / 3);
            if around.iter().any(hides) { 0.0 } else { 1.0 / around.len() as f64 }
        }
        // On the edge opposite to the corner without weight.
        _ => {
            let opposite = (0..3).find(|&i| on_edge[i]).unwrap_or(0);
            match topology.neighbours[pair.triangle as usize][(opposite + 1) % 3] {
                NONE => 1.0,
                across if has_vertex(across) || is_nearer(across) => 0.0,
                _ => 0.5,
            }
        }
    }
}

impl ExternalStiffness {
    /// Adds a spring between two parts of a body of `count` vertices.
    fn add_pair(&mut self, spring: PairSpring, count: usize) {
        self.coupled.pair_block.resize(count, Sym3::ZERO);
        for (place, &row) in spring.rows.iter().enumerate() {
            self.coupled.pair_block[row as usize] += spring.block(place);
        }
        self.coupled.pairs.push(spring);
    }
}

//! Contact between bodies: those of a group are one surface, body after body, whose layers are paired, pushed and held apart like those of one.

use super::groups::{any_touches, find_on_the_way, give_back, take_groups};
use super::search::Owners;
use super::separate::{Motion, Radii, adopt};
use super::{Backing, HeldTogether, TESTS_PER_SPRING, plane, planes_at, share, spring};
use crate::components::{
    Bending, BodyGroup, Contact, Frames, FreeAxes, Grips, Increment, Layers, Pair, SolveResult, SolverScratch,
};
use crate::storage::{Topology, Triangles, Vertices};
use crate::systems::{StepContext, work};
use glam::DVec3;
use hecs::{Entity, World};

/// Least band in the scale of rest positions \[mm\].
const LEAST_BAND: f64 = 1e-6;

/// A body of a group.
type Member<'a> = (
    (&'a mut Vertices, &'a Triangles, &'a Topology, &'a mut Increment),
    (&'a mut SolverScratch, Option<&'a mut SolveResult>, &'a Contact, Option<&'a Grips>),
    (&'a Frames, Option<&'a Bending>),
);

/// Participation of a body in the step.
fn is_in_step(result: Option<&SolveResult>) -> bool {
    result.is_some_and(|result| result.is_in_step)
}

/// Runs on every group that has one of its bodies at work, with its bodies in order; returns the number of these.
fn for_groups(
    world: &mut World,
    is_asked: impl Fn(&SolveResult) -> bool,
    mut run: impl FnMut(&mut BodyGroup, &mut [Member<'_>]),
) -> usize {
    let mut count = 0;
    for (first, mut group) in take_groups(world) {
        let mut members: Vec<(Entity, Member)> =
            world.query_mut::<(Entity, Member)>().into_iter().filter(|(body, _)| group.bodies.contains(body)).collect();
        members.sort_by_key(|(body, _)| group.bodies.iter().position(|other| other == body));
        let mut members: Vec<Member> = members.into_iter().map(|(_, member)| member).collect();
        let is_at_work = members.iter().any(|(_, (_, result, ..), _)| result.as_deref().is_some_and(&is_asked));
        if is_at_work && members.len() == group.bodies.len() {
            count += members.len();
            run(&mut group, &mut members);
        }
        give_back(world, first, group);
    }
    count
}

/// Tables of a group, body after body.
struct Joined {
    /// Numbers of the first vertex and the first triangle of every body.
    first: Vec<u32>,
    first_triangle: Vec<u32>,
    /// Body of every vertex.
    of_vertex: Vec<u32>,
    x: Vec<DVec3>,
    start: Vec<DVec3>,
    rest: Vec<DVec3>,
    corners: Vec<[u32; 3]>,
    owners: Vec<u8>,
    mass: Vec<f64>,
    free: FreeAxes,
    radii: Vec<f64>,
    held: HeldTogether,
}

impl Joined {
    fn new(members: &[Member<'_>]) -> Self {
        let (mut first, mut first_triangle, mut of_vertex) = (Vec::new(), Vec::new(), Vec::new());
        let (mut x, mut start, mut rest) = (Vec::new(), Vec::new(), Vec::new());
        let (mut corners, mut owners, mut mass, mut free) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let (mut radii, mut by) = (Vec::new(), Vec::new());
        let mut end = 0.0;
        for (k, ((vertices, triangles, topology, increment), (scratch, result, contact, grips), _)) in
            (0..).zip(members)
        {
            let (n, before) = (vertices.len(), x.len() as u32);
            let (radius, band) = contact.self_contact.map_or((0.0, None), |own| (own.radius, own.band));
            first.push(before);
            first_triangle.push(corners.len() as u32);
            of_vertex.resize(of_vertex.len() + n, k);
            x.extend_from_slice(&vertices.position);
            mass.extend_from_slice(&vertices.mass);
            radii.push(radius);
            // A body that is done, or sleeps, stands where it is.
            let moves = is_in_step(result.as_deref()) && increment.start.len() == n && scratch.free.len() == n;
            start.extend_from_slice(if moves { &increment.start } else { &vertices.position });
            free.extend((0..n).map(|v| if moves { scratch.free[v] } else { DVec3::ZERO }));
            // Bands are one in this scale, and bodies further apart.
            let scale = 1.0 / band.unwrap_or(0.0).max(LEAST_BAND);
            let low = vertices.rest_position.iter().copied().reduce(DVec3::min).unwrap_or_default();
            let high = vertices.rest_position.iter().copied().reduce(DVec3::max).unwrap_or_default();
            let shift = DVec3::X * (end - low.x * scale);
            end += (high.x - low.x) * scale + 2.0;
            rest.extend(vertices.rest_position.iter().map(|rest| *rest * scale + shift));
            for (t, of_triangle) in (0..).zip(&triangles.corners) {
                corners.push(of_triangle.map(|v| v + before));
                owners.push(Owners::bits(topology, t, of_triangle));
            }
            let held = HeldTogether::new(n, &scratch.free, grips.as_deref()).by;
            let holder = |holder: u32| if moves && holder > 1 { holder + (k << 16) } else { holder };
            by.extend(held.into_iter().map(|own| if moves { holder(own) } else { 1 }));
        }
        Self {
            first,
            first_triangle,
            of_vertex,
            x,
            start,
            rest,
            corners,
            owners,
            mass,
            free: free.into_iter().collect(),
            radii,
            held: HeldTogether { by },
        }
    }

    fn motion(&self) -> Motion<'_> {
        Motion {
            start: &self.start,
            rest: &self.rest,
            corners: &self.corners,
            owners: Owners::Listed(&self.owners),
            radii: Radii::OfBodies(&self.radii, &self.of_vertex),
            band: 1.0,
            held: &self.held,
        }
    }

    /// Counts box tests as work of the bodies in the step.
    fn count_work(&self, layers: &mut Layers, members: &mut [Member<'_>]) {
        let tests = std::mem::take(&mut layers.tests);
        let more = work::of_layers(tests, self.corners.len());
        for (_, (_, result, ..), _) in members {
            if let Some(result) = result.as_deref_mut().filter(|result| result.is_in_step) {
                result.work = result.work.saturating_add(more);
            }
        }
    }
}

/// Finds the springs between bodies that are nearer than their radii, or that a solve of the step has carried through each other.
pub fn push_bodies_apart(world: &mut World, step: &StepContext) -> usize {
    for_groups(world, SolveResult::is_active, |group, members| {
        let joined = Joined::new(members);
        let BodyGroup { layers, springs, first, .. } = group;
        first.clone_from(&joined.first);
        let motion = joined.motion();
        motion.sweep(&joined.x, true).find(layers);
        let is_first = |(_, (_, result, ..), _): &Member| {
            result.as_deref().is_some_and(|result| result.is_active() && result.newton_iterations == 0)
        };
        if members.iter().any(is_first) {
            layers.through.clear();
        }
        let inertia = if step.is_static { 0.0 } else { step.inertia() };
        let backings: Vec<Backing> = members
            .iter()
            .map(|((vertices, triangles, topology, _), (_, result, ..), (frames, bending))| Backing {
                mesh: (vertices, triangles, topology),
                // A body that stands has states of an earlier step, or none.
                frames: Some(*frames).filter(|frames| is_in_step(result.as_deref()) && frames.len() == triangles.len()),
                bending: *bending,
                inertia,
            })
            .collect();
        let body = |v: u32| joined.of_vertex[v as usize] as usize;
        let resistance = |v: u32, normal: DVec3| backings[body(v)].at(v - joined.first[body(v)], normal);
        let share = |pair: &Pair, weights: &[f64; 4], distance: f64| {
            let of = body(pair.rows[3]);
            let own = |v: u32| v.wrapping_sub(joined.first[of]);
            // This body does not have the vertex of another.
            let rows = [u32::MAX, own(pair.rows[1]), own(pair.rows[2]), own(pair.rows[3])];
            let local = Pair { rows, triangle: pair.triangle - joined.first_triangle[of], ..*pair };
            share(&local, weights, ((u32::MAX, joined.x[pair.rows[0] as usize]), distance), backings[of].mesh)
        };
        springs.clear();
        let planes = planes_at(&layers.through, joined.x.len());
        let shared = |v: u32, normal: DVec3| resistance(v, normal) / planes[v as usize];
        let of_through = layers.through.iter();
        springs.extend(
            of_through.filter_map(|pair| plane(pair, [&joined.start, &joined.x], motion.radii.of(pair), &shared)),
        );
        let is_touching = |pair: &&Pair| !joined.held.all(pair) && layers.through.binary_search(pair).is_err();
        let others = layers.pairs.iter().filter(is_touching);
        let radius = |pair: &Pair| motion.radii.of(pair);
        let most = motion.radii.largest();
        springs.extend(others.filter_map(|pair| spring(pair, &joined.x, (most, &radius), (&share, &resistance))));
        layers.touching = springs.len() as u32;
        layers.tests += TESTS_PER_SPRING * springs.len();
        joined.count_work(layers, members);
        let mut touching = vec![0; members.len()];
        for (spring, _) in &*springs {
            let [first, .., last] = spring.rows.map(body);
            touching[first] += 1;
            touching[last] += 1;
        }
        for ((_, (scratch, ..), _), touching) in members.iter_mut().zip(touching) {
            let own = &mut **scratch.contact.layers.get_or_insert_default();
            (own.touching_others, own.overlapping_others) = (touching, layers.crossed.len() as u32);
        }
    })
}

/// Marks for another solve the groups of which the last one has carried bodies through each other. Returns the number of bodies.
pub fn penetrating(world: &mut World, step: &StepContext) -> usize {
    if !any_touches(world) {
        return 0;
    }
    find_on_the_way(world);
    let mut count = 0;
    for_groups(
        world,
        |result| result.newton_iterations > 0 && result.is_in_step,
        |group, members| {
            let joined = Joined::new(members);
            let asks = joined.motion().asks(&joined.x, true, &mut group.layers);
            joined.count_work(&mut group.layers, members);
            for (_, (_, result, ..), _) in members {
                let affords = |result: &&mut SolveResult| result.is_in_step && step.affords(result, 1);
                if let Some(result) = result.as_deref_mut().filter(|result| asks && affords(result)) {
                    result.select(true);
                    count += 1;
                }
            }
        },
    );
    count
}

/// Holds bodies back that have passed through each other, or layers of one of them.
pub fn hold_bodies_apart(world: &mut World, step: &StepContext) -> usize {
    if !any_touches(world) {
        return 0;
    }
    find_on_the_way(world);
    for_groups(
        world,
        |result| result.is_in_step,
        |group, members| {
            let mut joined = Joined::new(members);
            let mut x = std::mem::take(&mut joined.x);
            let count = joined.corners.len();
            let results = members.iter().filter_map(|(_, (_, result, ..), _)| result.as_deref());
            let tests =
                results.filter(|result| result.is_in_step).map(|result| work::tests_within(step.left(result), count));
            let most = tests.min().unwrap_or(0);
            let layers = &mut group.layers;
            layers.moved_as_one = false;
            joined.motion().hold_back((&mut x, &joined.mass, &joined.free), layers, most);
            let moved_as_one = layers.moved_as_one;
            joined.count_work(layers, members);
            for (k, ((vertices, _, _, increment), (scratch, result, ..), _)) in members.iter_mut().enumerate() {
                if !is_in_step(result.as_deref()) {
                    continue;
                }
                let first = joined.first[k] as usize;
                let held_back = adopt(&x[first..][..vertices.len()], (vertices, increment), step);
                let own = &mut **scratch.contact.layers.get_or_insert_default();
                own.held_back = own.held_back.max(held_back);
                own.moved_as_one |= moved_as_one;
            }
        },
    )
}

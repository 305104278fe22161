//! Groups of bodies near each other: found at the start of a step by boxes around the ways that the bodies have ahead of them, and again by the ways
//! that they went. A group is solved together (`systems/solver/group`), set back together where one of its bodies fails, and does not fall asleep.

use crate::components::{
    Body, BodyGroup, Bounds, Contact, Increment, Planar, Sleeping, SolveResult, SolverScratch, TearLog,
};
use crate::event::{EventKind, WokenBy};
use crate::storage::Vertices;
use crate::systems::StepContext;
use glam::DVec3;
use hecs::{Entity, World};

/// Takes the groups off their first bodies, to which [`give_back`] returns them; none where no body touches others.
pub(in crate::systems) fn take_groups(world: &mut World) -> Vec<(Entity, Box<BodyGroup>)> {
    if !any_touches(world) {
        return Vec::new();
    }
    let bodies = world.query_mut::<(Entity, &Body, &mut SolverScratch)>().into_iter();
    let mut groups: Vec<(u32, Entity, Box<BodyGroup>)> = bodies
        .filter_map(|(entity, body, scratch)| Some((body.order, entity, scratch.contact.group.take()?)))
        .collect();
    groups.sort_by_key(|(order, ..)| *order);
    groups.into_iter().map(|(_, entity, group)| (entity, group)).collect()
}

pub(in crate::systems) fn give_back(world: &mut World, first: Entity, group: Box<BodyGroup>) {
    if let Ok(scratch) = world.query_one_mut::<&mut SolverScratch>(first) {
        scratch.contact.group = Some(group);
    }
}

/// The bodies of every group.
pub fn lists(world: &mut World) -> Vec<Vec<Entity>> {
    if !any_touches(world) {
        return Vec::new();
    }
    let scratches = world.query_mut::<&SolverScratch>().into_iter();
    scratches.filter_map(|scratch| Some(scratch.contact.group.as_ref()?.bodies.clone())).collect()
}

/// Presence of a body that touches others.
pub(super) fn any_touches(world: &mut World) -> bool {
    world.query_mut::<&Contact>().into_iter().any(|contact| contact.between_bodies)
}

/// Finds the bodies that may touch each other on the way that their velocities give them, and wakes those that sleep among them.
pub fn find_groups(world: &mut World, step: &StepContext) -> usize {
    let before = take_groups(world);
    for scratch in world.query_mut::<&mut SolverScratch>() {
        (scratch.contact.has_neighbours, scratch.contact.group) = (false, None);
        if let Some(layers) = &mut scratch.contact.layers {
            (layers.touching_others, layers.overlapping_others) = (0, 0);
        }
    }
    if !any_touches(world) {
        return 0;
    }
    let ahead = |vertices: &Vertices, _: &Increment, v: usize| {
        let way = vertices.velocity[v] * step.dt;
        [vertices.position[v] - way, vertices.position[v] + way]
    };
    let count = group(world, ahead, (before, false));
    for group in lists(world) {
        let is_awake = |body: &Entity| {
            let mut sleeping = world.query_one::<(&SolveResult, Option<&Sleeping>)>(*body);
            sleeping.get().is_ok_and(|(_, sleeping)| !sleeping.is_some_and(Sleeping::is_asleep))
        };
        if !group.iter().any(is_awake) {
            continue;
        }
        for body in group {
            if let Ok((sleeping, log)) = world.query_one_mut::<(&mut Sleeping, &mut TearLog)>(body)
                && sleeping.is_asleep()
            {
                sleeping.wake();
                log.pending.push(EventKind::Woke { by: WokenBy::Obstacle });
            }
        }
    }
    count
}

/// Groups bodies whose boxes meet, directly or by others, and those that were together before if asked for. Returns their number.
fn group(
    world: &mut World,
    ends: impl Fn(&Vertices, &Increment, usize) -> [DVec3; 2],
    (mut before, stay_together): (Vec<(Entity, Box<BodyGroup>)>, bool),
) -> usize {
    let mut bodies: Vec<(u32, Entity, Bounds)> = Vec::new();
    type Query<'a> = (Entity, &'a Body, &'a Vertices, &'a Increment, &'a Contact);
    for (entity, body, vertices, increment, contact) in world.query_mut::<hecs::Without<Query, &Planar>>() {
        let Some(own) = contact.self_contact.filter(|_| contact.between_bodies) else { continue };
        let corners = (0..vertices.len()).flat_map(|v| ends(vertices, increment, v));
        let empty = Bounds { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };
        let around = corners.fold(empty, |Bounds { low, high }, x| Bounds { low: low.min(x), high: high.max(x) });
        let more = DVec3::splat(own.radius);
        bodies.push((body.order, entity, Bounds { low: around.low - more, high: around.high + more }));
    }
    bodies.sort_by_key(|(order, ..)| *order);
    let mut root: Vec<usize> = (0..bodies.len()).collect();
    let join = |root: &mut Vec<usize>, i: usize, j: usize| {
        let (low, high) = (root[i].min(root[j]), root[i].max(root[j]));
        root.iter_mut().filter(|root| **root == high).for_each(|root| *root = low);
    };
    let mut by_left: Vec<usize> = (0..bodies.len()).collect();
    by_left.sort_by(|&i, &j| bodies[i].2.low.x.total_cmp(&bodies[j].2.low.x));
    for (place, &i) in by_left.iter().enumerate() {
        for &j in by_left[place + 1..].iter().take_while(|&&j| bodies[j].2.low.x <= bodies[i].2.high.x) {
            if bodies[i].2.meets(&bodies[j].2) {
                join(&mut root, i, j);
            }
        }
    }
    for (_, group) in before.iter().filter(|_| stay_together) {
        let places = (0..bodies.len()).filter(|&i| group.bodies.contains(&bodies[i].1)).collect::<Vec<_>>();
        places.windows(2).for_each(|pair| join(&mut root, pair[0], pair[1]));
    }
    let mut count = 0;
    for first in 0..bodies.len() {
        let members: Vec<Entity> = (0..bodies.len()).filter(|&i| root[i] == first).map(|i| bodies[i].1).collect();
        let is_group = members.len() > 1;
        for &body in &members {
            if let Ok(scratch) = world.query_one_mut::<&mut SolverScratch>(body) {
                scratch.contact.has_neighbours = is_group;
            }
        }
        if is_group {
            count += members.len();
            let known = before.iter().position(|(_, group)| group.bodies == members);
            let known = known.map(|place| before.swap_remove(place).1);
            let fresh = || Box::new(BodyGroup { bodies: members, ..BodyGroup::default() });
            give_back(world, bodies[first].1, known.unwrap_or_else(fresh));
        }
    }
    count
}

/// Adds the bodies to the groups that have come to each other on the ways that they went.
pub(super) fn find_on_the_way(world: &mut World) {
    let went = |vertices: &Vertices, increment: &Increment, v: usize| {
        let x = vertices.position[v];
        [x, increment.start.get(v).copied().unwrap_or(x)]
    };
    let before = take_groups(world);
    group(world, went, (before, true));
}

/// Selects with a body all that may touch it; returns the number of those selected.
pub fn select_together(world: &mut World, _: &StepContext) -> usize {
    let mut count = 0;
    for group in lists(world) {
        let mut is_active =
            |body: &Entity| world.query_one_mut::<&SolveResult>(*body).is_ok_and(SolveResult::is_active);
        if !group.iter().any(&mut is_active) {
            continue;
        }
        for body in group {
            if let Ok(result) = world.query_one_mut::<&mut SolveResult>(body)
                && !result.is_active()
            {
                result.select(true);
                count += usize::from(result.is_active());
            }
        }
    }
    count
}

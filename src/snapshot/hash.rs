//! A number that tells two states apart.

use crate::components::{Body, CompartmentState, Grips, GuardLedger, Increment, JawsTarget, ObstacleMotion, Rigid};
use crate::math::Sym2;
use crate::storage::{Tips, Triangles, Vertices};
use glam::DVec3;
use hecs::{Entity, World};
use slotmap::Key;
use std::fmt;
use xxhash_rust::xxh3::Xxh3;

/// A hash of state and topology: XXH3 in 64 bits without a seed (Collet's xxHash, whose values are fixed), over numbers in
/// little-endian order. Two states of equal arithmetic have the same hash on every platform.
///
/// It runs over the number of steps and the time; then over every body in order of spawning:
/// - its place in that order;
/// - number of vertices, their keys, positions, velocities, rest positions, masses;
/// - number of triangles, their keys, corners, fibres, elastic constants, thicknesses, densities, and pre-stretches, strengths and
///   toughnesses where some are not the body's own, and the history of its relaxation where it relaxes;
/// - number of tips, their keys, vertices, last directions, ideal points, criterion values, falls of G/G_c, marks;
/// - for every grip the number of held vertices, their rows and their places in the jaws, and the jaws' target and its pace where it is behind
///   the hand;
/// - content, pressure, leaked volume and opening of its compartment, where it has one;
/// - the pace of holds after a limited step;
///
/// and over centre, velocity and spin of every rigid obstacle in order of spawning.
///
/// It takes column after column, each from the first row to the last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct StateHash(pub u64);

impl fmt::Display for StateHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:016x}", self.0)
    }
}

/// The checksum of bytes.
pub fn sum(bytes: &[u8]) -> u64 {
    xxhash_rust::xxh3::xxh3_64(bytes)
}

/// The hash of a world after so many steps, at a time \[ms\].
pub(crate) fn hash_of(world: &World, step: u64, time: f64) -> StateHash {
    let mut hash = Numbers(Xxh3::new());
    hash.whole(step);
    hash.real(time);
    type Memory<'a> = (Option<&'a Grips>, Option<&'a GuardLedger>, Option<&'a Increment>, Option<&'a CompartmentState>);
    let mut query = world.query::<(&Body, &Vertices, &Triangles, Option<&Tips>, Memory)>();
    let mut bodies: Vec<_> = query.iter().collect();
    bodies.sort_unstable_by_key(|(body, ..)| body.order);
    for (body, vertices, triangles, tips, (grips, ledger, increment, compartment)) in bodies {
        hash.whole(u64::from(body.order));
        hash.keys(vertices.keys());
        for column in [&vertices.position, &vertices.velocity, &vertices.rest_position] {
            hash.points(column);
        }
        vertices.mass.iter().for_each(|&mass| hash.real(mass));
        hash.keys(triangles.keys());
        triangles.corners.iter().flatten().for_each(|&corner| hash.row(corner));
        triangles.fibre.iter().flat_map(|fibre| fibre.to_array()).for_each(|value| hash.real(value));
        for law in triangles.stiffness.iter() {
            [law.q11, law.q12, law.q22, law.q66].into_iter().for_each(|q| hash.real(q));
        }
        triangles.thickness.iter().chain(triangles.density.iter()).for_each(|&value| hash.real(value));
        // Not of bodies that are the same everywhere: most are.
        if triangles.pre_stretch.iter().any(|&strain| strain != Sym2::ZERO) {
            let strains = triangles.pre_stretch.iter().flat_map(|strain| [strain.xx, strain.yy, strain.xy]);
            strains.for_each(|value| hash.real(value));
        }
        if let Some(relaxing) = &triangles.relaxing {
            relaxing.creep.iter().flatten().flat_map(|strain| strain.to_array()).for_each(|value| hash.real(value));
        }
        for factors in [&triangles.strength, &triangles.toughness] {
            if factors.iter().any(|&factor| factor != 1.0) {
                factors.iter().for_each(|&factor| hash.real(factor));
            }
        }
        if let Some(tips) = tips {
            hash.keys(tips.keys());
            tips.vertex.iter().for_each(|&vertex| hash.row(vertex));
            hash.points(&tips.previous);
            hash.points(&tips.ideal);
            tips.criterion.iter().chain(&tips.fall).for_each(|&value| hash.real(value));
            tips.is_refused.iter().chain(&tips.is_coarse).for_each(|&mark| hash.row(u32::from(mark)));
        }
        for pinch in grips.iter().flat_map(|grips| &grips.pinches) {
            hash.whole(pinch.held.rows().len() as u64);
            pinch.held.rows().iter().for_each(|&row| hash.row(row));
            hash.points(pinch.held.values());
            // Not of jaws that go with the hand.
            if let Some(JawsTarget { pose, pace }) = pinch.paced() {
                hash.points(&[pose.position]);
                pose.orientation.to_array().into_iter().chain([*pace]).for_each(|value| hash.real(value));
            }
        }
        // Not of bodies that rub on nothing.
        for contact in
            increment.iter().flat_map(|increment| &increment.last.friction).flat_map(|friction| &friction.end)
        {
            hash.row(contact.row);
            hash.points(&[contact.offset, contact.slip[0], contact.slip[1]]);
            hash.real(contact.normal_force);
        }
        if let Some(CompartmentState { content, pressure, leaked, opening, .. }) = compartment {
            [content, pressure, leaked, opening].into_iter().for_each(|value| hash.real(*value));
        }
        // Not of bodies whose holds go all their way.
        if let Some(ledger) = ledger.filter(|ledger| ledger.hold_pace > 0.0) {
            hash.real(ledger.hold_pace);
        }
    }
    let mut query = world.query::<(Entity, &ObstacleMotion)>();
    let mut rigid: Vec<_> = query.iter().filter_map(|(entity, motion)| Some((entity, motion.rigid?))).collect();
    rigid.sort_unstable_by_key(|(entity, _)| *entity);
    for (_, Rigid { centre, velocity, spin, .. }) in rigid {
        hash.points(&[centre, velocity, spin]);
    }
    StateHash(hash.0.digest())
}

/// Numbers on their way into the hash.
struct Numbers(Xxh3);

impl Numbers {
    fn whole(&mut self, value: u64) {
        self.0.update(&value.to_le_bytes());
    }

    fn row(&mut self, value: u32) {
        self.0.update(&value.to_le_bytes());
    }

    fn real(&mut self, value: f64) {
        self.whole(value.to_bits());
    }

    fn points(&mut self, points: &[DVec3]) {
        points.iter().flat_map(|point| point.to_array()).for_each(|value| self.real(value));
    }

    fn keys(&mut self, keys: &[impl Key]) {
        self.whole(keys.len() as u64);
        keys.iter().for_each(|key| self.whole(key.data().as_ffi()));
    }
}

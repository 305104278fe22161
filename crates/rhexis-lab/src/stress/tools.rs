//! A hostile hand: throws, crushes, flips, spins, cuts, and lets go, at random.

use super::dice::Dice;
use super::scene::{self, Actor, Scene};
use super::surface::{highest, lowest};
use glam::DVec3;
use rhexis::components::{Jaws, Pose, Slip};
use rhexis::math::elementary;
use rhexis::simulation::{Grasp, Simulation};
use rhexis::snapshot::Snapshot;
use rhexis::storage::{BladeId, BodyId, ForcepsId, VertexKey, Vertices};

/// What the hand has.
#[derive(Default)]
pub(super) struct Hand {
    forceps: Vec<ForcepsId>,
    blade: Option<BladeId>,
    /// A state to go back to.
    kept: Option<Snapshot>,
}

impl Hand {
    /// Does something or other to a body before a step of `dt` \[ms\]. What the engine refuses it may refuse.
    pub(super) fn act(&mut self, scene: &mut Scene, dice: &mut Dice, dt: f64) {
        let actor = scene.bodies[dice.below(scene.bodies.len())];
        let kind = if scene.is_free { 6 + dice.below(9) } else { dice.below(15) };
        let Scene { simulation, size, .. } = scene;
        let (body, size) = (actor.entity, *size);
        match kind {
            0 | 1 => self.throw(simulation, actor, dice, dt),
            2 => self.grip(simulation, actor, dice, size),
            3 => self.let_go(simulation, dice),
            4 => pin(simulation, actor, dice, size),
            5 => move_obstacle(scene, dice),
            6..=8 => crush(simulation, actor, dice, size),
            9 | 10 => fling(simulation, actor, dice, size),
            11 => {
                let shift = dice.point() * size * dice.decades(-1.0, 3.0);
                let shift = if actor.is_planar { shift.with_z(0.0) } else { shift };
                let _ = simulation.teleport(body, dice.rotation(actor.is_planar), shift);
            }
            12 => cut(simulation, body, dice),
            13 => self.pierce(simulation, body, dice, size),
            _ => self.turn_back(simulation, body, dice),
        }
    }

    /// Moves a hand far: at 10 mm/ms, or faster.
    fn throw(&mut self, simulation: &mut Simulation, actor: Actor, dice: &mut Dice, dt: f64) {
        let Some(&forceps) = self.forceps.get(dice.below(self.forceps.len().max(1))) else { return };
        let Ok(tool) = simulation.forceps(forceps) else { return };
        let by = dice.direction() * (10.0 * dt * dice.decades(-3.0, 0.5));
        let by = if actor.is_planar { by.with_z(0.0) } else { by };
        let now = tool.motion.at(simulation.time());
        let orientation = (dice.rotation(actor.is_planar) * now.orientation).normalize();
        let pose = Pose { position: now.position + by, orientation };
        let _ = simulation.move_forceps(forceps, pose, dt * dice.between(0.0, 2.0));
    }

    fn grip(&mut self, simulation: &mut Simulation, actor: Actor, dice: &mut Dice, size: f64) {
        let Some((key, at)) = vertex(simulation, actor.entity, dice) else { return };
        if self.forceps.len() < 3 {
            let stiffness = dice.chance(0.6).then(|| dice.decades(-4.0, 3.0));
            let slip = if stiffness.is_some() && dice.chance(0.5) { Slip::Slide } else { Slip::LetGo };
            let force_limit = dice.chance(0.5).then(|| dice.decades(-4.0, 2.0));
            let jaws = Jaws { radius: size * dice.decades(-2.0, -0.3), stiffness, force_limit, slip };
            if let Ok(forceps) = simulation.spawn_forceps("forceps", jaws, Pose::at(at)) {
                self.forceps.push(forceps);
            }
        }
        let Some(&forceps) = self.forceps.get(dice.below(self.forceps.len().max(1))) else { return };
        let grasp = match dice.below(4) {
            0 => Grasp::Nearest { reach: size },
            1 => Grasp::Ray { origin: at - DVec3::Z * size, direction: DVec3::Z, reach: 3.0 * size },
            2 => Grasp::Point(at),
            _ => Grasp::Vertices(vec![key]),
        };
        let _ = simulation.close_forceps(forceps, actor.entity, &grasp);
    }

    fn let_go(&mut self, simulation: &mut Simulation, dice: &mut Dice) {
        if !self.forceps.is_empty() {
            let forceps = self.forceps[dice.below(self.forceps.len())];
            let _ = simulation.open_forceps(forceps);
        }
        if dice.chance(0.3) {
            for body in simulation.bodies() {
                let _ = simulation.unpin_all(body, "pins");
            }
        }
    }

    fn pierce(&mut self, simulation: &mut Simulation, body: BodyId, dice: &mut Dice, size: f64) {
        let Some((_, at)) = vertex(simulation, body, dice) else { return };
        if dice.chance(0.4) {
            let _ = simulation.puncture(body, at, dice.direction(), size * dice.decades(-2.0, 0.0));
            return;
        }
        if self.blade.is_none() {
            self.blade = simulation.spawn_blade(0.3 * size, 0.01 * size).ok();
        }
        if let Some(blade) = self.blade {
            let _ = simulation.draw_blade(blade, body, at + dice.point() * (0.1 * size));
        }
    }

    /// Back to where it was, or rows in another order, or awake.
    fn turn_back(&mut self, simulation: &mut Simulation, body: BodyId, dice: &mut Dice) {
        match (dice.below(4), &self.kept) {
            (0, Some(kept)) => _ = simulation.restore(kept),
            (1, _) => _ = simulation.reorder(body),
            (2, _) => _ = simulation.wake(body),
            _ => self.kept = Some(simulation.snapshot()),
        }
    }
}

/// A vertex of a body and where it is.
fn vertex(simulation: &Simulation, body: BodyId, dice: &mut Dice) -> Option<(VertexKey, DVec3)> {
    let vertices = simulation.world().get::<&Vertices>(body.entity()).ok()?;
    let row = dice.below(vertices.len().max(1));
    Some((vertices.key(row as u32)?, *vertices.position.get(row)?))
}

fn pin(simulation: &mut Simulation, actor: Actor, dice: &mut Dice, size: f64) {
    let body = actor.entity;
    let chosen: Vec<VertexKey> = (0..4).filter_map(|_| vertex(simulation, body, dice)).map(|(key, _)| key).collect();
    if dice.chance(0.5) {
        for &key in &chosen {
            let _ = simulation.pin(body, "pins", &[key]);
        }
    }
    let by = dice.point() * (size * dice.decades(-3.0, 2.0));
    let by = if actor.is_planar { by.with_z(0.0) } else { by };
    if dice.chance(0.7) {
        let _ = simulation.move_pins(body, "pins", |pin| pin.place + by);
    } else {
        let _ = simulation.unpin(body, &chosen[..chosen.len().min(1)]);
    }
}

fn move_obstacle(scene: &mut Scene, dice: &mut Dice) {
    let Some(&obstacle) = scene.obstacles.get(dice.below(scene.obstacles.len().max(1))) else { return };
    let shape = scene::shape(dice, scene.size);
    let _ = scene.simulation.move_obstacle(obstacle, shape);
}

/// Bodies that loads have blown up beyond this \[mm\] are not crushed: what is put where it has no finite energy is the hand's failure.
const BLOWN_UP: f64 = 1e100;

/// Puts vertices where none should be.
fn crush(simulation: &mut Simulation, actor: Actor, dice: &mut Dice, size: f64) {
    let Ok(vertices) = simulation.entity_mut::<&mut Vertices>(actor.entity) else { return };
    if vertices.position.iter().any(|x| x.abs().max_element() > BLOWN_UP) {
        return;
    }
    let in_plane = |x: DVec3, of: DVec3| if actor.is_planar { x.with_z(of.z) } else { x };
    let middle = lowest(&vertices.position).midpoint(highest(&vertices.position));
    let (axis, amount) =
        (in_plane(dice.direction(), DVec3::ZERO).normalize_or(DVec3::X), size * dice.decades(-4.0, 0.5));
    let kind = dice.below(7);
    let other = vertices.position[dice.below(vertices.len())];
    for x in &mut vertices.position {
        let to = match kind {
            // To a point, but for noise or not even that.
            0 => middle + dice.point() * 1e-9,
            1 => middle,
            // Mirrored: planar triangles are inverted.
            2 => *x - axis * (2.0 * (*x - middle).dot(axis)),
            // Compressed by half, or to a line.
            3 => middle + (*x - middle) * 0.5,
            4 => middle + axis * (*x - middle).dot(axis),
            5 => *x + dice.point() * amount,
            // Some pressed together in one.
            _ if dice.chance(0.2) => other,
            _ => *x,
        };
        *x = in_plane(to, *x);
    }
}

/// Throws or spins a body at 100 rad/s, or ten times that.
fn fling(simulation: &mut Simulation, actor: Actor, dice: &mut Dice, size: f64) {
    let in_plane = |v: DVec3| if actor.is_planar { v.with_z(0.0) } else { v };
    let middle = vertex(simulation, actor.entity, dice).map_or(DVec3::ZERO, |(_, at)| at);
    let axis = if actor.is_planar { DVec3::Z } else { dice.direction() };
    let spin = axis * dice.decades(-2.0, 0.0);
    let flight = in_plane(dice.point() * dice.decades(-1.0, 1.0));
    // What depends on the place alone: it may be asked twice.
    let wave = elementary::rotation(DVec3::Z, 1.0) * dice.direction() * (20.0 / size);
    let noise = if dice.chance(0.3) { dice.decades(-1.0, 1.0) } else { 0.0 };
    let velocity = |x: DVec3| {
        let shake = DVec3::new(
            elementary::sin(x.dot(wave)),
            elementary::cos(2.0 * x.dot(wave)),
            elementary::sin(3.0 * x.dot(wave)),
        ) * noise;
        in_plane(spin.cross(x - middle) + flight + shake)
    };
    let _ = simulation.set_velocity(actor.entity, velocity);
}

/// Short cuts everywhere: up to thousands of tips.
pub(super) fn riddle(simulation: &mut Simulation, body: BodyId, dice: &mut Dice) {
    let Ok((low, high)) = simulation.world().get::<&Vertices>(body.entity()).map(|vertices| {
        let positions = &vertices.rest_position;
        (lowest(positions), highest(positions))
    }) else {
        return;
    };
    let most = low.distance(high) * dice.decades(-2.0, -0.5);
    for _ in 0..200 + dice.below(1000) {
        let at = simulation.world().get::<&Vertices>(body.entity()).ok().and_then(|vertices| {
            let row = dice.below(vertices.len().max(1));
            vertices.rest_position.get(row).copied()
        });
        let Some(at) = at else { return };
        let _ = simulation.cut(body, &[at, at + dice.point() * most]);
    }
}

/// A cut from one place to another, any two of the rest shape.
pub(super) fn cut(simulation: &mut Simulation, body: BodyId, dice: &mut Dice) {
    let points: Vec<DVec3> = {
        let Ok(vertices) = simulation.world().get::<&Vertices>(body.entity()) else { return };
        let count = 2 + dice.below(3);
        (0..count)
            .map(|_| {
                vertices.rest_position[dice.below(vertices.len())]
                    .lerp(vertices.rest_position[dice.below(vertices.len())], dice.between(0.0, 0.5))
            })
            .collect()
    };
    let _ = simulation.cut(body, &points);
}

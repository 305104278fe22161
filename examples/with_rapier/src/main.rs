//! Rigid bodies of rapier on tissue: rapier keeps bodies, joints and their motion, Rhexis the tissue and the contact with it.
//!
//! Every step has three parts. The tissue is told where a body is and how it moves; the tissue's step gives the impulse that it exerts on the body; and
//! rapier takes that impulse before its own step. Both use the same time step and mm, g and ms. Run it by `cargo run --release`
//! in this folder: a ball is caught by a drum, and a lever on a hinge leans on one. Both end at rest with the forces of statics.

use rapier3d_f64::prelude::{
    ColliderBuilder, PhysicsWorld, RevoluteJointBuilder, RigidBodyBuilder, RigidBodyHandle, Vector,
};
use rhexis::components::{Contact, Damping, Drag, Gravity, Obstacle, Rigid};
use rhexis::generate;
use rhexis::glam::DVec3;
use rhexis::prelude::*;
use std::error::Error;

/// Earth's \[mm/ms²\].
const GRAVITY: f64 = 9.81e-3;

/// Radius of the ball, and of the lever's end \[mm\].
const RADIUS: f64 = 2.0;

fn main() -> Result<(), Box<dyn Error>> {
    for dt in [2.0, 5.0, 10.0] {
        let borne = ball_on_drum(dt)?;
        println!("ball, dt {dt} ms: the drum bears {borne:.6} of the weight");
        // At rest after a second and a half of damped motion.
        assert!((borne - 1.0).abs() < 1e-3, "{borne}");
        let borne = lever_on_drum(dt)?;
        println!("lever, dt {dt} ms: the drum bears {borne:.6} of the weight at half the arm");
        assert!((borne - 1.0).abs() < 0.01, "{borne}");
    }
    Ok(())
}

/// A disc of tissue 12 mm wide whose rim is held.
fn drum() -> Result<Membrane, Box<dyn Error>> {
    let mesh = generate::disc(6.0, 600)?;
    let tissue = Material { density: 1e-3, ..Material::isotropic(0.5, 0.3, 0.1) };
    let disc = Membrane::new("drum", mesh, tissue)
        .with(Gravity { acceleration: DVec3::NEG_Z * GRAVITY })
        .with(Damping { time: 3.0 })
        .with(Drag { coefficient: 2e-6 })
        .with(Contact::default());
    let rim = disc.select(|x| x.truncate().length() > 5.9);
    Ok(disc.hold(Hold::new("rim", rim)))
}

/// A world of rapier whose bodies do not sleep, as it does not see the tissue.
fn rapier(dt: f64) -> PhysicsWorld {
    let mut world = PhysicsWorld::new();
    world.gravity = Vector::new(0.0, 0.0, -GRAVITY);
    world.integration_parameters.dt = dt;
    world
}

/// A body of rapier that tissue feels as a ball.
struct Coupled {
    body: RigidBodyHandle,
    obstacle: ObstacleId,
    /// The ball's centre in the body's frame \[mm\].
    centre: Vector,
}

impl Coupled {
    /// Tells the tissue where the ball is and how it moves, and the mass that it moves with.
    fn before_step(&self, world: &PhysicsWorld, tissue: &mut Simulation, mass: f64) -> Result<(), Box<dyn Error>> {
        let body = &world.bodies[self.body];
        let centre = body.position() * self.centre;
        let arm = centre - body.translation();
        let shape = Shape::Sphere { centre: dvec(centre), radius: RADIUS };
        let ball = Rigid::of(&shape, mass).ok_or("a plane")?;
        let motion = Rigid {
            velocity: dvec(body.linvel() + body.angvel().cross(arm)),
            spin: dvec(body.angvel()),
            acceleration: dvec(world.gravity),
            ..ball
        };
        tissue.set(self.obstacle, Obstacle { shape })?;
        Ok(tissue.set_rigid(self.obstacle, motion)?)
    }

    /// Gives rapier's body the impulse of the tissue; returns it \[N·ms\].
    fn after_step(&self, world: &mut PhysicsWorld, tissue: &Simulation) -> Result<DVec3, Box<dyn Error>> {
        let ball = tissue.rigid(self.obstacle)?.ok_or("no rigid body")?;
        let impulse = Vector::new(ball.impulse.x, ball.impulse.y, ball.impulse.z);
        let turn = ball.angular_impulse;
        let body = &mut world.bodies[self.body];
        let point = body.position() * self.centre;
        body.apply_impulse_at_point(impulse, point, true);
        body.apply_torque_impulse(Vector::new(turn.x, turn.y, turn.z), true);
        Ok(ball.impulse)
    }
}

/// Steps both worlds for a second and a half; returns the upward impulse of the last half second.
fn run(world: &mut PhysicsWorld, tissue: &mut Simulation, coupled: &Coupled, (dt, mass): (f64, f64)) -> Result<f64, Box<dyn Error>> {
    let mut upward = 0.0;
    while tissue.time() < 2000.0 {
        coupled.before_step(world, tissue, mass)?;
        tissue.step(dt)?;
        let impulse = coupled.after_step(world, tissue)?;
        world.step();
        if tissue.time() > 1500.0 + 0.5 * dt {
            upward += impulse.z;
        }
    }
    Ok(upward)
}

/// A ball of twice the drum's mass that falls on it: the part of the weight that the drum bears.
fn ball_on_drum(dt: f64) -> Result<f64, Box<dyn Error>> {
    let mut tissue = Simulation::new(Settings::default())?;
    tissue.spawn(drum()?)?;
    let (mass, start) = (0.02, Vector::new(0.3, 0.2, RADIUS + 0.5));
    let mut world = rapier(dt);
    let body = RigidBodyBuilder::dynamic().translation(start).can_sleep(false);
    let (body, _) = world.insert(body, ColliderBuilder::ball(RADIUS).mass(mass));
    let shape = Shape::Sphere { centre: dvec(start), radius: RADIUS };
    let obstacle = tissue.spawn_obstacle(Solid::new(shape))?;
    let coupled = Coupled { body, obstacle, centre: Vector::ZERO };
    let upward = run(&mut world, &mut tissue, &coupled, (dt, mass))?;
    Ok(upward / (mass * GRAVITY * 500.0))
}

/// A lever on a hinge, whose ball-shaped end leans on the drum: the part of the weight that the drum bears, over that by the levers' law.
fn lever_on_drum(dt: f64) -> Result<f64, Box<dyn Error>> {
    let mut tissue = Simulation::new(Settings::default())?;
    tissue.spawn(drum()?)?;
    let (mass, half) = (0.02, 5.0);
    let (hinge, end) = (Vector::new(-2.0 * half, 0.0, RADIUS + 0.3), Vector::new(half, 0.0, 0.0));
    let mut world = rapier(dt);
    let anchor = world.insert_body(RigidBodyBuilder::fixed().translation(hinge));
    let lever = RigidBodyBuilder::dynamic().translation(hinge + end).can_sleep(false);
    // Without contacts of its own: the tissue sees the ball at its end alone.
    let (lever, _) = world.insert(lever, ColliderBuilder::cuboid(half, 0.2, 0.2).mass(mass).sensor(true));
    let joint = RevoluteJointBuilder::new(Vector::Y).local_anchor2(-end).contacts_enabled(false);
    world.insert_impulse_joint(anchor, lever, joint);
    let shape = Shape::Sphere { centre: dvec(hinge + end * 2.0), radius: RADIUS };
    let obstacle = tissue.spawn_obstacle(Solid::new(shape))?;
    let coupled = Coupled { body: lever, obstacle, centre: end };
    // A rod turned about its end moves at the other like a third of its mass.
    let upward = run(&mut world, &mut tissue, &coupled, (dt, mass / 3.0))?;
    Ok(upward / (0.5 * mass * GRAVITY * 500.0))
}

fn dvec(v: Vector) -> DVec3 {
    DVec3::new(v.x, v.y, v.z)
}

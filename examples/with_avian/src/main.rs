//! Rigid bodies of Avian on tissue: Avian keeps bodies, joints and their motion in Bevy's world, Rhexis the tissue and the contact with it.
//!
//! Three systems of `FixedUpdate` couple them, before Avian's own step in `FixedPostUpdate`: the tissue is told where a body is and how it moves, the
//! tissue's step gives the impulse that it exerts on the body, and the body takes it. Rhexis counts in mm, g and ms, Avian here in mm, g and s.
//! Run it by `cargo run --release` in this folder: a drum catches a ball, and a door handle is pulled up
//! through cloth. Both end at rest with the forces of statics.

use avian3d::prelude::*;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use rhexis::components::{Contact, Curve, Damping, Drag, Obstacle, Rigid};
use rhexis::generate;
use rhexis::glam::{DMat3, DQuat, DVec3};
use rhexis::prelude::{Hold, Material, Membrane, ObstacleId, Settings, Shape, Simulation, Solid, TriangleMesh};
use std::error::Error;
use std::time::Duration;

/// Avian's vectors: those of Bevy's own version of glam.
type Vector = avian3d::math::Vector;
type Outcome<T> = std::result::Result<T, Box<dyn Error>>;

/// Earth's \[mm/ms²\].
const GRAVITY: f64 = 9.81e-3;
/// Milliseconds of a second.
const SECOND: f64 = 1e3;

/// Radius of the ball, and of the handle's knob \[mm\].
const RADIUS: f64 = 2.0;
/// Length of the handle's lever from its hinge to the middle of the knob \[mm\].
const LEVER: f64 = 10.0;
/// Way by which the cloth is pulled up \[mm\], and how long that takes \[ms\].
const PULL: (f64, f64) = (5.0, 500.0);

fn main() -> Outcome<()> {
    for dt in [2.0, 5.0, 10.0] {
        let borne = ball_on_drum(dt)?;
        println!("ball, dt {dt} ms: the drum bears {borne:.6} of the weight");
        assert!((borne - 1.0).abs() < 1e-3, "{borne}");
    }
    let (borne, rise) = handle_in_cloth(2.0)?;
    println!("handle, dt 2 ms: {rise:.2} mm up the cloth bears {borne:.6} of the lever's moment");
    assert!((borne - 1.0).abs() < 1e-3 && rise > 2.0, "{borne} at {rise} mm");
    Ok(())
}

/// The tissue's simulation, and the impulses and their moments about the origin \[N·ms, N·mm·ms\] on the body since a time \[ms\].
#[derive(Resource)]
struct Tissue {
    simulation: Simulation,
    dt: f64,
    counted_from: f64,
    impulse: DVec3,
    moment: DVec3,
}

/// The part of a body of Avian that tissue feels.
#[derive(Component)]
struct Felt {
    obstacle: ObstacleId,
    /// Shape in the body's frame \[mm\].
    shape: Shape,
    /// Mass that moves where the shape is \[g\].
    mass: f64,
}

impl Felt {
    /// Place of the shape in the world.
    fn now(&self, position: &Position, rotation: &Rotation) -> Shape {
        let turn = DMat3::from_quat(DQuat::from_array(rotation.0.to_array()));
        self.shape.turned(turn, DVec3::ZERO).moved_by(dvec(position.0))
    }
}

/// Tells the tissue where bodies are and how they move.
fn tell(
    mut tissue: ResMut<Tissue>,
    bodies: Query<(&Felt, &Position, &Rotation, &LinearVelocity, &AngularVelocity)>,
) -> Result {
    for (felt, position, rotation, velocity, spin) in &bodies {
        let shape = felt.now(position, rotation);
        let (velocity, spin) = (dvec(velocity.0) / SECOND, dvec(spin.0) / SECOND);
        let arm = shape.anchor() - dvec(position.0);
        let still = Rigid::of(&shape, felt.mass).ok_or("a plane")?;
        let acceleration = DVec3::NEG_Z * GRAVITY;
        let moving = Rigid { velocity: velocity + spin.cross(arm), spin, acceleration, ..still };
        tissue.simulation.set(felt.obstacle, Obstacle { shape })?;
        tissue.simulation.set_rigid(felt.obstacle, moving)?;
    }
    Ok(())
}

/// Steps the tissue.
fn step(mut tissue: ResMut<Tissue>) -> Result {
    let dt = tissue.dt;
    tissue.simulation.step(dt)?;
    Ok(())
}

/// Gives bodies the impulses of the tissue.
fn take(
    mut tissue: ResMut<Tissue>,
    mut bodies: Query<(&Felt, &Position, &Rotation, Forces), Without<Sleeping>>,
) -> Result {
    for (felt, position, rotation, mut forces) in &mut bodies {
        let Rigid { impulse, angular_impulse, .. } = tissue.simulation.rigid(felt.obstacle)?.ok_or("no rigid body")?;
        let at = felt.now(position, rotation).anchor();
        forces.apply_linear_impulse_at_point(vector(impulse * SECOND), vector(at));
        forces.apply_angular_impulse(vector(angular_impulse * SECOND));
        if tissue.simulation.time() > tissue.counted_from + 0.5 * tissue.dt {
            tissue.impulse += impulse;
            tissue.moment += at.cross(impulse) + angular_impulse;
        }
    }
    Ok(())
}

/// An app without a window whose frames are steps of `dt` \[ms\].
fn app(simulation: Simulation, dt: f64) -> App {
    let frame = Duration::from_secs_f64(dt / SECOND);
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, PhysicsPlugins::default()));
    app.insert_resource(Gravity(Vector::NEG_Z * GRAVITY * SECOND * SECOND));
    app.insert_resource(Time::<Fixed>::from_duration(frame)).insert_resource(TimeUpdateStrategy::ManualDuration(frame));
    app.insert_resource(Tissue {
        simulation,
        dt,
        counted_from: f64::INFINITY,
        impulse: DVec3::ZERO,
        moment: DVec3::ZERO,
    });
    app.add_systems(FixedUpdate, (tell, step, take).chain());
    app.finish();
    app.cleanup();
    app
}

/// Runs for two seconds, and for a last half whose impulses are counted: their sum and that of their moments, per ms.
fn settle(app: &mut App) -> (DVec3, DVec3) {
    let until = |app: &mut App, end: f64| {
        while app.world().resource::<Tissue>().simulation.time() < end - 1e-9 {
            app.update();
        }
    };
    until(app, 2000.0);
    app.world_mut().resource_mut::<Tissue>().counted_from = 2000.0;
    until(app, 2500.0);
    let tissue = app.world().resource::<Tissue>();
    (tissue.impulse / 500.0, tissue.moment / 500.0)
}

/// A body at a place \[mm\] that tissue feels by its whole shape.
fn spawn_body(app: &mut App, shape: Shape, mass: f64, inertia: AngularInertia) -> Outcome<Entity> {
    let centre = shape.anchor();
    let obstacle = app.world_mut().resource_mut::<Tissue>().simulation.spawn_obstacle(Solid::new(shape.clone()))?;
    let felt = Felt { obstacle, shape: shape.moved_by(-centre), mass };
    let body = (RigidBody::Dynamic, Mass(mass as f32), inertia, Position(vector(centre)), SleepingDisabled, felt);
    Ok(app.world_mut().spawn(body).id())
}

/// A membrane that is damped, has weight and feels obstacles.
fn tissue(name: &str, mesh: TriangleMesh) -> Membrane {
    let material = Material { density: 1e-3, ..Material::isotropic(0.5, 0.3, 0.1) };
    Membrane::new(name, mesh, material)
        .with(rhexis::components::Gravity { acceleration: DVec3::NEG_Z * GRAVITY })
        .with(Damping { time: 3.0 })
        .with(Drag { coefficient: 2e-6 })
        .with(Contact::default())
}

/// A ball that falls on a disc whose rim is held: the part of its weight that the disc bears.
fn ball_on_drum(dt: f64) -> Outcome<f64> {
    let drum = tissue("drum", generate::disc(6.0, 600)?);
    let rim = drum.select(|x| x.truncate().length() > 5.9);
    let mut simulation = Simulation::new(Settings::default())?;
    simulation.spawn(drum.hold(Hold::new("rim", rim)))?;
    let mut app = app(simulation, dt);
    let mass = 0.02;
    let shape = Shape::Sphere { centre: DVec3::new(0.3, 0.2, RADIUS + 0.5), radius: RADIUS };
    spawn_body(&mut app, shape, mass, AngularInertia::from_shape(&Sphere::new(RADIUS as f32), mass as f32))?;
    let (force, _) = settle(&mut app);
    Ok(force.z / (mass * GRAVITY))
}

/// A lever on a hinge whose knob a band of cloth pulls up: the part of the moment of its weight that the cloth bears, and the knob's rise \[mm\].
fn handle_in_cloth(dt: f64) -> Outcome<(f64, f64)> {
    let band = tissue("cloth", generate::grid(6.0, 24.0, 8, 32)?);
    let ends = band.select(|x| x.y == 0.0 || x.y == 24.0);
    let pull = Hold::new("hands", ends).moved(DVec3::Z * PULL.0, Curve::ramp(PULL.1, 1.0)?);
    let mut simulation = Simulation::new(Settings::default())?;
    simulation.spawn(band.hold(pull))?;
    // The knob lies over the middle of the band, the hinge beside it.
    let knob = DVec3::new(3.0, 12.0, RADIUS + 0.2);
    let obstacle = simulation.spawn_obstacle(Solid::new(Shape::Sphere { centre: knob, radius: RADIUS }))?;
    let mut app = app(simulation, dt);
    let (mass, arm) = (0.02, DVec3::X * 0.5 * LEVER);
    let hinge = app.world_mut().spawn((RigidBody::Static, Position(vector(knob - 2.0 * arm)))).id();
    let inertia = AngularInertia::from_shape(&Cuboid::new(LEVER as f32, 0.4, 0.4), mass as f32);
    // A rod turned about its end moves at the other like a third of its mass.
    let felt = Felt { obstacle, shape: Shape::Sphere { centre: arm, radius: RADIUS }, mass: mass / 3.0 };
    let lever = (RigidBody::Dynamic, Mass(mass as f32), inertia, Position(vector(knob - arm)), SleepingDisabled, felt);
    let lever = app.world_mut().spawn(lever).id();
    let joint = RevoluteJoint::new(hinge, lever).with_hinge_axis(Vector::Y).with_local_anchor2(vector(-arm));
    app.world_mut().spawn(joint);
    let (force, moment) = settle(&mut app);
    let turned = app.world().get::<Rotation>(lever).ok_or("no lever")?.0 * vector(arm);
    let weight = DVec3::NEG_Z * mass * GRAVITY;
    let about_hinge = moment - (knob - 2.0 * arm).cross(force);
    Ok((-about_hinge.y / dvec(turned).cross(weight).y, 2.0 * turned.z))
}

fn dvec(v: Vector) -> DVec3 {
    DVec3::from_array(v.to_array())
}

fn vector(v: DVec3) -> Vector {
    Vector::from_array(v.to_array())
}

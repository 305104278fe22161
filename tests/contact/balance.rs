//! The balance of momentum: reported forces of obstacles and holds, with the loads, are the rate of momentum at every step.

use glam::{DMat3, DVec3};
use rhexis::components::{
    Bending, Contact, Curve, Damping, Gravity, Hold, Increment, Material, Obstacle, Path, PreStretch, Shape,
};
use rhexis::generate;
use rhexis::math::Sym2;
use rhexis::membrane::Membrane;
use rhexis::settings::{Advanced, LinearParams, Settings};
use rhexis::simulation::{Simulation, Solid};
use rhexis::storage::{Attached, BodyId, TriangleMesh, Vertices};

/// Holds the vertices of a body at rest that satisfy a condition.
fn held(body: Membrane, is_held: impl Fn(DVec3) -> bool) -> Membrane {
    let members = Attached::new(body.select(is_held).into_iter().map(|v| (v, DVec3::ZERO)));
    body.hold(Hold { name: "rim".into(), members, axes: [true; 3], curve: Curve::constant(0.0) })
}

/// Rate of momentum over the last step \[N\], by velocities and masses alone.
fn rate(simulation: &Simulation, body: BodyId) -> DVec3 {
    let world = simulation.world();
    let vertices = world.get::<&Vertices>(body.entity()).unwrap();
    let increment = world.get::<&Increment>(body.entity()).unwrap();
    let jumps = vertices.velocity.iter().zip(&increment.start_velocity).zip(&vertices.mass);
    jumps.map(|((v1, v0), m)| (*v1 - *v0) * (*m / increment.last.dt)).sum()
}

fn sum<T>(forces: Vec<(T, DVec3)>) -> DVec3 {
    forces.into_iter().map(|(_, force)| force).sum()
}

/// Forces of obstacles and of holds \[N\].
fn told(simulation: &Simulation, body: BodyId) -> [DVec3; 2] {
    [sum(simulation.contact_forces(body).unwrap()), sum(simulation.reactions(body).unwrap())]
}

/// Pushes a body without loads by an obstacle, which has to give more than `least` \[N\]. Solved to rounding, nothing is missing at any step; by the
/// default tolerances no more than `most` \[N\].
fn push(body: &Membrane, solid: &Solid, (dt, steps): (f64, usize), least: f64, most: f64) {
    let linear = LinearParams { stress_tolerance: f64::INFINITY, ..LinearParams::by_residual(1e-10, 100_000) };
    let tight = Settings {
        position_tolerance: f64::INFINITY,
        advanced: Advanced { linear, ..Advanced::default() },
        ..Settings::default()
    };
    let [force, missing] = pushed(tight, body, solid, (dt, steps));
    println!("to rounding {missing} of {force} N");
    assert!(force > least && missing < 1e-6 * force, "{missing} of {force} N");
    let [force, missing] = pushed(Settings::default(), body, solid, (dt, steps));
    println!("by default {missing} of {force} N");
    assert!(force > least && missing < most, "{missing} of {force} N");
}

/// The largest force that was told of the obstacle, and the largest that is missing \[N\].
fn pushed(settings: Settings, body: &Membrane, solid: &Solid, (dt, steps): (f64, usize)) -> [f64; 2] {
    let mut simulation = Simulation::new(settings).unwrap();
    let body = simulation.spawn(body.clone()).unwrap();
    simulation.spawn_obstacle(solid.clone()).unwrap();
    let (mut largest, mut missing) = (0.0_f64, 0.0_f64);
    for _ in 0..steps {
        assert!(!simulation.step(dt).unwrap().has_failed);
        let [pushed, held] = told(&simulation, body);
        let off = rate(&simulation, body) - pushed - held;
        largest = largest.max(pushed.length());
        missing = missing.max(off.length());
        let unbalanced = simulation.unbalanced_force(body).unwrap().unwrap();
        assert!((unbalanced - off).length() < 1e-9 * (1.0 + largest), "{unbalanced} against {off}");
    }
    [largest, missing]
}

fn upwards(way: f64, time: f64) -> Path {
    Path { points: vec![(0.0, DVec3::ZERO), (time, DVec3::Z * way)] }
}

#[test]
fn a_rim_bears_what_a_ball_gives_while_it_moves_and_at_rest() {
    for (friction, dt) in [(0.0, 5.0), (0.2, 5.0), (1.0, 5.0), (1.0, 1.0)] {
        let mesh = generate::disc(8.0, 700).unwrap();
        let skin = Membrane::new("skin", mesh, Material::isotropic(1.0, 0.4, 0.2))
            .with(Damping { time: 2.0 })
            .with(Contact { friction, ..Contact::default() });
        let skin = held(skin, |p| p.length() > 8.0 * (1.0 - 1e-9));
        let ball = Shape::Sphere { centre: DVec3::NEG_Z * 3.01, radius: 3.0 };
        let steps = (400.0 / dt) as usize;
        println!("friction {friction}, dt {dt}");
        push(&skin, &Solid::new(ball).path(upwards(3.0, 250.0)), (dt, steps), 0.1, 1e-3);
    }
}

/// A ring with a slit in it, about a hole of 2 mm radius.
fn ring() -> TriangleMesh {
    generate::mapped_grid(40, 8, |u, v| {
        let (angle, radius) = (6.2 * u, 2.0 + 6.0 * v);
        DVec3::new(radius * angle.cos(), radius * angle.sin(), 0.0)
    })
    .unwrap()
}

#[test]
fn the_edge_of_a_hole_feels_the_rod_that_is_pushed_through() {
    let skin = Membrane::new("skin", ring(), Material::isotropic(2.0, 0.45, 0.5))
        .with(Bending::default())
        .with(Damping { time: 5.0 })
        .with(Contact { friction: 0.1, ..Contact::default() });
    let skin = held(skin, |p| p.length() > 8.0 * (1.0 - 1e-9));
    let rod = Shape::Capsule { ends: [DVec3::NEG_Z * 12.0, DVec3::NEG_Z * 3.3], radius: 3.2 };
    // A friction that sticks whatever its coefficient gives 0.8 N, another force at steps of 1 ms.
    push(&skin, &Solid::new(rod).path(upwards(3.0, 400.0)), (5.0, 100), 0.1, 3e-3);
}

#[test]
fn a_rod_thinner_than_a_triangle_is_felt_between_the_vertices() {
    let thin = [
        Shape::Cylinder { ends: [DVec3::new(10.33, 10.4, -10.05), DVec3::new(10.33, 10.4, -0.05)], radius: 0.2 },
        Shape::Capsule { ends: [DVec3::new(10.33, 10.4, -10.05), DVec3::new(10.33, 10.4, -0.25)], radius: 0.2 },
        Shape::Box { centre: DVec3::new(10.33, 10.4, -5.05), half: DVec3::new(0.2, 0.2, 5.0), axes: DMat3::IDENTITY },
    ];
    for shape in thin {
        let mesh = generate::grid(20.0, 20.0, 20, 20).unwrap();
        let skin = Membrane::new("skin", mesh, Material::isotropic(1.0, 0.3, 0.1))
            .with(PreStretch { strain: Sym2::new(0.05, 0.05, 0.0) })
            .with(Damping { time: 1.0 })
            .with(Contact::default());
        let at_rim = |x: f64| !(1e-9..20.0 - 1e-9).contains(&x);
        let skin = held(skin, |p| at_rim(p.x) || at_rim(p.y));
        println!("{shape:?}");
        push(&skin, &Solid::new(shape).path(upwards(1.2, 120.0)), (2.0, 70), 0.02, 1e-3);
    }
}

#[test]
fn a_sheet_that_lands_gives_its_momentum_to_the_table_and_no_more() {
    let (mass, speed, weight) = (0.08, 0.05, 0.08 * 9.81e-3);
    for dt in [1.0, 5.0] {
        let mesh = generate::grid(20.0, 20.0, 16, 16).unwrap();
        let sheet = Membrane::new("sheet", mesh, Material::isotropic(1.0, 0.4, 0.2))
            .with(Bending::default())
            .with(Damping { time: 5.0 })
            .with(Gravity { acceleration: DVec3::NEG_Z * 9.81e-3 })
            .with(Contact { friction: 0.3, ..Contact::default() });
        let mut simulation = Simulation::new(Settings::default()).unwrap();
        let body = simulation.spawn(sheet).unwrap();
        {
            let mut vertices = simulation.world().get::<&mut Vertices>(body.entity()).unwrap();
            vertices.velocity.fill(DVec3::NEG_Z * speed);
        }
        let table = Shape::Plane { point: DVec3::NEG_Z * 0.5, normal: DVec3::Z };
        simulation.spawn_obstacle(Obstacle { shape: table }).unwrap();
        let (mut impulse, mut largest, mut fastest, mut force) = (0.0, 0.0_f64, 0.0_f64, DVec3::ZERO);
        while simulation.time() < 600.0 - 0.5 * dt {
            simulation.step(dt).unwrap();
            [force, _] = told(&simulation, body);
            let off = rate(&simulation, body) - force + DVec3::Z * weight;
            assert!(off.length() < 1e-6, "{off} N at {} ms", simulation.time());
            impulse += force.z * dt;
            largest = largest.max(force.z);
            let vertices = simulation.world().get::<&Vertices>(body.entity()).unwrap();
            fastest = vertices.velocity.iter().map(|v| v.z).fold(fastest, f64::max);
        }
        let expected = mass * speed + weight * simulation.time();
        println!("dt {dt}: impulse {impulse} of {expected}, largest {largest} N, at rest {} N, up {fastest}", force.z);
        assert!((impulse - expected).abs() < 1e-4 * expected, "{impulse} against {expected} N·ms");
        assert!((force.z - weight).abs() < 1e-5 * weight, "{} against {weight} N", force.z);
        // All of its momentum in one step, at the speed of a fall by 0.5 mm and a step; it does not come up again.
        assert!(largest < 1.1 * (mass * 0.12 / dt + 2.0 * weight), "{largest} N");
        assert!(fastest < 0.01, "{fastest} mm/ms");
    }
}

#[test]
fn an_obstacle_that_is_taken_away_pushes_no_more() {
    let sheet = Membrane::new("sheet", generate::grid(4.0, 4.0, 8, 8).unwrap(), Material::isotropic(1.0, 0.4, 0.2))
        .with(Gravity { acceleration: DVec3::NEG_Z * 9.81e-3 })
        .with(Contact::default());
    let mut simulation = Simulation::new(Settings::default()).unwrap();
    let body = simulation.spawn(sheet).unwrap();
    let table = Obstacle { shape: Shape::Plane { point: DVec3::NEG_Z * 0.01, normal: DVec3::Z } };
    let table = simulation.spawn_obstacle(table).unwrap();
    (0..5).for_each(|_| _ = simulation.step(5.0).unwrap());
    assert_eq!(simulation.contact_forces(body).unwrap().len(), 1);
    simulation.despawn(table).unwrap();
    simulation.step(5.0).unwrap();
    assert_eq!(simulation.contact_forces(body).unwrap(), []);
    let (off, weight) = (simulation.unbalanced_force(body).unwrap().unwrap(), 16.0 * 0.2e-3 * 9.81e-3);
    assert!(off.length() < 1e-6 * weight && (rate(&simulation, body).z + weight).abs() < 1e-6 * weight, "{off}");
}

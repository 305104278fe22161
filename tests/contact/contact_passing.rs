//! Obstacles thinner than what they push: rods and ellipsoids that lie along the sheet, small balls.

use glam::{DMat3, DVec3};
use rhexis::components::{Contact, Curve, Hold, Material, Obstacle, Path, PreStretch, Shape};
use rhexis::generate;
use rhexis::math::Sym2;
use rhexis::membrane::Membrane;
use rhexis::settings::{Advanced, Settings};
use rhexis::simulation::{Simulation, Solid};
use rhexis::storage::{Attached, BodyId, Triangles, Vertices};
use std::f64::consts::PI;

const RADIUS: f64 = 5.0;

/// How far the obstacle and the drum's rim go past each other.
const RISE: f64 = 10.0;

/// A taut disc whose rim goes down by `fall` \[mm\] within `end` \[ms\].
fn drum(triangles: usize, fall: f64, end: f64) -> Membrane {
    let mesh = generate::disc(RADIUS, triangles).unwrap();
    let mut drum = Membrane::new("drum", mesh, Material::isotropic(3.0, 0.0, 0.015));
    let rim = drum.select(|p| p.length() > RADIUS * (1.0 - 1e-9)).into_iter().map(|v| (v, DVec3::NEG_Z * fall));
    let members = Attached::new(rim);
    let curve = Curve::new(vec![(0.0, 0.0), (end, 1.0)]).unwrap();
    drum = drum.hold(Hold { name: "rim".into(), members, axes: [true; 3], curve });
    drum.with(PreStretch { strain: Sym2::new(0.08, 0.08, 0.0) }).with(Contact::default())
}

/// The solid angle of a triangle (van Oosterom, Strackee 1983).
fn solid_angle(x: [DVec3; 3]) -> f64 {
    let [a, b, c] = x;
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    2.0 * a.dot(b.cross(c)).atan2(la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb)
}

/// How often the sheet, closed by a flat disc in its rim, goes round a point: once round one between both, not at all round others.
fn winding(simulation: &Simulation, body: BodyId, rim: f64, p: DVec3) -> f64 {
    let world = simulation.world();
    let (vertices, triangles) =
        (world.get::<&Vertices>(body.entity()).unwrap(), world.get::<&Triangles>(body.entity()).unwrap());
    let angle = |corners: &[u32; 3]| {
        let of = |points: &[DVec3], p: DVec3| solid_angle(corners.map(|v| points[v as usize] - p));
        of(&vertices.position, p) - of(&vertices.rest_position, p - DVec3::Z * rim)
    };
    triangles.corners.iter().map(angle).sum::<f64>() / (4.0 * PI)
}

/// Points of a shape that no sheet may leave behind.
fn inside(shape: &Shape) -> Vec<DVec3> {
    let along = |a: DVec3, b: DVec3| (0..=20).map(|i| a.lerp(b, f64::from(i) / 20.0)).collect();
    match *shape {
        Shape::Capsule { ends: [a, b], .. } => along(a, b),
        Shape::Ellipsoid { centre, half_axes, .. } => {
            let axis = DVec3::X * (0.85 * half_axes.x);
            along(centre - axis, centre + axis)
        }
        _ => vec![shape.anchor()],
    }
}

fn shapes() -> [Shape; 7] {
    let ball = |radius: f64| Shape::Sphere { centre: DVec3::new(0.3, 0.2, -radius - 0.1), radius };
    let rod = |radius: f64| Shape::Capsule {
        ends: [DVec3::new(-1.0, 0.0, -radius - 0.1), DVec3::new(1.0, 0.3, -radius - 0.1)],
        radius,
    };
    let ellipsoid = |half_axes: DVec3| Shape::Ellipsoid {
        centre: DVec3::NEG_Z * (half_axes.z + 0.1),
        half_axes,
        axes: DMat3::IDENTITY,
    };
    [
        ball(0.4),
        ball(0.2),
        rod(0.5),
        rod(0.2),
        Shape::Capsule { ends: [DVec3::NEG_Z * 9.0, DVec3::NEG_Z * 0.5], radius: 0.3 },
        ellipsoid(DVec3::new(1.5, 0.6, 0.5)),
        ellipsoid(DVec3::new(2.0, 0.3, 0.3)),
    ]
}

/// Draws a drum 10 mm out over an obstacle, and goes on until it has sprung back from there and come to rest.
fn nothing_passes(settings: &Settings, triangles: usize, motions: &[(f64, f64)], is_obstacle_moved: bool) {
    for shape in shapes() {
        for &(speed, dt) in motions {
            let end = RISE / speed;
            let (rise, fall) = if is_obstacle_moved { (RISE, 0.0) } else { (0.0, RISE) };
            let mut simulation = Simulation::new(*settings).unwrap();
            let body = simulation.spawn(drum(triangles, fall, end)).unwrap();
            if is_obstacle_moved {
                let path = Path { points: vec![(0.0, DVec3::ZERO), (end, DVec3::Z * rise)] };
                simulation.spawn_obstacle(Solid::new(shape.clone()).path(path)).unwrap();
            } else {
                simulation.spawn_obstacle(Obstacle { shape: shape.clone() }).unwrap();
            }
            let mut rolled_back = 0;
            while simulation.time() < end + 20.0 * dt {
                let report = simulation.step(dt).unwrap();
                rolled_back += report.rolled_back;
                assert!(!report.has_failed);
                let (time, done) = (simulation.time(), (simulation.time() / end).min(1.0));
                let moved = shape.moved_by(DVec3::Z * rise * done);
                let rim = -fall * done;
                let passed = |p: &DVec3| p.z > rim && (winding(&simulation, body, rim, *p) - 1.0).abs() > 0.5;
                let count = inside(&moved).iter().filter(|p| passed(p)).count();
                assert!(count == 0, "{count} points of {shape:?} have come through at {speed} m/s, dt {dt}, {time} ms");
            }
            println!("{triangles}, {shape:?}, {speed} m/s, dt {dt}: {rolled_back} retried");
        }
    }
}

/// m/s and ms.
const MOTIONS: [(f64, f64); 3] = [(0.1, 5.0), (1.0, 1.0), (1.0, 4.0)];

#[test]
fn a_drum_never_comes_through_a_thin_obstacle_that_draws_it_out() {
    for triangles in [300, 1000, 2700] {
        nothing_passes(&Settings::default(), triangles, &MOTIONS, true);
    }
}

#[test]
fn a_drum_never_comes_through_a_thin_obstacle_over_which_it_is_drawn() {
    nothing_passes(&Settings::default(), 1000, &MOTIONS, false);
}

#[test]
fn steps_of_several_solves_never_come_through_either() {
    let settings =
        Settings { advanced: Advanced { newton_iterations: 4, ..Advanced::default() }, ..Settings::default() };
    for is_obstacle_moved in [true, false] {
        nothing_passes(&settings, 1000, &MOTIONS[1..], is_obstacle_moved);
    }
}

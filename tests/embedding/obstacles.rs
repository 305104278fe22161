//! Obstacles and tools are judged when they are put in, moved, set and written past the calls.

use crate::doors::{NAN, drawn, simulation, sphere};
use glam::{DMat3, DVec3};
use rhexis::components::{Contact, Jaws, Obstacle, Path, Pose, Shape};
use rhexis::membrane::BodyError;
use rhexis::simulation::{SetError, SimulationError, Solid};

#[test]
fn obstacles_and_tools_are_judged_when_they_are_put_in_and_moved() {
    let mut s = simulation();
    let axes = |half_axes| Shape::Ellipsoid { centre: DVec3::ZERO, half_axes, axes: DMat3::IDENTITY };
    let turned = |axes| Shape::Ellipsoid { centre: DVec3::ZERO, half_axes: DVec3::ONE, axes };
    let shapes = [
        sphere(-1.0),
        sphere(f64::NAN),
        Shape::Sphere { centre: NAN, radius: 1.0 },
        Shape::Plane { point: DVec3::ZERO, normal: DVec3::Z * 2.0 },
        Shape::Plane { point: NAN, normal: DVec3::Z },
        axes(DVec3::new(1.0, 0.0, 1.0)),
        axes(DVec3::INFINITY),
        turned(DMat3::ZERO),
        turned(DMat3::from_diagonal(DVec3::new(1.0, 1.0, -1.0))),
        Shape::Capsule { ends: [DVec3::ZERO, NAN], radius: 1.0 },
        Shape::Capsule { ends: [DVec3::ZERO, DVec3::X], radius: 0.0 },
    ];
    let ball = s.spawn_obstacle(Obstacle { shape: sphere(1.0) }).unwrap();
    for shape in shapes {
        assert!(matches!(
            s.spawn_obstacle(Obstacle { shape: shape.clone() }),
            Err(BodyError::OutOfRange { component: "Obstacle", .. })
        ));
        assert!(s.spawn_obstacle(Solid::new(shape.clone()).path(Path::default())).is_err());
        assert!(matches!(s.move_obstacle(ball, shape.clone()), Err(SimulationError::Written(_))), "{shape:?}");
        assert!(matches!(s.set(ball, Obstacle { shape: shape.clone() }), Err(SetError::Rejected(_))), "{shape:?}");
    }
    let path = Path { points: vec![(0.0, NAN)] };
    assert!(s.spawn_obstacle(Solid::new(sphere(1.0)).path(path)).is_err());
    assert_eq!(s.world().get::<&Obstacle>(ball.entity()).unwrap().shape, sphere(1.0));
    assert!(s.spawn_blade(f64::NAN, 1.0).is_err() && s.spawn_blade(1.0, -1.0).is_err());
    let jaws = Jaws { radius: f64::NAN, ..Jaws::default() };
    assert!(s.spawn_forceps("f", jaws, Pose::default()).is_err());
}

#[test]
fn a_nan_obstacle_that_was_written_is_refused_at_the_next_step() {
    let (mut s, body) = drawn();
    let ball = s.spawn_obstacle(Obstacle { shape: sphere(1.0) }).unwrap();
    s.set(body, Contact::default()).unwrap();
    s.step(1.0).unwrap();
    s.entity_mut::<&mut Obstacle>(ball).unwrap().shape = sphere(f64::NAN);
    let error = s.step(1.0).unwrap_err().to_string();
    assert!(error.contains("obstacle") && error.contains("radius is NaN"), "{error}");
    s.set(ball, Obstacle { shape: sphere(2.0) }).unwrap();
    s.step(1.0).unwrap();
}

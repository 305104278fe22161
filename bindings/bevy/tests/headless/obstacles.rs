//! Obstacles of the engine, shown by meshes.

use crate::common::*;
use bevy::mesh::VertexAttributeValues;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_rhexis::rhexis::components::{Contact, Hull, Obstacle, Path, Rigid, Shape};
use bevy_rhexis::rhexis::glam::{DMat3, DVec3 as Double};
use bevy_rhexis::rhexis::prelude::{Solid, generate};
use bevy_rhexis::rhexis::storage::ObstacleId;
use bevy_rhexis::*;
use std::sync::Arc;
use std::time::Duration;

#[derive(Component, Clone, Debug, PartialEq)]
struct Steel;

fn add(app: &mut App, solid: impl Into<Solid>) -> ObstacleId {
    engine(app).simulation_mut().spawn_obstacle(solid).unwrap()
}

fn ball(place: Double) -> Shape {
    Shape::Sphere { centre: place, radius: 2.0 }
}

fn show_all(app: &mut App) -> Entity {
    app.world_mut().spawn((Name::new("obstacles"), ShownObstacles::with(Steel))).id()
}

fn shown(app: &mut App) -> Vec<(Entity, ObstacleId)> {
    let mut query = app.world_mut().query::<(Entity, &ShownObstacle)>();
    query.iter(app.world()).map(|(entity, one)| (entity, one.obstacle())).collect()
}

/// Largest distance of a vertex of the obstacle's mesh, as it is drawn, from a shape of the engine [mm].
fn off(app: &mut App, obstacle: ObstacleId, shape: &Shape) -> f64 {
    let all = shown(app);
    let (entity, _) = *all.iter().find(|(_, other)| *other == obstacle).expect("it is shown");
    let drawn = *app.world().get::<GlobalTransform>(entity).unwrap();
    assert_eq!(drawn, GlobalTransform::from(*app.world().get::<Transform>(entity).unwrap()));
    let Some(VertexAttributeValues::Float32x3(places)) = mesh(app, entity).attribute(Mesh::ATTRIBUTE_POSITION).cloned()
    else {
        panic!("positions");
    };
    assert!(mesh(app, entity).attribute(Mesh::ATTRIBUTE_NORMAL).is_some());
    let space = *engine(app).space();
    let distance = |place: [f32; 3]| {
        let point = space.to_engine(drawn.transform_point(Vec3::from_array(place)));
        shape.distance(point).map_or(f64::INFINITY, |(distance, _)| distance.abs())
    };
    places.into_iter().map(distance).fold(0.0, f64::max)
}

fn shape_now(app: &mut App, obstacle: ObstacleId) -> Shape {
    engine(app).simulation().world().get::<&Obstacle>(obstacle.entity()).unwrap().shape.clone()
}

/// A turned axis system.
fn axes() -> DMat3 {
    DMat3::from_axis_angle(Double::new(1.0, 2.0, -0.5).normalize(), 0.8)
}

#[test]
fn shapes_of_every_kind_lie_where_the_engine_has_them() {
    let space = Transform {
        translation: Vec3::new(0.3, -0.1, 0.2),
        rotation: Quat::from_rotation_x(-1.2),
        scale: Vec3::splat(0.01),
    };
    let mut app = app_of(RhexisPlugin { space, ..plugin() }, DT as u64);
    let cone = generate::disc(3.0, 60).unwrap();
    // The disc's upper side, and a tip below it that closes the solid.
    let (mut places, mut triangles) = (cone.positions.clone(), cone.triangles.clone());
    let tip = places.len() as u32;
    places.push(Double::NEG_Z * 4.0);
    let edges: Vec<[u32; 2]> = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
    let rim = edges.iter().filter(|[a, b]| !edges.contains(&[*b, *a]));
    triangles.extend(rim.map(|&[a, b]| [b, a, tip]));
    let (hull, middle) = Hull::new(places, triangles).unwrap();
    let (centre, ends) = (Double::new(3.0, -1.0, 2.0), [Double::new(1.0, 2.0, 3.0), Double::new(4.0, -1.0, 2.0)]);
    let (half, axes) = (Double::new(1.0, 2.0, 0.5), axes());
    let shapes = [
        Shape::Plane { point: centre, normal: axes * Double::Z },
        ball(centre),
        Shape::Ellipsoid { centre, half_axes: half, axes },
        Shape::Capsule { ends, radius: 0.7 },
        Shape::Box { centre, half, axes },
        Shape::Cylinder { ends, radius: 0.7 },
        Shape::Mesh { hull: Arc::new(hull), centre: middle + centre, axes },
    ];
    let all: Vec<(ObstacleId, Shape)> = shapes.map(|shape| (add(&mut app, Solid::new(shape.clone())), shape)).into();
    let list = show_all(&mut app);
    app.update();
    for (obstacle, shape) in all {
        let off = off(&mut app, obstacle, &shape);
        assert!(off < 1e-4, "{shape:?}: {off} mm");
    }
    let dressed: Vec<Entity> = shown(&mut app).into_iter().map(|(entity, _)| entity).collect();
    assert_eq!(dressed.len(), 7);
    for entity in dressed {
        assert_eq!(app.world().get::<Steel>(entity), Some(&Steel));
        assert_eq!(app.world().get::<ShownObstacle>(entity).unwrap().list(), list);
    }
    assert_eq!(messages::<RhexisError>(&mut app), []);
}

#[test]
fn obstacles_that_move_are_followed_in_the_frame_of_the_step() {
    let mut app = app();
    let path = Path { points: vec![(0.0, Double::ZERO), (100.0, Double::X * 10.0)] };
    let on_path = add(&mut app, Solid::new(ball(Double::ZERO)).path(path));
    let falling = Rigid {
        acceleration: Double::NEG_Z * 9.81e-3,
        spin: Double::X * 0.01,
        ..Rigid::of(&ball(Double::ZERO), 1.0).unwrap()
    };
    let cube = Shape::Box { centre: Double::Y * 20.0, half: Double::ONE, axes: DMat3::IDENTITY };
    let rigid = add(&mut app, Solid::new(cube.clone()).rigid(falling));
    let led = add(&mut app, Solid::new(ball(Double::NEG_Y * 20.0)));
    show_all(&mut app);
    app.update();
    for frame in 1..=5 {
        let place = Double::NEG_Y * 20.0 + Double::Z * 0.3 * f64::from(frame);
        engine(&mut app).simulation_mut().move_obstacle(led, ball(place)).unwrap();
        app.update();
        for obstacle in [on_path, rigid, led] {
            let shape = shape_now(&mut app, obstacle);
            let off = off(&mut app, obstacle, &shape);
            assert!(off < 1e-5, "frame {frame}, {shape:?}: {off} mm");
        }
    }
    assert!(shape_now(&mut app, on_path).anchor().distance(Double::X * 5.0) < 1e-12);
    let Shape::Box { centre, axes, .. } = shape_now(&mut app, rigid) else { panic!("a box") };
    assert!(centre.z < -1.0 && axes.y_axis.z > 0.3, "{centre} {axes}");
}

#[test]
fn between_steps_they_are_shown_between_the_places_of_both() {
    let mut app = app_of(RhexisPlugin { is_interpolated: true, ..plugin() }, DT as u64);
    let path = Path { points: vec![(0.0, Double::ZERO), (100.0, Double::X * 10.0)] };
    let obstacle = add(&mut app, Solid::new(ball(Double::ZERO)).path(path));
    let led = add(&mut app, Solid::new(ball(Double::Y * 9.0)));
    show_all(&mut app);
    app.update();
    app.update();
    app.world_mut().insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_micros(2500)));
    let places: Vec<f64> = (0..4)
        .map(|frame| {
            if frame == 0 {
                engine(&mut app).simulation_mut().move_obstacle(led, ball(Double::Y * 10.0)).unwrap();
            }
            app.update();
            // One that was sent on its way is not there before the step.
            assert!(off(&mut app, led, &ball(Double::Y * 9.0)) < 1e-5, "frame {frame}");
            let x = (0..=400)
                .map(|i| f64::from(i) * 0.0125)
                .find(|&x| off(&mut app, obstacle, &ball(Double::X * x)) < 1e-5);
            x.expect("on the path")
        })
        .collect();
    assert_eq!(places, [0.25, 0.5, 0.75, 1.0]);
    app.update();
    assert!(off(&mut app, led, &ball(Double::Y * 9.25)) < 1e-5);
}

#[test]
fn they_come_and_go_with_the_engines() {
    let mut app = app();
    let list = show_all(&mut app);
    app.update();
    assert_eq!(shown(&mut app), []);
    let first = add(&mut app, Solid::new(ball(Double::ZERO)));
    let second = add(&mut app, Solid::new(ball(Double::X * 9.0)));
    app.update();
    let there = shown(&mut app);
    assert_eq!(there.len(), 2);
    let handle = |app: &App, entity: Entity| app.world().get::<Mesh3d>(entity).unwrap().0.clone();
    assert_eq!(handle(&app, there[0].0), handle(&app, there[1].0), "balls share a mesh");
    engine(&mut app).simulation_mut().despawn(first).unwrap();
    app.update();
    assert_eq!(shown(&mut app).iter().map(|(_, obstacle)| *obstacle).collect::<Vec<_>>(), [second]);
    // Another shape in its place has another mesh.
    let cylinder = Shape::Cylinder { ends: [Double::ZERO, Double::Z], radius: 1.0 };
    engine(&mut app).simulation_mut().set(second, Obstacle { shape: cylinder.clone() }).unwrap();
    app.update();
    assert!(off(&mut app, second, &cylinder) < 1e-5);
    app.world_mut().despawn(list);
    app.update();
    assert_eq!(shown(&mut app), []);
    assert_eq!(engine(&mut app).simulation().obstacles(), [second]);
    assert_eq!(messages::<RhexisError>(&mut app), []);
}

#[test]
fn while_paused_they_go_back_with_a_snapshot() {
    let mut app = app();
    let path = Path { points: vec![(0.0, Double::ZERO), (100.0, Double::X * 10.0)] };
    let obstacle = add(&mut app, Solid::new(ball(Double::ZERO)).path(path));
    show_all(&mut app);
    app.update();
    let before = engine(&mut app).simulation().snapshot();
    (0..5).for_each(|_| app.update());
    assert!(off(&mut app, obstacle, &ball(Double::X * 5.0)) < 1e-5);
    app.world_mut().resource_mut::<Time<Virtual>>().pause();
    engine(&mut app).simulation_mut().restore(&before).unwrap();
    app.update();
    let then = engine(&mut app).simulation().obstacles();
    assert!(off(&mut app, then[0], &ball(Double::ZERO)) < 1e-5);
}

#[test]
fn planes_of_no_size_are_refused_in_words() {
    let mut app = app();
    add(&mut app, Solid::new(Shape::Plane { point: Double::ZERO, normal: Double::Z }));
    let list = app.world_mut().spawn(ShownObstacles::with(Steel).plane_side(f64::NAN)).id();
    app.update();
    app.update();
    let told = messages::<RhexisError>(&mut app);
    assert_eq!(told.len(), 1);
    let expected = format!(
        "entity {list}: no obstacles are shown, as NaN mm is no side of a square: give a positive finite number"
    );
    assert_eq!(told[0].to_string(), expected);
    assert!(shown(&mut app).is_empty() && app.world().get::<ShownObstacles>(list).is_none());
}

#[test]
fn showing_them_leaves_the_bits_alone() {
    let hash = |is_shown: bool| {
        let mut app = app();
        spawn(&mut app, Tissue::new(sheet("sheet").with(Contact::default())));
        let up = Path { points: vec![(0.0, Double::ZERO), (300.0, Double::Z * 3.0)] };
        add(&mut app, Solid::new(ball(Double::new(10.0, 10.0, -2.5))).path(up));
        if is_shown {
            show_all(&mut app);
        }
        (0..20).for_each(|_| app.update());
        engine(&mut app).simulation().hash().to_string()
    };
    assert_eq!(hash(true), hash(false));
}

#[test]
fn a_host_that_steps_the_world_itself_sees_it_as_it_is() {
    let mut app = app();
    app.configure_sets(PostUpdate, RhexisSystems::Step.run_if(|| false));
    app.add_systems(Update, |mut world: ResMut<RhexisWorld>| -> Result {
        world.simulation_mut().step(DT)?;
        Ok(())
    });
    let up = Path { points: vec![(0.0, Double::ZERO), (300.0, Double::Z * 3.0)] };
    let obstacle = add(&mut app, Solid::new(ball(Double::new(10.0, 10.0, -2.5))).path(up));
    let (tissue, _) = spawn(&mut app, Tissue::new(sheet("sheet").with(Contact::default())));
    show_all(&mut app);
    for _ in 0..5 {
        app.update();
        assert_shows(&mut app, tissue);
        let shape = shape_now(&mut app, obstacle);
        assert!(off(&mut app, obstacle, &shape) < 1e-5);
    }
    assert_eq!(engine(&mut app).simulation().time(), 6.0 * DT);
}

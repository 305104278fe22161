//! Lines for what cannot be seen.

use crate::common::*;
use bevy::gizmos::{GizmoAsset, GizmoHandles, GizmoPlugin};
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_rhexis::rhexis::components::{Contact, Path, Shape};
use bevy_rhexis::rhexis::prelude::{DVec3, Damping, Material, Membrane, Solid, generate};
use bevy_rhexis::*;
use std::any::TypeId;
use std::time::Duration;

fn app_with_gizmos() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, AssetPlugin::default(), bevy::mesh::MeshPlugin));
    app.add_plugins((GizmoPlugin, plugin()));
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(10)));
    app.finish();
    app.cleanup();
    app
}

fn torn() -> (App, Entity, Entity) {
    let mut app = app_with_gizmos();
    let (tissue, body) = spawn(&mut app, Tissue::new(sheet("sheet")));
    notch(&mut app, body);
    let hand = hand(&mut app, tissue);
    draw(&mut app, hand, 30);
    (app, tissue, hand)
}

#[test]
fn the_material_force_points_from_the_tip_into_the_tissue() {
    let (mut app, tissue, _) = torn();
    let body = body(&app, tissue);
    let mut world = engine(&mut app);
    let arrows = material_forces(world.simulation_mut(), body, 2.0).unwrap();
    let tips = world.simulation().tips(body).unwrap();
    let force = world.simulation().material_forces(body).unwrap()[0].force.length();
    assert_eq!((arrows.len(), tips.len()), (1, 1));
    let [from, to] = arrows[0];
    assert_eq!(from, tips[0].position);
    assert!(force > 0.0 && ((to - from).length() - 2.0 * force).abs() < 1e-9 * force, "{}", (to - from).length());
    assert!((to - from).y < 0.0, "{}", to - from);
}

#[test]
fn the_lines_asked_for_are_drawn() {
    let (mut app, _, hand) = torn();
    assert_eq!(drawn(&mut app), 0, "none by default");
    let triangles = app.world().resource::<Assets<Mesh>>().iter().next().unwrap().1.indices().unwrap().len() / 3;
    *app.world_mut().resource_mut::<RhexisGizmos>() = RhexisGizmos { fibres: true, ..RhexisGizmos::default() };
    app.world_mut().resource_mut::<Time<Virtual>>().pause();
    app.update();
    assert_eq!(drawn(&mut app), 2 * triangles);
    let all = RhexisGizmos {
        fibres: true,
        stress: Some(1.0),
        tips: true,
        material_force: Some(1.0),
        grips: true,
        contacts: true,
        forces: Some(1.0),
    };
    *app.world_mut().resource_mut::<RhexisGizmos>() = all;
    app.update();
    assert!(drawn(&mut app) > 6 * triangles);
    app.world_mut().despawn(hand);
}

#[test]
fn forces_of_obstacles_and_tools_are_arrows_of_their_length() {
    let mut app = app_with_gizmos();
    let free = Membrane::new("sheet", generate::grid(SIDE, SIDE, 10, 10).unwrap(), Material::allard_2009());
    let (tissue, body) = spawn(&mut app, Tissue::new(free.with(Damping { time: 1.0 }).with(Contact::default())));
    app.world_mut().spawn((Name::new("table"), Pins::of_rest(tissue, |p| p.x == 0.0)));
    let shape = Shape::Sphere { centre: DVec3::new(10.0, 10.0, -2.5), radius: 2.0 };
    let up = Path { points: vec![(0.0, DVec3::ZERO), (300.0, DVec3::Z * 3.0)] };
    engine(&mut app).simulation_mut().spawn_obstacle(Solid::new(shape).path(up)).unwrap();
    let hand = hand(&mut app, tissue);
    (0..30).for_each(|_| app.update());
    *app.world_mut().resource_mut::<RhexisGizmos>() = RhexisGizmos { forces: Some(20.0), ..RhexisGizmos::default() };
    app.world_mut().resource_mut::<Time<Virtual>>().pause();
    app.update();
    let pins = app.world().get::<PinsState>(hand).unwrap().force;
    let (ball, at) = {
        let world = engine(&mut app);
        (world.simulation().contact_forces(body).unwrap()[0].1, DVec3::new(10.0, 10.0, 0.5))
    };
    assert!(ball.z > 1e-3 && pins.z < -1e-3, "{ball} {pins}");
    let ends = ends(&mut app);
    for (place, force) in [(at, ball), (DVec3::ZERO, pins)] {
        let tip = (place + force * 20.0).as_vec3().to_array();
        assert!(ends.iter().any(|end| end.distance(Vec3::from_array(tip)) < 1e-5), "{tip:?} is not in {ends:?}");
    }
}

/// Number of ends of lines that were drawn in the last frame.
fn drawn(app: &mut App) -> usize {
    ends(app).len()
}

/// Ends of the lines that were drawn in the last frame.
fn ends(app: &mut App) -> Vec<Vec3> {
    let handles = app.world().resource::<GizmoHandles>().handles();
    let group = handles.get(&TypeId::of::<RhexisGizmoGroup>()).expect("the plugin's group");
    let asset = group.as_ref().and_then(|handle| app.world().resource::<Assets<GizmoAsset>>().get(handle));
    asset.map_or_else(Vec::new, |asset| asset.list_positions.clone())
}

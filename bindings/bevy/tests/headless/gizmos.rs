//! Lines for what cannot be seen.

use crate::common::*;
use bevy::gizmos::{GizmoAsset, GizmoHandles, GizmoPlugin};
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
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
    };
    *app.world_mut().resource_mut::<RhexisGizmos>() = all;
    app.update();
    assert!(drawn(&mut app) > 6 * triangles);
    app.world_mut().despawn(hand);
}

/// Number of ends of lines that were drawn in the last frame.
fn drawn(app: &mut App) -> usize {
    let handles = app.world().resource::<GizmoHandles>().handles();
    let group = handles.get(&TypeId::of::<RhexisGizmoGroup>()).expect("the plugin's group");
    let asset = group.as_ref().and_then(|handle| app.world().resource::<Assets<GizmoAsset>>().get(handle));
    asset.map_or(0, |asset| asset.list_positions.len())
}

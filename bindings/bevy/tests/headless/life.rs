//! Tissues that come and go, on either side.

use crate::common::*;
use bevy::prelude::*;
use bevy_rhexis::rhexis::prelude::*;
use bevy_rhexis::*;

#[test]
fn a_despawned_entity_takes_its_body_along() {
    let mut app = app();
    let (tissue, body) = spawn(&mut app, Tissue::new(sheet("sheet")));
    let forceps = forceps(&mut app, bevy::math::Vec3::new(5.0, 5.0, 0.0));
    close(&mut app, forceps, true);
    app.update();
    let handle = app.world().get::<Mesh3d>(tissue).unwrap().0.id();
    app.world_mut().despawn(tissue);
    assert!(!engine(&mut app).simulation().world().contains(body.entity()));
    (0..3).for_each(|_| app.update());
    assert!(engine(&mut app).simulation().bodies().is_empty());
    assert!(app.world().resource::<Assets<Mesh>>().get(handle).is_none(), "its mesh is freed");
    // The forceps have lost what they held.
    assert!(!app.world().get::<Forceps>(forceps).unwrap().is_closed);
    assert_eq!(messages::<TissueGone>(&mut app), []);
    // Forceps that are despawned are out of the engine, too.
    assert_eq!(engine(&mut app).simulation().tools().len(), 1);
    app.world_mut().despawn(forceps);
    assert!(engine(&mut app).simulation().tools().is_empty());
}

#[test]
fn a_body_that_the_engine_has_lost_takes_its_entity_along() {
    let mut app = app();
    let (tissue, body) = spawn(&mut app, Tissue::new(sheet("sheet")));
    let (other, _) = spawn(&mut app, Tissue::new(sheet("other")));
    engine(&mut app).simulation_mut().despawn(body).unwrap();
    app.update();
    assert_eq!(messages::<TissueGone>(&mut app), [TissueGone { tissue, body }]);
    assert!(app.world().get_entity(tissue).is_err());
    assert_shows(&mut app, other);
}

#[test]
fn a_tissue_taken_off_leaves_an_entity_without_body() {
    let mut app = app();
    let (tissue, body) = spawn(&mut app, Tissue::new(sheet("sheet")));
    app.world_mut().entity_mut(tissue).remove::<Tissue>();
    app.update();
    assert!(!engine(&mut app).simulation().world().contains(body.entity()));
    let entity = app.world().entity(tissue);
    assert!(!entity.contains::<TissueBody>() && !entity.contains::<Mesh3d>());
}

#[test]
fn a_body_that_is_refused_is_told() {
    let mut app = app();
    let mesh = TriangleMesh { positions: vec![DVec3::ZERO; 3], triangles: vec![[0, 1, 2]], ..TriangleMesh::default() };
    let bad = Membrane::new("bad", mesh, Material::allard_2009());
    let tissue = app.world_mut().spawn((Tissue::new(bad), Name::new("patch"))).id();
    app.update();
    let told = messages::<RhexisError>(&mut app);
    assert_eq!(told.len(), 1);
    let text = told[0].to_string();
    assert!(text.starts_with(&format!("entity {tissue} (`patch`): body `bad`: triangle 0 is degenerate")), "{text}");
    assert!(app.world().get::<TissueBody>(tissue).is_none());
    app.update();
    assert_eq!(messages::<RhexisError>(&mut app), []);
    // The same body twice, and one that is not there.
    let (_, body) = spawn(&mut app, Tissue::new(sheet("sheet")));
    engine(&mut app).simulation_mut().despawn(body).unwrap();
    app.update();
    app.world_mut().spawn(Tissue::of_body(body));
    app.update();
    assert_eq!(messages::<RhexisError>(&mut app).len(), 1);
}

#[test]
fn several_bodies_each_have_their_mesh() {
    let mut app = app();
    let tissues = ["a", "b", "c"].map(|name| app.world_mut().spawn(Tissue::new(sheet(name))).id());
    app.update();
    let bodies = tissues.map(|tissue| body(&app, tissue));
    assert_eq!(engine(&mut app).simulation().bodies(), bodies);
    notch(&mut app, bodies[1]);
    let hand = hand(&mut app, tissues[1]);
    draw(&mut app, hand, 20);
    for tissue in tissues {
        assert_shows(&mut app, tissue);
    }
    let [a, b, c] = tissues.map(|tissue| positions(&app, tissue));
    assert!(a == c && a != b);
}

#[test]
fn bodies_of_the_engine_are_shown_and_a_snapshot_brings_them_back() {
    let mut app = app();
    let made = engine(&mut app).simulation_mut().spawn(sheet("sheet")).unwrap();
    let (tissue, body) = spawn(&mut app, Tissue::of_body(made));
    assert_eq!(body, made);
    let before = engine(&mut app).simulation_mut().snapshot();
    let shown = positions(&app, tissue);
    notch(&mut app, body);
    let hand = hand(&mut app, tissue);
    draw(&mut app, hand, 60);
    assert!(positions(&app, tissue).len() > shown.len());
    app.world_mut().despawn(hand);
    engine(&mut app).simulation_mut().restore(&before).unwrap();
    app.world_mut().resource_mut::<Time<Virtual>>().pause();
    app.update();
    assert_eq!(positions(&app, tissue), shown);
    assert_shows(&mut app, tissue);
    assert_eq!(messages::<RhexisError>(&mut app), []);
}

#[test]
fn what_cannot_be_is_told_without_a_panic() {
    let bad = Transform::from_xyz(f32::NAN, 0.0, 0.0);
    let mut app = app_of(RhexisPlugin { space: bad, ..plugin() }, 10);
    assert_eq!(messages::<RhexisError>(&mut app)[0].cause, Cause::BadSpace);
    spawn(&mut app, Tissue::new(sheet("sheet")));
    for plugin in [RhexisPlugin { dt: f64::NAN, ..plugin() }, RhexisPlugin { most_steps: 0, ..plugin() }] {
        let mut app = app_of(plugin, 10);
        assert_eq!(messages::<RhexisError>(&mut app).len(), 1);
        let tissue = app.world_mut().spawn(Tissue::new(sheet("sheet"))).id();
        forceps(&mut app, bevy::math::Vec3::ZERO);
        app.update();
        app.world_mut().despawn(tissue);
        app.update();
        assert!(!app.world().contains_resource::<RhexisWorld>());
    }
}

#[test]
fn without_meshes_bodies_are_stepped_all_the_same() {
    let mut app = App::new();
    app.add_plugins((bevy::app::TaskPoolPlugin::default(), bevy::time::TimePlugin, TransformPlugin, plugin()));
    let step = std::time::Duration::from_millis(10);
    app.insert_resource(bevy::time::TimeUpdateStrategy::ManualDuration(step));
    let (_, body) = spawn(&mut app, Tissue::new(sheet("sheet")));
    (0..3).for_each(|_| app.update());
    assert!(engine(&mut app).simulation().time() >= 30.0);
    assert_eq!(engine(&mut app).simulation().bodies(), [body]);
}

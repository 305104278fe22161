//! Meshes that follow their bodies by what has changed.

use crate::common::*;
use bevy::mesh::VertexAttributeValues;
use bevy::prelude::*;
use bevy_rhexis::rhexis::components::{Attributes, Channel, Sleeping};
use bevy_rhexis::rhexis::prelude::{DVec3, Material, Membrane, Tearing, generate};
use bevy_rhexis::*;

#[test]
fn without_a_tear_positions_and_normals_alone_are_written() {
    let mut app = app();
    let (tissue, body) = spawn(&mut app, Tissue::new(sheet("sheet")));
    notch(&mut app, body);
    let hand = hand(&mut app, tissue);
    draw(&mut app, hand, 1);
    assert_shows(&mut app, tissue);
    let before = updates(&app, tissue);
    let vertices = positions(&app, tissue).len() as u64;
    draw(&mut app, hand, 4);
    assert_shows(&mut app, tissue);
    let after = updates(&app, tissue);
    assert_eq!(after.frames, before.frames + 4);
    assert_eq!(after.positions, before.positions + 4 * vertices);
    assert_eq!(after.normals, before.normals + 4 * vertices);
    assert_eq!((after.triangles, after.attributes), (before.triangles, before.attributes));
}

#[test]
fn a_tear_writes_the_triangles_that_it_changes() {
    let mut app = app();
    let (tissue, body) = spawn(&mut app, Tissue::new(sheet("sheet")).without_normals());
    notch(&mut app, body);
    let hand = hand(&mut app, tissue);
    app.update();
    let (before, whole) = (updates(&app, tissue), indices(&app, tissue).len() as u64 / 3);
    let mut torn = 0;
    for _ in 0..160 {
        let rows = indices(&app, tissue);
        draw(&mut app, hand, 1);
        assert_shows(&mut app, tissue);
        torn += u64::from(rows != indices(&app, tissue));
    }
    let after = updates(&app, tissue);
    let written = after.triangles - before.triangles;
    println!("{torn} tears wrote {written} of {whole} triangles each time a whole mesh would take");
    assert!(torn > 5, "{torn}");
    assert!(written > 0 && written < torn * whole / 4, "{written} of {whole} in {torn} frames");
    assert_eq!(after.normals, 0);
    assert!(mesh(&app, tissue).attribute(Mesh::ATTRIBUTE_NORMAL).is_none());
}

#[test]
fn of_20_000_triangles_a_tear_writes_a_handful() {
    let mut app = app();
    let mesh = generate::grid(100.0, 100.0, 100, 100).unwrap();
    let membrane = Membrane::new("sheet", mesh, Material::allard_2009()).planar().with(Tearing::default());
    let (tissue, body) = spawn(&mut app, Tissue::new(membrane));
    let count = |app: &App| (updates(app, tissue), positions(app, tissue).len() as u64);
    let (whole, vertices) = count(&app);
    assert_eq!((whole.positions, whole.normals, whole.triangles), (10_201, 10_201, 20_000));
    app.update();
    let (still, _) = count(&app);
    assert_eq!((still.positions, still.triangles), (whole.positions + vertices, whole.triangles));
    let line = [DVec3::new(50.0, 100.0, 0.0), DVec3::new(50.0, 90.0, 0.0)];
    engine(&mut app).simulation_mut().cut(body, &line).unwrap();
    app.update();
    let (torn, vertices) = count(&app);
    let written = torn.triangles - still.triangles;
    let bytes = |vertices: u64, triangles: u64| 24 * vertices + 12 * triangles;
    println!(
        "20,000 triangles: whole {} bytes, without a tear {} bytes, with a cut of 10 mm {} bytes ({written} triangles)",
        bytes(10_201, 20_000),
        bytes(vertices, 0),
        bytes(vertices, written),
    );
    assert_eq!(torn.positions, still.positions + vertices);
    assert!(written > 0 && written < 200, "{written}");
    assert_shows(&mut app, tissue);
}

#[test]
fn what_sleeps_and_what_is_paused_is_left_alone() {
    let mut app = app();
    let (tissue, _) = spawn(&mut app, Tissue::new(sheet("sheet").with(Sleeping::default())));
    (0..200).for_each(|_| app.update());
    let before = updates(&app, tissue);
    (0..20).for_each(|_| app.update());
    assert_eq!(updates(&app, tissue).frames, before.frames, "it sleeps");

    let mut app = crate::common::app();
    let (tissue, _) = spawn(&mut app, Tissue::new(sheet("sheet")));
    app.world_mut().resource_mut::<Time<Virtual>>().pause();
    app.update();
    let (before, time) = (updates(&app, tissue), engine(&mut app).simulation().time());
    (0..5).for_each(|_| app.update());
    assert_eq!(updates(&app, tissue).frames, before.frames, "it is paused");
    assert_eq!(engine(&mut app).simulation().time(), time);
}

#[test]
fn texture_coordinates_and_colours_follow_a_cut() {
    let mut app = app();
    let plain = sheet("sheet");
    let values = plain.mesh().positions.iter().flat_map(|p| {
        let (u, v) = (p.x / SIDE, p.y / SIDE);
        [u, v, u, v, 0.5, 1.0]
    });
    let attributes = Attributes {
        stride: 6,
        values: values.collect(),
        channels: vec![(Channel::TextureCoordinates, 0), (Channel::Colour, 2)],
    };
    let (tissue, body) = spawn(&mut app, Tissue::new(plain.with(attributes)));
    let before = updates(&app, tissue);
    notch(&mut app, body);
    app.update();
    let written = updates(&app, tissue).attributes - before.attributes;
    let Some(VertexAttributeValues::Float32x2(uv)) = mesh(&app, tissue).attribute(Mesh::ATTRIBUTE_UV_0).cloned() else {
        panic!("texture coordinates");
    };
    let Some(VertexAttributeValues::Float32x4(colours)) = mesh(&app, tissue).attribute(Mesh::ATTRIBUTE_COLOR).cloned()
    else {
        panic!("colours");
    };
    assert!(written > 0 && written < uv.len() as u64, "{written} of {}", uv.len());
    let mut world = engine(&mut app);
    let view = world.simulation_mut().view(body).unwrap();
    assert_eq!((uv.len(), colours.len()), (view.positions.len(), view.positions.len()));
    for ((uv, colour), rest) in uv.iter().zip(&colours).zip(view.rest_positions) {
        let expected = [(rest.x / SIDE) as f32, (1.0 - rest.y / SIDE) as f32];
        assert!((uv[0] - expected[0]).abs() < 1e-6 && (uv[1] - expected[1]).abs() < 1e-6, "{uv:?} {expected:?}");
        assert!((colour[0] - expected[0]).abs() < 1e-6 && colour[3] == 1.0);
    }
}

#[test]
fn another_mesh_in_its_place_is_written_whole() {
    let mut app = app();
    let (tissue, body) = spawn(&mut app, Tissue::new(sheet("sheet")));
    let other = app.world_mut().resource_mut::<Assets<Mesh>>().add(Cuboid::default());
    app.world_mut().get_mut::<Mesh3d>(tissue).unwrap().0 = other.clone();
    app.update();
    assert_shows(&mut app, tissue);
    // An asset that is away for a while misses nothing.
    app.world_mut().resource_mut::<Assets<Mesh>>().remove(&other);
    notch(&mut app, body);
    app.update();
    app.world_mut().resource_mut::<Assets<Mesh>>().insert(&other, Cuboid::default().into()).unwrap();
    app.update();
    assert_shows(&mut app, tissue);
}

#[test]
fn a_mesh_whose_data_was_taken_is_told_once() {
    let mut app = app();
    let (tissue, _) = spawn(&mut app, Tissue::new(sheet("sheet")));
    let handle = app.world().get::<Mesh3d>(tissue).unwrap().0.clone();
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    let _ = meshes.get_mut(&handle).unwrap().take_gpu_data().unwrap();
    let mut told = Vec::new();
    for _ in 0..5 {
        app.update();
        told.extend(messages::<RhexisError>(&mut app));
    }
    assert_eq!(told.len(), 1, "{told:?}");
    assert_eq!((told[0].entity, &told[0].cause), (Some(tissue), &Cause::MeshTaken));
}

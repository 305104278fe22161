//! An app without window and graphics, and a sheet that tears.

use bevy::app::{App, ScheduleRunnerPlugin, TaskPoolPlugin};
use bevy::asset::AssetPlugin;
use bevy::diagnostic::FrameCountPlugin;
use bevy::mesh::{Indices, MeshPlugin, VertexAttributeValues};
use bevy::prelude::*;
use bevy::time::{TimePlugin, TimeUpdateStrategy};
use bevy_rhexis::rhexis::prelude::{
    Attached, Curve, DVec3, Damping, Fibres, Hold, Jaws, Material, Membrane, Slip, Tearing, generate,
};
use bevy_rhexis::rhexis::storage::BodyId;
use bevy_rhexis::*;
use std::time::Duration;

/// Length of a step [ms].
pub const DT: f64 = 10.0;

/// Side of the sheet [mm].
pub const SIDE: f64 = 20.0;

/// An app whose frames are `frame` ms long.
pub fn app_of(plugin: RhexisPlugin, frame: u64) -> App {
    let mut app = App::new();
    app.add_plugins((TaskPoolPlugin::default(), FrameCountPlugin, TimePlugin, ScheduleRunnerPlugin::default()));
    app.add_plugins((TransformPlugin, AssetPlugin::default(), MeshPlugin, plugin));
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(frame)));
    app.finish();
    app.cleanup();
    app
}

/// An app with a step in each frame, shown as the step leaves it.
pub fn app() -> App {
    app_of(plugin(), DT as u64)
}

pub fn plugin() -> RhexisPlugin {
    RhexisPlugin { dt: DT, is_interpolated: false, ..RhexisPlugin::default() }
}

/// A square in the plane z = 0, held along x = 0, whose fibres go along y.
pub fn sheet(name: &str) -> Membrane {
    let mesh = generate::grid(SIDE, SIDE, 16, 14).unwrap();
    let mut sheet = Membrane::new(name, mesh, Material::allard_2009()).planar().fibres(Fibres::at_degrees(90.0));
    sheet = sheet.with(Tearing::default()).with(Damping { time: 0.1 });
    let members = Attached::new(sheet.select(|p| p.x == 0.0).into_iter().map(|vertex| (vertex, DVec3::ZERO)));
    sheet.hold(Hold { name: "table".into(), members, axes: [true; 3], curve: Curve::constant(1.0) })
}

/// Spawns a tissue and has the engine take it.
pub fn spawn(app: &mut App, tissue: Tissue) -> (Entity, BodyId) {
    let entity = app.world_mut().spawn((tissue, Name::new("sheet"))).id();
    app.update();
    (entity, body(app, entity))
}

pub fn body(app: &App, tissue: Entity) -> BodyId {
    app.world().get::<TissueBody>(tissue).expect("the tissue was taken").body()
}

/// Cuts a notch down from the upper side.
pub fn notch(app: &mut App, body: BodyId) {
    let line = [DVec3::new(SIDE / 2.0, SIDE, 0.0), DVec3::new(SIDE / 2.0, SIDE - 4.0, 0.0)];
    engine(app).simulation_mut().cut(body, &line).unwrap();
}

pub fn engine(app: &mut App) -> Mut<'_, RhexisWorld> {
    app.world_mut().resource_mut::<RhexisWorld>()
}

/// Pins along x = `SIDE`, at the origin of the world.
pub fn hand(app: &mut App, tissue: Entity) -> Entity {
    app.world_mut().spawn((Name::new("hand"), Pins::of_rest(tissue, |p| p.x == SIDE))).id()
}

pub fn jaws() -> Jaws {
    Jaws { radius: 1.5, stiffness: Some(1.0), force_limit: None, slip: Slip::LetGo }
}

/// Open forceps at a place [mm].
pub fn forceps(app: &mut App, place: Vec3) -> Entity {
    app.world_mut().spawn((Name::new("forceps"), Forceps::new(jaws(), 1.0), Transform::from_translation(place))).id()
}

pub fn close(app: &mut App, forceps: Entity, is_closed: bool) {
    app.world_mut().get_mut::<Forceps>(forceps).unwrap().is_closed = is_closed;
}

pub fn move_to(app: &mut App, entity: Entity, place: Vec3) {
    app.world_mut().get_mut::<Transform>(entity).unwrap().translation = place;
}

/// Draws an entity by frames of 0.05 mm along x.
pub fn draw(app: &mut App, entity: Entity, frames: u32) {
    for _ in 0..frames {
        app.world_mut().get_mut::<Transform>(entity).unwrap().translation.x += 0.05;
        app.update();
    }
}

/// The messages since the last call, as far as Bevy keeps them: two frames.
pub fn messages<M: Message>(app: &mut App) -> Vec<M> {
    app.world_mut().resource_mut::<Messages<M>>().drain().collect()
}

pub fn mesh(app: &App, tissue: Entity) -> &Mesh {
    let handle = app.world().get::<Mesh3d>(tissue).expect("a mesh");
    app.world().resource::<Assets<Mesh>>().get(&handle.0).expect("its asset")
}

pub fn positions(app: &App, tissue: Entity) -> Vec<[f32; 3]> {
    match mesh(app, tissue).attribute(Mesh::ATTRIBUTE_POSITION) {
        Some(VertexAttributeValues::Float32x3(positions)) => positions.clone(),
        other => panic!("{other:?}"),
    }
}

pub fn indices(app: &App, tissue: Entity) -> Vec<u32> {
    match mesh(app, tissue).indices() {
        Some(Indices::U32(indices)) => indices.clone(),
        other => panic!("{other:?}"),
    }
}

/// Asserts that the mesh shows the body as the last step has left it.
pub fn assert_shows(app: &mut App, tissue: Entity) {
    let of_body = body(app, tissue);
    let (shown, rows) = (positions(app, tissue), indices(app, tissue));
    let mut world = engine(app);
    let view = world.simulation_mut().view(of_body).unwrap();
    let mut expected = Vec::new();
    view.positions_f32(&mut expected);
    assert_eq!(shown, expected);
    assert_eq!(rows, view.triangles.as_flattened());
}

pub fn updates(app: &App, tissue: Entity) -> MeshUpdates {
    app.world().get::<MeshUpdates>(tissue).unwrap().clone()
}

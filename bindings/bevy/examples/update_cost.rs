//! What the mesh of 20,000 triangles costs to keep in step, without and with a tear: `cargo run --release --example update_cost`.

use bevy::app::{App, TaskPoolPlugin};
use bevy::asset::AssetPlugin;
use bevy::mesh::MeshPlugin;
use bevy::prelude::*;
use bevy::time::{TimePlugin, TimeUpdateStrategy};
use bevy_rhexis::rhexis::prelude::{Accuracy, DVec3, Material, Membrane, Settings, Tearing, generate};
use bevy_rhexis::{MeshUpdates, RhexisPlugin, RhexisSystems, RhexisWorld, Tissue, TissueBody};
use std::time::{Duration, Instant};

/// Cuts, one in each frame.
const CUTS: usize = 50;

/// When the meshes began to be written.
#[derive(Resource)]
struct Begin(Instant);

/// Times [ms] of the frames.
#[derive(Resource, Default)]
struct Times(Vec<f64>);

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for has_normals in [true, false] {
        let mut app = App::new();
        app.add_plugins((TaskPoolPlugin::default(), TimePlugin, TransformPlugin, AssetPlugin::default(), MeshPlugin));
        app.add_plugins(RhexisPlugin {
            settings: Settings::new(Accuracy::Game),
            dt: 10.0,
            is_interpolated: false,
            ..default()
        });
        app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(10)));
        app.insert_resource(Begin(Instant::now())).init_resource::<Times>();
        app.add_systems(PostUpdate, begin.after(RhexisSystems::Step).before(RhexisSystems::Show));
        app.add_systems(PostUpdate, end.after(RhexisSystems::Show));
        app.finish();
        app.cleanup();
        let sheet = Membrane::new("sheet", generate::grid(100.0, 100.0, 100, 100)?, Material::allard_2009()).planar();
        let tissue = Tissue::new(sheet.with(Tearing::default()));
        let tissue = app.world_mut().spawn(if has_normals { tissue } else { tissue.without_normals() }).id();
        app.update();
        let body = app.world().get::<TissueBody>(tissue).ok_or("the tissue was refused")?.body();
        let without = run(&mut app, |_, _| Ok(()))?;
        let before = counted(&app, tissue)?;
        let with = run(&mut app, |world, cut| {
            // A millimetre further each time, as a tear goes.
            let (from, to) = (50.0 - cut as f64, 49.0 - cut as f64);
            world
                .simulation_mut()
                .cut(body, &[DVec3::new(30.5, from + 50.0, 0.0), DVec3::new(30.5, to + 50.0, 0.0)])?;
            Ok(())
        })?;
        let written = (counted(&app, tissue)? - before) as f64 / CUTS as f64;
        let what = if has_normals { "positions and normals" } else { "positions" };
        println!(
            "{what}: {without:.3} ms without a tear, {with:.3} ms with one of 1 mm, {written:.0} triangles written"
        );
    }
    Ok(())
}

/// The median time [ms] in which a mesh is written.
fn run(
    app: &mut App,
    mut before: impl FnMut(&mut RhexisWorld, usize) -> Result<(), Box<dyn std::error::Error>>,
) -> Result<f64, Box<dyn std::error::Error>> {
    app.world_mut().resource_mut::<Times>().0.clear();
    for frame in 0..CUTS {
        before(&mut app.world_mut().resource_mut::<RhexisWorld>(), frame)?;
        app.update();
    }
    let mut times = std::mem::take(&mut app.world_mut().resource_mut::<Times>().0);
    times.sort_by(f64::total_cmp);
    Ok(times.get(times.len() / 2).copied().unwrap_or_default())
}

fn counted(app: &App, tissue: Entity) -> Result<u64, &'static str> {
    Ok(app.world().get::<MeshUpdates>(tissue).ok_or("the tissue has no mesh")?.triangles)
}

fn begin(mut begin: ResMut<Begin>) {
    begin.0 = Instant::now();
}

fn end(begin: Res<Begin>, mut times: ResMut<Times>) {
    times.0.push(begin.0.elapsed().as_secs_f64() * 1e3);
}

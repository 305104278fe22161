//! A sheet with a notch, torn by dragging its right side with the mouse: `cargo run --features trainer --example sheet`.

use bevy::prelude::*;
use bevy_rhexis::rhexis::prelude::{DVec3, Damping, Fibres, Material, Membrane, Tearing, generate};
use bevy_rhexis::{Pins, RhexisError, RhexisPlugin, RhexisWorld, Tissue, TissueBody, TissueEvent};

fn main() -> AppExit {
    App::new()
        .add_plugins((DefaultPlugins, RhexisPlugin::default()))
        .add_systems(Startup, spawn)
        .add_systems(Update, (notch, drag, tell))
        .run()
}

fn spawn(mut commands: Commands, mut materials: ResMut<Assets<StandardMaterial>>) -> Result {
    let mesh = generate::grid(30.0, 30.0, 30, 25)?;
    let sheet = Membrane::new("sheet", mesh, Material::allard_2009()).fibres(Fibres::at_degrees(75.0));
    let sheet = sheet.with(Tearing::default()).with(Damping { time: 0.1 });
    let skin = StandardMaterial { double_sided: true, cull_mode: None, ..Color::srgb(0.9, 0.6, 0.5).into() };
    let tissue = commands.spawn((Tissue::new(sheet), MeshMaterial3d(materials.add(skin)))).id();
    commands.spawn((Name::new("table"), Pins::of_rest(tissue, |p| p.x == 0.0)));
    commands.spawn((Name::new("hand"), Hand, Pins::of_rest(tissue, |p| p.x == 30.0)));
    commands.spawn((
        Camera3d::default(),
        Transform::from_xyz(18.0, 2.0, 45.0).looking_at(Vec3::new(18.0, 15.0, 0.0), Vec3::Y),
    ));
    commands
        .spawn((DirectionalLight::default(), Transform::from_xyz(10.0, 20.0, 30.0).looking_at(Vec3::ZERO, Vec3::Y)));
    Ok(())
}

/// What the mouse drags.
#[derive(Component)]
struct Hand;

/// A cut into the sheet, once the engine has it.
fn notch(bodies: Query<&TissueBody, Added<TissueBody>>, mut world: ResMut<RhexisWorld>) -> Result {
    for tissue in &bodies {
        let line = [DVec3::new(15.0, 30.0, 0.0), DVec3::new(15.0, 27.0, 0.0)];
        world.simulation_mut().cut(tissue.body(), &line)?;
    }
    Ok(())
}

fn drag(mut hand: Single<&mut Transform, With<Hand>>, cursor: Single<&Window>, time: Res<Time>) {
    let x = cursor.cursor_position().map_or(0.0, |place| 20.0 * place.x / cursor.width() - 10.0);
    let way = (x.clamp(0.0, 10.0) - hand.translation.x).clamp(-3.0 * time.delta_secs(), 3.0 * time.delta_secs());
    hand.translation.x += way;
}

fn tell(mut events: MessageReader<TissueEvent>, mut errors: MessageReader<RhexisError>) {
    events.read().for_each(|event| info!("{:?}", event.event.kind));
    errors.read().for_each(|error| error!("{error}"));
}

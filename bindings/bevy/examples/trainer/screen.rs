//! Measures and keys on the screen, and what the keys do.

use crate::play::course::Course;
use crate::play::{Capsule, Said};
use bevy::prelude::*;
use bevy_rhexis::rhexis::replay::Recording;
use bevy_rhexis::{ForcepsState, RhexisError, RhexisGizmos, RhexisWorld, TissueEvent};

/// Where a recording goes.
pub const RECORDING: &str = "trainer.recording";

const KEYS: &str = "drag: grip and tear   wheel: lift   arrows: turn the view   Space: pause   R: anew   Z: back a grasp\n\
                    F fibres   S stress   T tips   M material force   C circle   L: keep the recording   Esc: quit";

/// What is drawn beside the tissue, and from where.
#[derive(Resource)]
pub struct Shown {
    pub has_circle: bool,
    /// Angle about the eye's axis, and above its plane [rad].
    view: Vec2,
}

impl Default for Shown {
    fn default() -> Self {
        Self { has_circle: true, view: Vec2::new(0.0, 1.05) }
    }
}

/// The text of the measures.
#[derive(Component)]
pub struct Measures;

/// The text of what was said last.
#[derive(Component)]
pub struct LastSaid;

pub fn spawn(mut commands: Commands) {
    commands.init_resource::<Shown>();
    let font = |size: f32| TextFont { font_size: FontSize::Px(size), ..default() };
    let dark = BackgroundColor(Color::srgba(0.0, 0.0, 0.0, 0.55));
    let at = Node { position_type: PositionType::Absolute, padding: UiRect::all(px(8)), ..default() };
    commands.spawn((Measures, Text::default(), font(14.0), dark, Node { top: px(10), left: px(10), ..at.clone() }));
    commands.spawn((LastSaid, Text::default(), font(16.0), dark, Node { top: px(10), right: px(10), ..at.clone() }));
    commands.spawn((Text::new(KEYS), font(12.0), dark, Node { bottom: px(10), left: px(10), ..at }));
}

/// The text of the one entity that has a component.
type TextOf<'w, 's, C> = Single<'w, 's, &'static mut Text, With<C>>;

/// Writes the measures.
pub fn show(
    world: Res<RhexisWorld>,
    (capsule, course): (Res<Capsule>, Res<Course>),
    hand: Single<&ForcepsState>,
    (time, real): (Res<Time<Virtual>>, Res<Time<Real>>),
    mut said: ResMut<Said>,
    (mut events, mut errors): (MessageReader<TissueEvent>, MessageReader<RhexisError>),
    mut texts: ParamSet<(TextOf<Measures>, TextOf<LastSaid>)>,
) {
    use bevy_rhexis::rhexis::event::EventKind;
    for event in events.read() {
        match &event.event.kind {
            EventKind::FragmentFreed { .. } => said.0 = "A piece has come free.".to_owned(),
            EventKind::Slipped { is_open: true, .. } => said.0 = "The jaws have slipped.".to_owned(),
            EventKind::Ended { .. } => said.0 = "A tear has ended.".to_owned(),
            EventKind::StepFailed { .. } => said.0 = "A step was undone; the last good state stands.".to_owned(),
            _ => {}
        }
    }
    errors.read().for_each(|error| said.0 = error.to_string());
    let triangles = world.simulation().report().bodies.iter().map(|body| body.triangle_count).sum::<usize>();
    let state = if time.is_paused() { ", paused" } else { "" };
    let measures = format!(
        "{}\nnow           {:.1} mN, {}\nstep          {:.1} ms for {:.0} ms, {triangles} triangles\nframe         {:.1} ms, {:.1} s lost{state}",
        course.lines(&world, capsule.body),
        hand.force.length() * 1e3,
        if hand.tissue.is_some() { "gripped" } else { "open" },
        world.step_time().as_secs_f64() * 1e3,
        world.clock().dt(),
        real.delta_secs_f64() * 1e3,
        world.clock().lost() * 1e-3,
    );
    texts.p0().0 = measures;
    texts.p1().0.clone_from(&said.0);
}

/// What the keys do.
pub fn keys(
    keys: Res<ButtonInput<KeyCode>>,
    (mut world, mut said, mut shown): (ResMut<RhexisWorld>, ResMut<Said>, ResMut<Shown>),
    (mut gizmos, mut time): (ResMut<RhexisGizmos>, ResMut<Time<Virtual>>),
    mut exit: MessageWriter<AppExit>,
) {
    if keys.just_pressed(KeyCode::Space) {
        if time.is_paused() { time.unpause() } else { time.pause() }
    }
    if keys.just_pressed(KeyCode::KeyL) {
        said.0 = match keep(&mut world) {
            Ok((_, bytes)) => format!("{RECORDING}: {} kB; recorded anew from here.", bytes / 1000),
            Err(error) => error,
        };
    }
    gizmos.fibres ^= keys.just_pressed(KeyCode::KeyF);
    gizmos.tips ^= keys.just_pressed(KeyCode::KeyT);
    shown.has_circle ^= keys.just_pressed(KeyCode::KeyC);
    if keys.just_pressed(KeyCode::KeyS) {
        gizmos.stress = if gizmos.stress.is_some() { None } else { Some(2.0) };
    }
    if keys.just_pressed(KeyCode::KeyM) {
        gizmos.material_force = if gizmos.material_force.is_some() { None } else { Some(1.0) };
    }
    if keys.just_pressed(KeyCode::Escape) {
        exit.write(AppExit::Success);
    }
}

/// Writes what was recorded to a file and records anew; the recording, and its bytes.
pub fn keep(world: &mut RhexisWorld) -> Result<(Recording, usize), String> {
    let simulation = world.simulation_mut();
    let recording = simulation.end_recording().ok_or("nothing was recorded")?;
    simulation.record();
    let bytes = recording.to_bytes().map_err(|error| error.to_string())?;
    std::fs::write(RECORDING, &bytes).map_err(|error| format!("{RECORDING}: {error}"))?;
    Ok((recording, bytes.len()))
}

/// Turns the view by the arrow keys.
pub fn view(
    keys: Res<ButtonInput<KeyCode>>,
    time: Res<Time<Real>>,
    mut shown: ResMut<Shown>,
    mut camera: Single<&mut Transform, With<Camera3d>>,
) {
    let pressed = |key| f32::from(keys.pressed(key));
    let way = Vec2::new(
        pressed(KeyCode::ArrowRight) - pressed(KeyCode::ArrowLeft),
        pressed(KeyCode::ArrowUp) - pressed(KeyCode::ArrowDown),
    );
    shown.view += way * time.delta_secs();
    shown.view.y = shown.view.y.clamp(0.3, 1.5);
    let (about, above) = (shown.view.x, shown.view.y);
    let eye = Quat::from_rotation_z(about) * Vec3::new(0.0, -above.cos(), above.sin()) * 12.5;
    **camera = Transform::from_translation(eye + Vec3::NEG_Z * 0.3)
        .looking_at(Vec3::NEG_Z * 0.3, Quat::from_rotation_z(about) * Vec3::Y);
}

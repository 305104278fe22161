//! Measures and keys on the screen, and what the keys do.

use crate::Capsule;
use crate::course::Course;
use crate::hand::Hand;
use bevy::prelude::*;
use bevy_rhexis::rhexis::replay::Recording;
use bevy_rhexis::{Forceps, ForcepsState, RhexisError, RhexisGizmos, RhexisWorld, TissueEvent};

/// Where a recording goes.
pub const RECORDING: &str = "trainer.recording";

const KEYS: &str = "drag: grip and tear   wheel: lift   arrows: turn the view   Space: pause   R: anew   Z: back a grasp\n\
                    F fibres   S stress   T tips   M material force   C circle   L: keep the recording   Esc: quit";

/// What is drawn beside the tissue, from where, and what was said last.
#[derive(Resource)]
pub struct Shown {
    pub has_circle: bool,
    /// Angle about the eye's axis, and above its plane [rad].
    view: Vec2,
    said: String,
}

impl Shown {
    pub fn say(&mut self, words: impl Into<String>) {
        self.said = words.into();
    }
}

impl Default for Shown {
    fn default() -> Self {
        Self {
            has_circle: true,
            view: Vec2::new(0.0, 1.05),
            said: "Grip the flap beside the tip, and draw it round.".to_owned(),
        }
    }
}

/// The text of the measures.
#[derive(Component)]
pub struct Measures;

/// The text of what was said last.
#[derive(Component)]
pub struct Said;

pub fn spawn(mut commands: Commands) {
    commands.init_resource::<Shown>();
    let font = |size: f32| TextFont { font_size: FontSize::Px(size), ..default() };
    let dark = BackgroundColor(Color::srgba(0.0, 0.0, 0.0, 0.55));
    let at = Node { position_type: PositionType::Absolute, padding: UiRect::all(px(8)), ..default() };
    commands.spawn((Measures, Text::default(), font(14.0), dark, Node { top: px(10), left: px(10), ..at.clone() }));
    commands.spawn((Said, Text::default(), font(16.0), dark, Node { top: px(10), right: px(10), ..at.clone() }));
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
    mut shown: ResMut<Shown>,
    (mut events, mut errors): (MessageReader<TissueEvent>, MessageReader<RhexisError>),
    mut texts: ParamSet<(TextOf<Measures>, TextOf<Said>)>,
) {
    use bevy_rhexis::rhexis::event::EventKind;
    for event in events.read() {
        match &event.event.kind {
            EventKind::PieceFreed { .. } => shown.say("A piece has come free."),
            EventKind::Slipped { is_open: true, .. } => shown.say("The jaws have slipped."),
            EventKind::Ended { .. } => shown.say("A tear has ended."),
            EventKind::StepFailed { .. } => shown.say("A step was undone; the last good state stands."),
            _ => {}
        }
    }
    errors.read().for_each(|error| shown.say(error.to_string()));
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
    texts.p1().0.clone_from(&shown.said);
}

/// What the keys do.
pub fn keys(
    keys: Res<ButtonInput<KeyCode>>,
    pads: Query<&Gamepad>,
    (mut world, capsule): (ResMut<RhexisWorld>, Res<Capsule>),
    (mut course, mut hand, mut shown): (ResMut<Course>, ResMut<Hand>, ResMut<Shown>),
    (mut gizmos, mut time): (ResMut<RhexisGizmos>, ResMut<Time<Virtual>>),
    mut forceps: Single<&mut Forceps>,
    mut exit: MessageWriter<AppExit>,
) {
    let is_anew = keys.just_pressed(KeyCode::KeyR) || pads.iter().any(|pad| pad.just_pressed(GamepadButton::Start));
    let is_back = keys.just_pressed(KeyCode::KeyZ) || pads.iter().any(|pad| pad.just_pressed(GamepadButton::East));
    if is_anew || is_back {
        (hand.is_closed, forceps.is_closed) = (false, false);
    }
    if is_anew {
        match world.simulation_mut().restore(&capsule.start) {
            Ok(()) => {
                world.simulation_mut().record();
                *course = Course::new(&world, capsule.body);
                shown.say("Anew.");
            }
            Err(error) => shown.say(error.to_string()),
        }
    } else if is_back {
        shown.say(if course.undo(&mut world) {
            "Back before the last grasp."
        } else {
            "There is no grasp to take back."
        });
    }
    if keys.just_pressed(KeyCode::Space) {
        if time.is_paused() { time.unpause() } else { time.pause() }
    }
    if keys.just_pressed(KeyCode::KeyL) {
        shown.say(match keep(&mut world) {
            Ok((_, bytes)) => format!("{RECORDING}: {} kB; recorded anew from here.", bytes / 1000),
            Err(error) => error,
        });
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

//! The trainer without its window: a hand that closes the tear, and a gamepad that leads one.

#[path = "../../examples/trainer/play/mod.rs"]
mod play;

use crate::common::messages;
use bevy::app::{App, ScheduleRunnerPlugin, TaskPoolPlugin};
use bevy::asset::AssetPlugin;
use bevy::diagnostic::FrameCountPlugin;
use bevy::input::InputPlugin;
use bevy::input::gamepad::{
    GamepadConnection, GamepadConnectionEvent, RawGamepadAxisChangedEvent, RawGamepadButtonChangedEvent,
    RawGamepadEvent,
};
use bevy::mesh::MeshPlugin;
use bevy::prelude::*;
use bevy::time::{TimePlugin, TimeUpdateStrategy};
use bevy_rhexis::rhexis::event::Event;
use bevy_rhexis::rhexis::prelude::{Settings, Simulation};
use bevy_rhexis::rhexis::replay::Recording;
use bevy_rhexis::*;
use play::closing::{Closing, Phase};
use play::course::Course;
use play::hand::Hand;
use play::{Capsule, Said};
use rhexis_scene::measures::{Outcome, TearCourse};
use std::time::Duration;

/// The trainer, a step in each frame.
fn trainer() -> App {
    let mut app = App::new();
    app.add_plugins((TaskPoolPlugin::default(), FrameCountPlugin, TimePlugin, ScheduleRunnerPlugin::default()));
    app.add_plugins((TransformPlugin, AssetPlugin::default(), MeshPlugin, InputPlugin));
    play::play(&mut app).unwrap();
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(10)));
    app
}

fn start(app: &mut App) {
    app.finish();
    app.cleanup();
    app.update();
}

/// The recording of the hand that closes the tear.
const CLOSED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/headless/closed.rec");

#[test]
#[ignore = "a minute and a half: cargo test --release -p bevy_rhexis --features gizmos --test headless -- --ignored a_hand; RHEXIS_UPDATE_GOLDEN=1 keeps the recording"]
fn a_hand_closes_the_tear_and_the_recording_repeats_it() {
    let mut app = trainer();
    app.init_resource::<Closing>().add_systems(Update, play::closing::lead.before(play::hand::follow));
    start(&mut app);
    while !matches!(app.world().resource::<Closing>().phase, Phase::Done(_)) {
        app.update();
        assert_eq!(messages::<RhexisError>(&mut app), []);
    }
    let world = app.world();
    let (course, capsule) = (world.resource::<Course>(), world.resource::<Capsule>());
    println!("{}", course.lines(world.resource::<RhexisWorld>(), capsule.body));
    assert_eq!(course.outcome(), Outcome::Closed);
    let mut world = app.world_mut().resource_mut::<RhexisWorld>();
    let hash = world.simulation().hash();
    let bytes = world.simulation_mut().end_recording().unwrap().to_bytes().unwrap();
    println!("{} bytes, hash {hash}", bytes.len());
    if std::env::var_os("RHEXIS_UPDATE_GOLDEN").is_some() {
        std::fs::write(CLOSED, &bytes).unwrap();
    }
    assert_eq!(Recording::from_bytes(&bytes).unwrap().replay().unwrap().hash(), hash);
}

/// The recording on file, marked as one of this build: its steps take no Cholesky factor, so that builds with and without have its bits.
fn on_file() -> Recording {
    /// Place in the head, and bit there, of the mark of builds with factors.
    const MARK: (usize, u8) = (10, 1);
    let own = Simulation::new(Settings::default()).unwrap().snapshot().to_bytes().unwrap()[MARK.0] & MARK.1;
    let mut bytes = std::fs::read(CLOSED).unwrap();
    bytes[MARK.0] = bytes[MARK.0] & !MARK.1 | own;
    Recording::from_bytes(&bytes).unwrap()
}

#[test]
fn the_tear_that_the_hand_has_closed_is_repeated_to_the_same_hash() {
    let recording = on_file();
    let start = Simulation::from_snapshot(recording.start()).unwrap();
    let mut course = TearCourse::new(start.world(), start.bodies()[0], start.time()).unwrap();
    assert_eq!(course.figures().outcome, Outcome::Unfinished);
    // To the hash of the recording's end, or this is an error.
    let mut simulation = recording.replay().unwrap();
    let events: Vec<Event> = simulation.drain_events().collect();
    course.note(simulation.world(), simulation.time(), &events);
    assert_eq!(course.figures().outcome, Outcome::Closed);
}

struct Pad(Entity);

impl Pad {
    fn connect(app: &mut App) -> Self {
        let pad = app.world_mut().spawn_empty().id();
        let connection = GamepadConnection::Connected { name: "pad".to_owned(), vendor_id: None, product_id: None };
        app.world_mut().write_message(GamepadConnectionEvent::new(pad, connection));
        app.update();
        Self(pad)
    }

    fn axis(&self, app: &mut App, axis: GamepadAxis, value: f32) {
        let change = RawGamepadAxisChangedEvent::new(self.0, axis, value);
        app.world_mut().write_message(RawGamepadEvent::Axis(change));
    }

    fn button(&self, app: &mut App, button: GamepadButton, value: f32) {
        let change = RawGamepadButtonChangedEvent::new(self.0, button, value);
        app.world_mut().write_message(RawGamepadEvent::Button(change));
    }
}

fn frames(app: &mut App, count: u32) {
    (0..count).for_each(|_| app.update());
}

/// Place, whether closed, and whether tissue is held.
fn forceps(app: &mut App) -> (Vec3, bool, bool) {
    let mut forceps = app.world_mut().query::<(&Transform, &Forceps, &ForcepsState)>();
    let (transform, forceps, state) = forceps.single(app.world()).unwrap();
    (transform.translation, forceps.is_closed, state.tissue.is_some())
}

fn hash(app: &App) -> String {
    app.world().resource::<RhexisWorld>().simulation().hash().to_string()
}

#[test]
fn a_gamepad_moves_grips_lifts_draws_lets_go_and_goes_back() {
    let mut app = trainer();
    app.add_systems(Update, play::hand::gamepad.before(play::hand::follow));
    start(&mut app);
    let pad = Pad::connect(&mut app);
    let (begin, ..) = forceps(&mut app);
    // A stick within its dead part moves nothing.
    pad.axis(&mut app, GamepadAxis::LeftStickX, 0.1);
    frames(&mut app, 10);
    assert_eq!(forceps(&mut app).0, begin);
    // Open jaws go along the tissue, 3 mm/s.
    pad.axis(&mut app, GamepadAxis::LeftStickX, -1.0);
    frames(&mut app, 10);
    pad.axis(&mut app, GamepadAxis::LeftStickX, 0.0);
    frames(&mut app, 1);
    let (place, ..) = forceps(&mut app);
    assert!((place.x - begin.x + 0.3).abs() < 0.05 && place.z < 0.0, "{begin} {place}");

    let before = hash(&app);
    pad.button(&mut app, GamepadButton::RightTrigger2, 1.0);
    frames(&mut app, 2);
    let (gripped, is_closed, holds) = forceps(&mut app);
    assert!(is_closed && holds);
    // What is held is lifted by half a millimetre, and by the right stick further.
    pad.axis(&mut app, GamepadAxis::RightStickY, 1.0);
    frames(&mut app, 20);
    pad.axis(&mut app, GamepadAxis::RightStickY, 0.0);
    frames(&mut app, 20);
    let (lifted, ..) = forceps(&mut app);
    assert!((lifted.z - gripped.z - 0.7).abs() < 0.05, "{gripped} {lifted}");
    pad.axis(&mut app, GamepadAxis::LeftStickY, 1.0);
    frames(&mut app, 40);
    assert!(forceps(&mut app).0.y > lifted.y + 1.0);
    assert!(app.world().resource::<Course>().outcome() == Outcome::Unfinished);
    pad.axis(&mut app, GamepadAxis::LeftStickY, 0.0);
    pad.button(&mut app, GamepadButton::RightTrigger2, 0.0);
    frames(&mut app, 2);
    let (_, is_closed, holds) = forceps(&mut app);
    assert!(!is_closed && !holds);
    assert_ne!(hash(&app), before);
    assert_eq!(messages::<RhexisError>(&mut app), []);

    let said = |app: &App| app.world().resource::<Said>().0.clone();
    for expected in ["Back before the last grasp.", "There is no grasp to take back."] {
        pad.button(&mut app, GamepadButton::East, 1.0);
        frames(&mut app, 1);
        assert_eq!(said(&app), expected);
        pad.button(&mut app, GamepadButton::East, 0.0);
        frames(&mut app, 1);
    }
    pad.button(&mut app, GamepadButton::Start, 1.0);
    frames(&mut app, 1);
    assert_eq!(said(&app), "Anew.");
    assert!(app.world().resource::<Hand>().target.is_finite());
    let time = app.world().resource::<RhexisWorld>().simulation().time();
    assert!(time <= 10.0, "{time} ms");
}

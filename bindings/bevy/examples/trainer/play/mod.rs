//! What is played, without what is seen: the capsule, the hand, how far the tear has come, and a hand that plays by itself.

pub mod back;
pub mod closing;
pub mod course;
pub mod hand;

use bevy::prelude::*;
use bevy_rhexis::rhexis::components::{Jaws, Slip};
use bevy_rhexis::rhexis::snapshot::Snapshot;
use bevy_rhexis::rhexis::storage::BodyId;
use bevy_rhexis::{Forceps, RhexisPlugin, RhexisSystems, RhexisWorld, Tissue};
use rhexis_scene::Document;

/// The most steps in a frame: what takes longer goes in slow motion.
const MOST_STEPS: u32 = 3;

/// Where the forceps take tissue [mm].
const REACH: f64 = 0.4;

/// The capsule's body, and its state before the first touch.
#[derive(Resource)]
pub struct Capsule {
    pub body: BodyId,
    pub start: Snapshot,
}

/// What was said last.
#[derive(Resource)]
pub struct Said(pub String);

/// Plays without a window: what leads the hand, and what shows it, is added by the app.
pub fn play(app: &mut App) -> Result<(), Box<dyn std::error::Error>> {
    let (world, capsule) = scene()?;
    app.insert_resource(course::Course::new(&world, capsule.body)).insert_resource(world).insert_resource(capsule);
    app.insert_resource(Said("Grip the flap beside the tip, and draw it round.".to_owned()));
    app.init_resource::<hand::Hand>().add_plugins(RhexisPlugin::default());
    app.add_systems(Startup, spawn);
    app.add_systems(Update, (hand::follow, back::keys).chain());
    app.add_systems(PostUpdate, course::note.after(RhexisSystems::Show));
    Ok(())
}

/// The capsule of the catalog, coarse enough to keep pace with a hand, without the motions of its own.
fn scene() -> Result<(RhexisWorld, Capsule), Box<dyn std::error::Error>> {
    let mut document = Document::named("capsulorhexis")?;
    for change in ["bodies.0.mesh.cap.triangles=1500", "bodies.0.refinement.budget=3", "bodies.0.grips=[]"] {
        document.set(change)?;
    }
    let instance = document.scene()?.instantiate()?;
    let body = *instance.bodies.first().ok_or("the scene has no body")?;
    let mut simulation = instance.simulation;
    let start = simulation.snapshot();
    simulation.record();
    let world = RhexisWorld::new(simulation, instance.run.dt, MOST_STEPS)?;
    Ok((world, Capsule { body, start }))
}

/// The capsule and the forceps.
fn spawn(mut commands: Commands, capsule: Res<Capsule>) {
    commands.spawn((Name::new("capsule"), Tissue::of_body(capsule.body)));
    let jaws = Jaws { radius: 0.2, stiffness: Some(0.2), force_limit: None, slip: Slip::LetGo };
    commands.spawn((Name::new("hand"), Forceps::new(jaws, REACH)));
}

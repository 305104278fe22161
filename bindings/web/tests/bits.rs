//! What a native build reaches by `test/plan.json`, to the bit: the package is compared with the same file by `test/bits.test.mjs`.
//!
//! For builds without the feature `direct` of the engine, whose factors give other bits. In the workspace other packages ask for it,
//! hence it is run alone: `cargo test --release --package rhexis-web --test bits`. With `RHEXIS_UPDATE_GOLDEN=1` the file is written anew.

mod plan;

use rhexis::event::Event;
use rhexis::replay::Recording;
use rhexis::simulation::Simulation;
use rhexis_scene::measures::{Outcome, TearCourse};
use rhexis_web::engine::Engine;
use std::fmt::Write;
use std::path::Path;

#[test]
fn the_plan_has_the_native_bits() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("test/plan.json");
    let then = std::fs::read_to_string(&path).unwrap();
    let mut entries = plan::read(&then).unwrap();
    for entry in &mut entries {
        let measures = entry.run(Engine::step).unwrap().measures();
        (entry.hash, entry.length_mm) = (Some(measures.hash), Some(measures.length_mm));
    }
    let mut now = "[\n".to_owned();
    for (i, entry) in entries.iter().enumerate() {
        let end = if i + 1 < entries.len() { "," } else { "" };
        let _ = writeln!(now, "  {}{end}", serde_json::to_string(entry).unwrap());
    }
    now.push_str("]\n");
    if std::env::var_os("RHEXIS_UPDATE_GOLDEN").is_some() {
        std::fs::write(&path, now).unwrap();
        return;
    }
    // As text: numbers are written with all their digits.
    assert_eq!(now, then, "the bits are not those of {}", path.display());
}

/// A capsulorhexis that the hand of `test/rhexis.mjs` has closed by the module, as it does on the page. Where the bits of the engine have changed it
/// is closed anew: `node test/close.mjs test/closed.rec` in `bindings/web`.
#[test]
fn a_tear_closed_in_the_browser_has_the_native_bits() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("test/closed.rec");
    let recording = Recording::load(path).unwrap();
    let start = Simulation::from_snapshot(recording.start()).unwrap();
    let mut course = TearCourse::new(start.world(), start.bodies()[0], start.time()).unwrap();
    assert_eq!(course.figures().outcome, Outcome::Unfinished);
    // To the hash of the recording's end, or this is an error.
    let mut simulation = recording.replay().unwrap();
    let events: Vec<Event> = simulation.drain_events().collect();
    course.note(simulation.world(), simulation.time(), &events);
    let figures = course.figures();
    assert_eq!(figures.outcome, Outcome::Closed);
    let diameter = figures.opening.unwrap().diameter;
    assert!((4.8..5.5).contains(&diameter), "{diameter} mm");
}

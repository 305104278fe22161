//! The native run that the browser's is compared with: `reference PLAN.json` prints a line of JSON for every entry of the plan, with the hash
//! of the state at its end, the length torn and the median processor time of a step.

use cpu_time::ThreadTime;
use glam::DVec3;
use rhexis_web::engine::{Engine, Source};
use serde::{Deserialize, Serialize};
use std::error::Error;

/// A scene to run.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
struct Entry {
    scene: String,
    steps: u32,
    #[serde(default)]
    set: Vec<String>,
    #[serde(default)]
    by_hand: bool,
    hand: Option<HandEntry>,
}

/// What the hand grips before the first step, and by how much it draws that.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct HandEntry {
    origin: DVec3,
    direction: DVec3,
    by: DVec3,
}

#[derive(Serialize)]
struct Outcome {
    scene: String,
    steps: u32,
    hash: String,
    length_mm: f64,
    step_ms: f64,
}

fn run(entry: &Entry) -> Result<Outcome, Box<dyn Error>> {
    let Entry { scene, set, by_hand, .. } = entry;
    let source = Source { scene: scene.clone(), set: set.clone(), by_hand: *by_hand, ..Source::default() };
    let mut engine = Engine::new(&source)?;
    if let Some(hand) = &entry.hand {
        let Engine { instance, hand: tools, planar, .. } = &mut engine;
        let place = tools.grip(instance, planar, (hand.origin, hand.direction))?;
        tools.draw(place.ok_or("the ray meets no tissue")? + hand.by);
    }
    let mut times = Vec::new();
    for _ in 0..entry.steps {
        let begin = ThreadTime::now();
        engine.step()?;
        times.push(begin.elapsed().as_secs_f64() * 1e3);
    }
    times.sort_by(f64::total_cmp);
    let measures = engine.measures();
    let step_ms = times.get(times.len() / 2).copied().unwrap_or_default();
    let (scene, steps) = (scene.clone(), entry.steps);
    Ok(Outcome { scene, steps, hash: measures.hash, length_mm: measures.length_mm, step_ms })
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("usage: reference PLAN.json")?;
    let plan: Vec<Entry> = serde_json::from_str(&std::fs::read_to_string(path)?)?;
    for entry in &plan {
        let outcome = run(entry).map_err(|error| format!("{}: {error}", entry.scene))?;
        println!("{}", serde_json::to_string(&outcome)?);
    }
    Ok(())
}

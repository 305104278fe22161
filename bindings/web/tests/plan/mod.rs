//! Runs that native and WebAssembly builds are compared by: a scene, steps and what the hand does.

use glam::DVec3;
use rhexis_web::engine::{Engine, Source};
use serde::{Deserialize, Serialize};
use std::error::Error;

/// A run, and what it reaches where that is known.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Entry {
    /// Name of the scene in the catalog.
    pub scene: String,
    /// Steps.
    pub steps: u32,
    /// Changes of the scene.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    set: Vec<String>,
    /// Whether the scene's own motions are left out.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    by_hand: bool,
    /// What the hand does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    hand: Option<Drag>,
    /// Hash of the state at the end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hash: Option<String>,
    /// Length torn and cut at the end \[mm\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length_mm: Option<f64>,
}

/// What the hand grips before the first step, and by how much it draws that \[mm\].
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct Drag {
    origin: DVec3,
    direction: DVec3,
    by: DVec3,
}

impl Entry {
    /// Builds the scene, does the steps by `step` and returns the engine.
    ///
    /// # Errors
    /// As the scene's and the steps'.
    pub fn run(&self, mut step: impl FnMut(&mut Engine) -> Result<(), String>) -> Result<Engine, Box<dyn Error>> {
        let Self { scene, set, by_hand, .. } = self;
        let source = Source { scene: scene.clone(), set: set.clone(), by_hand: *by_hand, ..Source::default() };
        let mut engine = Engine::new(&source)?;
        if let Some(drag) = &self.hand {
            let Engine { instance, hand, planar, .. } = &mut engine;
            let place = hand.grip(instance, planar, (drag.origin, drag.direction))?;
            hand.draw(place.ok_or("the ray meets no tissue")? + drag.by);
        }
        for _ in 0..self.steps {
            step(&mut engine)?;
        }
        Ok(engine)
    }
}

/// The entries of a plan's text.
///
/// # Errors
/// Where it is no plan.
pub fn read(text: &str) -> Result<Vec<Entry>, Box<dyn Error>> {
    Ok(serde_json::from_str(text)?)
}

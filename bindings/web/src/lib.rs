//! The engine in a browser: a WebAssembly module with a JavaScript interface.
//!
//! [`World`] is what a page uses; [`engine::Engine`] is the same for Rust, which tests and the native reference use. Arrays that a page gets are
//! its own copies: they stay as they are while the world goes on.

#![cfg_attr(not(test), warn(clippy::expect_used, clippy::panic, clippy::unreachable, clippy::unwrap_used))]

pub mod engine;
pub mod hand;
pub mod measures;
pub mod mesh_scene;
pub mod picture;

use engine::{Engine, Source};
use glam::DVec3;
use picture::Shade;
use rhexis::replay::Recording;
use rhexis_scene::catalog::CATALOG;
use serde::Serialize;
use wasm_bindgen::prelude::wasm_bindgen;
use wasm_bindgen::{JsError, JsValue};

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = include_str!("../js/measures.d.ts");

type Thrown<T> = Result<T, JsError>;

fn thrown(error: String) -> JsError {
    JsError::new(&error)
}

/// A plain object of JavaScript.
fn object(value: &impl Serialize) -> Thrown<JsValue> {
    let text = serde_json::to_string(value).map_err(|error| thrown(error.to_string()))?;
    js_sys::JSON::parse(&text).map_err(|_| thrown("the figures are no JSON".to_owned()))
}

fn point(numbers: &[f64], what: &str) -> Thrown<DVec3> {
    match numbers {
        &[x, y, z] if [x, y, z].iter().all(|x| x.is_finite()) => Ok(DVec3::new(x, y, z)),
        _ => Err(thrown(format!("{what}: give three finite numbers"))),
    }
}

fn ray(origin: &[f64], direction: &[f64]) -> Thrown<(DVec3, DVec3)> {
    Ok((point(origin, "the ray's origin")?, point(direction, "the ray's direction")?))
}

fn shade(name: &str) -> Thrown<Shade> {
    match name {
        "stress" => Ok(Shade::Stress),
        "criterion" => Ok(Shade::Criterion),
        other => Err(thrown(format!("{other:?} is no shade; give \"stress\" or \"criterion\""))),
    }
}

/// The scenes of the catalog: name, one sentence about each, and the text.
#[wasm_bindgen(unchecked_return_type = "CatalogEntry[]")]
pub fn catalog() -> Thrown<JsValue> {
    #[derive(Serialize)]
    struct Entry {
        name: &'static str,
        about: String,
        text: &'static str,
    }
    let entries: Vec<Entry> =
        CATALOG.iter().map(|entry| Entry { name: entry.name, about: entry.about(), text: entry.text }).collect();
    object(&entries)
}

/// Version of the engine.
#[wasm_bindgen]
pub fn version() -> String {
    env!("CARGO_PKG_VERSION").to_owned()
}

/// Repeats a recording: the hash of its end. Throws where it is not the recorded one, and where the recording is another build's.
#[wasm_bindgen]
pub fn replay(recording: &[u8]) -> Thrown<String> {
    let recording = Recording::from_bytes(recording).map_err(|error| thrown(error.to_string()))?;
    let simulation = recording.replay().map_err(|error| thrown(error.to_string()))?;
    Ok(simulation.hash().to_string())
}

/// What a world is made from: a scene, changes, files.
#[wasm_bindgen]
#[derive(Debug, Default)]
pub struct Recipe {
    source: Source,
}

#[wasm_bindgen]
impl Recipe {
    /// Begins with the text of a scene, or the name of one of the catalog.
    #[wasm_bindgen(constructor)]
    pub fn new(scene: String) -> Self {
        Self { source: Source { scene, ..Source::default() } }
    }

    /// Changes a value, as `rhexis run --set`: `"run.dt=5"`.
    pub fn set(&mut self, assignment: String) {
        self.source.set.push(assignment);
    }

    /// Gives the content of a file that the scene names by this path.
    pub fn file(&mut self, path: String, bytes: Vec<u8>) {
        self.source.files.push((path, bytes));
    }

    /// Leaves the motions of the scene's own grips and holds out: a hand is to do the work.
    #[wasm_bindgen(js_name = byHand)]
    pub fn by_hand(&mut self, by_hand: bool) {
        self.source.by_hand = by_hand;
    }

    /// Builds the world.
    pub fn build(&self) -> Thrown<World> {
        Engine::new(&self.source).map(World::new).map_err(thrown)
    }
}

/// A scene that is stepped, gripped, cut and looked at. Units: mm, g, ms, hence N and MPa.
#[wasm_bindgen]
pub struct World {
    engine: Engine,
    text: Option<String>,
}

impl World {
    fn new(engine: Engine) -> Self {
        Self { engine, text: None }
    }
}

#[wasm_bindgen]
impl World {
    /// A world about a mesh file (OBJ, or another format that scenes read): held along its rim, with numbers that go with its size.
    /// `unit` is that of the file: `"mm"`, `"cm"`, `"m"` or `"um"`; `fibres` a direction that is projected into every triangle.
    #[wasm_bindgen(js_name = fromMesh)]
    pub fn from_mesh(
        name: &str,
        bytes: Vec<u8>,
        unit: &str,
        #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] fibres: &[f64],
    ) -> Thrown<World> {
        let fibres = point(fibres, "the direction of the fibres")?;
        let options = mesh_scene::Options { unit: unit.to_owned(), fibres, repair: true };
        let (text, engine) = Engine::of_mesh(name, bytes, &options).map_err(thrown)?;
        Ok(Self { engine, text: Some(text) })
    }

    /// The text of the scene that `fromMesh` has written.
    #[wasm_bindgen(getter, js_name = sceneText)]
    pub fn scene_text(&self) -> Option<String> {
        self.text.clone()
    }

    /// The scene's name.
    #[wasm_bindgen(getter)]
    pub fn name(&self) -> String {
        self.engine.name.clone()
    }

    /// Whether every body lies in a plane.
    #[wasm_bindgen(getter, js_name = isPlanar)]
    pub fn is_planar(&self) -> bool {
        self.engine.planar.iter().all(|&is_planar| is_planar)
    }

    /// Time step \[ms\].
    #[wasm_bindgen(getter)]
    pub fn dt(&self) -> f64 {
        self.engine.instance.run.dt
    }

    /// Steps done.
    #[wasm_bindgen(getter)]
    pub fn steps(&self) -> f64 {
        self.engine.instance.step() as f64
    }

    /// Simulated time \[ms\].
    #[wasm_bindgen(getter)]
    pub fn time(&self) -> f64 {
        self.engine.instance.simulation.time()
    }

    /// Whether the scene is at its end; it can be stepped on.
    #[wasm_bindgen(getter, js_name = isFinished)]
    pub fn is_finished(&self) -> bool {
        self.engine.instance.is_finished()
    }

    /// Does steps of the scene, with the hand's motion in them. Throws where no equilibrium is found; the last good state stands.
    pub fn step(&mut self, count: u32) -> Thrown<()> {
        (0..count).try_for_each(|_| self.engine.step()).map_err(thrown)
    }

    /// Hash of the state, sixteen hexadecimal digits: the same as that of a native run.
    pub fn hash(&self) -> String {
        self.engine.instance.simulation.hash().to_string()
    }

    /// Takes hold of what a ray meets first, and keeps the state before for `undo`. The place \[mm\], or nothing where it meets none.
    pub fn grip(
        &mut self,
        #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] origin: &[f64],
        #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] direction: &[f64],
    ) -> Thrown<Option<Vec<f64>>> {
        let ray = ray(origin, direction)?;
        let Engine { instance, hand, .. } = &mut self.engine;
        hand.open(instance);
        if hand.pick(instance, ray.0, ray.1).is_none() {
            return Ok(None);
        }
        self.engine.keep();
        let Engine { instance, hand, planar, .. } = &mut self.engine;
        let place = hand.grip(instance, planar, ray).map_err(thrown)?;
        Ok(place.map(|place| place.to_array().to_vec()))
    }

    /// Draws what is held towards a place \[mm\] in the steps to come, half a mean edge per step. Whether anything is held.
    #[wasm_bindgen(js_name = moveGrip)]
    pub fn move_grip(
        &mut self,
        #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] target: &[f64],
    ) -> Thrown<bool> {
        let target = point(target, "the place of the hand")?;
        Ok(self.engine.hand.draw(target))
    }

    /// Lets go.
    #[wasm_bindgen(js_name = letGo)]
    pub fn let_go(&mut self) {
        let Engine { instance, hand, .. } = &mut self.engine;
        hand.open(instance);
    }

    /// The place of the hand \[mm\], while it holds something.
    #[wasm_bindgen(js_name = gripPlace)]
    pub fn grip_place(&self) -> Option<Vec<f64>> {
        let Engine { instance, hand, .. } = &self.engine;
        hand.place(instance).map(|place| place.to_array().to_vec())
    }

    /// Radius of the jaws \[mm\].
    #[wasm_bindgen(getter, js_name = jawRadius)]
    pub fn jaw_radius(&self) -> f64 {
        self.engine.hand.radius()
    }

    /// Cuts a slit from where one ray meets the tissue to where another does, and keeps the state before for `undo`. Its length at rest
    /// \[mm\].
    pub fn cut(
        &mut self,
        #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] origin: &[f64],
        #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] from: &[f64],
        #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] to: &[f64],
    ) -> Thrown<f64> {
        let rays = [ray(origin, from)?, ray(origin, to)?];
        self.engine.keep();
        let Engine { instance, hand, .. } = &mut self.engine;
        let made = hand.cut(instance, rays);
        if made.is_err() {
            // Nothing has changed.
            self.engine.undo().map_err(thrown)?;
        }
        self.engine.take_events();
        made.map_err(thrown)
    }

    /// Keeps the present state for `undo`; the oldest of sixteen goes.
    pub fn keep(&mut self) {
        self.engine.keep();
    }

    /// Goes back to the state kept last; whether there was one.
    pub fn undo(&mut self) -> Thrown<bool> {
        self.engine.undo().map_err(thrown)
    }

    /// How many states there are to go back to.
    #[wasm_bindgen(getter, js_name = undoCount)]
    pub fn undo_count(&self) -> usize {
        self.engine.kept_count()
    }

    /// Goes back to the beginning.
    pub fn reset(&mut self) -> Thrown<()> {
        self.engine.reset().map_err(thrown)
    }

    /// Positions of all bodies \[mm\], three numbers per vertex.
    pub fn positions(&self) -> Vec<f32> {
        self.engine.positions()
    }

    /// Rows of the vertices, three per triangle, of all bodies.
    pub fn indices(&self) -> Vec<u32> {
        self.engine.indices()
    }

    /// Surfaces of all obstacles where they are now: positions \[mm\], and triangles that face outwards. Of a plane the part under the bodies.
    #[wasm_bindgen(unchecked_return_type = "Surfaces")]
    pub fn obstacles(&self) -> JsValue {
        let (positions, indices) = self.engine.obstacles();
        let surfaces = js_sys::Object::new();
        let put = |name: &str, array: &JsValue| _ = js_sys::Reflect::set(&surfaces, &name.into(), array);
        put("positions", &js_sys::Float32Array::from(positions.as_slice()).into());
        put("indices", &js_sys::Uint32Array::from(indices.as_slice()).into());
        surfaces.into()
    }

    /// A number per triangle: `"stress"`, the largest principal stress \[MPa\], or `"criterion"`, above 1 where it would tear.
    #[wasm_bindgen(js_name = triangleValues)]
    pub fn triangle_values(&mut self, what: &str) -> Thrown<Vec<f32>> {
        Ok(self.engine.shades(shade(what)?))
    }

    /// The same, averaged at the vertices.
    #[wasm_bindgen(js_name = vertexValues)]
    pub fn vertex_values(&mut self, what: &str) -> Thrown<Vec<f32>> {
        Ok(self.engine.vertex_shades(shade(what)?))
    }

    /// A line along the fibre through every triangle: six numbers each \[mm\].
    pub fn fibres(&mut self) -> Vec<f32> {
        self.engine.fibres()
    }

    /// Positions of the tear tips \[mm\], three numbers each.
    pub fn tips(&self) -> Vec<f32> {
        self.engine.tips()
    }

    /// At every tip a line in the direction that the criterion prefers: six numbers each \[mm\].
    #[wasm_bindgen(js_name = tipDirections)]
    pub fn tip_directions(&mut self) -> Vec<f32> {
        self.engine.tip_directions()
    }

    /// From every gripped vertex to where its jaws draw it: six numbers each \[mm\].
    pub fn grips(&mut self) -> Vec<f32> {
        self.engine.grips()
    }

    /// The figures as they stand, with the names of `report.json`.
    #[wasm_bindgen(unchecked_return_type = "Measures")]
    pub fn measures(&mut self) -> Thrown<JsValue> {
        object(&self.engine.measures())
    }

    /// What has happened since the last call, the latest 1024 events.
    #[wasm_bindgen(unchecked_return_type = "WorldEvent[]")]
    pub fn events(&mut self) -> Thrown<JsValue> {
        let events = self.engine.drain_events();
        object(&self.engine.event_figures(&events))
    }

    /// Begins to record every call from the present state on, for `rhexis replay`.
    pub fn record(&mut self) {
        self.engine.instance.simulation.record();
    }

    /// Ends the recording: the bytes of a file that `rhexis replay` repeats to the same hash.
    #[wasm_bindgen(js_name = endRecording)]
    pub fn end_recording(&mut self) -> Thrown<Option<Vec<u8>>> {
        let recording: Option<Recording> = self.engine.instance.simulation.end_recording();
        recording.map(|recording| recording.to_bytes()).transpose().map_err(|error| thrown(error.to_string()))
    }
}

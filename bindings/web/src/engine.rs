//! A scene that is stepped by hand: its instance, the hand, states to go back to and the courses of its tears.

use crate::hand::Hand;
use crate::mesh_scene;
use rhexis::components::Tearing;
use rhexis::event::Event;
use rhexis::snapshot::Snapshot;
use rhexis::storage::BodyId;
use rhexis_scene::measures::TearCourse;
use rhexis_scene::schema::{GripSpec, SceneFile};
use rhexis_scene::{Document, Instance, Scene};

/// The most states that are kept to go back to.
const MOST_KEPT: usize = 16;

/// The most events that wait to be read.
const MOST_EVENTS: usize = 1024;

/// A scene, where it comes from and how it is to be run.
#[derive(Clone, Debug, Default)]
pub struct Source {
    /// The scene's text, or the name of one of the catalog.
    pub scene: String,
    /// Changes, as `rhexis run --set` takes them.
    pub set: Vec<String>,
    /// Contents of files by the paths that the scene names them by.
    pub files: Vec<(String, Vec<u8>)>,
    /// Whether the motions of the scene's own grips and holds are left out: a hand is to do the work.
    pub by_hand: bool,
}

impl Source {
    fn document(&self) -> Result<Document, String> {
        let mut document = match self.scene.contains('\n') {
            true => Document::new(self.scene.clone(), "scene.toml"),
            false => Document::named(&self.scene).map_err(|error| error.to_string())?,
        };
        for assignment in &self.set {
            document.set(assignment).map_err(|error| error.to_string())?;
        }
        for (path, bytes) in &self.files {
            document = document.with_file(path, bytes.clone());
        }
        document.set("run.threads=1").map_err(|error| error.to_string())?;
        Ok(document)
    }

    /// The scene as it is to be run, and the first grip that its text has.
    ///
    /// # Errors
    /// As the scene's: place, reason and remedy.
    pub fn scene(&self) -> Result<(Scene, Option<GripSpec>), String> {
        let mut document = self.document()?;
        let given = document.clone().scene().map_err(|error| error.to_string())?;
        let grip = given.file().bodies.iter().flat_map(|body| &body.grips).next().cloned();
        if !self.by_hand {
            return Ok((given, grip));
        }
        for assignment in motions(given.file()) {
            document.set(&assignment).map_err(|error| error.to_string())?;
        }
        Ok((document.scene().map_err(|error| error.to_string())?, grip))
    }
}

/// The changes that take the scene's own grips away and keep its holds where they are.
fn motions(file: &SceneFile) -> Vec<String> {
    let mut changes = Vec::new();
    for (i, body) in file.bodies.iter().enumerate() {
        if !body.grips.is_empty() {
            changes.push(format!("bodies.{i}.grips=[]"));
        }
        changes.extend((0..body.holds.len()).map(|j| format!("bodies.{i}.holds.{j}.curve=0")));
        let turned = body.holds.iter().enumerate().filter(|(_, hold)| hold.rotate.is_some());
        changes.extend(turned.map(|(j, _)| format!("bodies.{i}.holds.{j}.rotate=[[0, [0, 0, 0]]]")));
    }
    changes
}

/// A state to go back to.
struct Kept {
    snapshot: Snapshot,
    progress: (u64, bool),
    courses: Vec<TearCourse>,
}

/// A scene in a simulation that a hand takes part in.
pub struct Engine {
    /// The scene's instance.
    pub instance: Instance,
    /// The scene's name.
    pub name: String,
    /// Whether each body is planar, in the order of `instance.bodies`.
    pub planar: Vec<bool>,
    /// Courses of the tears of those bodies that can tear and have a rim.
    pub courses: Vec<TearCourse>,
    /// Forceps, blade and what they do.
    pub hand: Hand,
    events: Vec<Event>,
    kept: Vec<Kept>,
    start: Kept,
}

impl Engine {
    /// Builds a scene.
    ///
    /// # Errors
    /// As the scene's: place, reason and remedy.
    pub fn new(source: &Source) -> Result<Self, String> {
        let (scene, grip) = source.scene()?;
        let mut instance = scene.instantiate().map_err(|error| error.to_string())?;
        let file = scene.file();
        let planar = file.bodies.iter().flat_map(|body| vec![body.planar; body.copies.max(1) as usize]).collect();
        let hand = Hand::of(&scene, grip.as_ref(), &mut instance);
        let events: Vec<Event> = instance.simulation.drain_events().collect();
        let world = instance.simulation.world();
        let time = instance.simulation.time();
        let torn = instance.bodies.iter().filter(|&&body| world.satisfies::<&Tearing>(body.entity()));
        let mut courses: Vec<TearCourse> = torn.filter_map(|&body| TearCourse::new(world, body, time)).collect();
        courses.iter_mut().for_each(|course| course.note(world, time, &events));
        let start =
            Kept { snapshot: instance.simulation.snapshot(), progress: instance.progress(), courses: courses.clone() };
        let name = scene.name().to_owned();
        Ok(Self { instance, name, planar, courses, hand, events, kept: Vec::new(), start })
    }

    /// Builds a scene about a mesh file: its text, and the engine.
    ///
    /// # Errors
    /// As the mesh's and the scene's.
    pub fn of_mesh(name: &str, bytes: Vec<u8>, options: &mesh_scene::Options) -> Result<(String, Self), String> {
        let scene = mesh_scene::text(name, &bytes, options)?;
        let source = Source { scene: scene.clone(), files: vec![(name.to_owned(), bytes)], ..Source::default() };
        Ok((scene, Self::new(&source)?))
    }

    /// Does one step, with the hand's motion in it.
    ///
    /// # Errors
    /// Where no equilibrium is found; the last good state stands.
    pub fn step(&mut self) -> Result<(), String> {
        self.hand.drive(&mut self.instance);
        let outcome = self.instance.advance().map(|_| ()).map_err(|error| error.to_string());
        self.take_events();
        self.hand.look(&self.instance);
        outcome
    }

    /// Takes what has happened in, for the courses and for whoever reads it.
    pub fn take_events(&mut self) {
        let events: Vec<Event> = self.instance.simulation.drain_events().collect();
        let (world, time) = (self.instance.simulation.world(), self.instance.simulation.time());
        self.courses.iter_mut().for_each(|course| course.note(world, time, &events));
        self.events.extend(events);
        let beyond = self.events.len().saturating_sub(MOST_EVENTS);
        self.events.drain(..beyond);
    }

    /// The events since the last call, the latest 1024 of them.
    pub fn drain_events(&mut self) -> Vec<Event> {
        std::mem::take(&mut self.events)
    }

    /// Keeps the present state for [`undo`](Self::undo). The oldest of sixteen goes.
    pub fn keep(&mut self) {
        if self.kept.len() == MOST_KEPT {
            self.kept.remove(0);
        }
        self.kept.push(Kept {
            snapshot: self.instance.simulation.snapshot(),
            progress: self.instance.progress(),
            courses: self.courses.clone(),
        });
    }

    /// Goes back to the state kept last; whether there was one.
    ///
    /// # Errors
    /// As the snapshot's.
    pub fn undo(&mut self) -> Result<bool, String> {
        let Some(kept) = self.kept.pop() else { return Ok(false) };
        self.restore(&kept).map(|()| true)
    }

    /// How many states there are to go back to.
    pub fn kept_count(&self) -> usize {
        self.kept.len()
    }

    /// Goes back to the beginning; what was kept is forgotten.
    ///
    /// # Errors
    /// As the snapshot's.
    pub fn reset(&mut self) -> Result<(), String> {
        self.kept.clear();
        let start = Kept {
            snapshot: self.start.snapshot.clone(),
            progress: self.start.progress,
            courses: self.start.courses.clone(),
        };
        self.restore(&start)
    }

    fn restore(&mut self, kept: &Kept) -> Result<(), String> {
        self.hand.forget();
        self.instance.resume(&kept.snapshot, kept.progress).map_err(|error| error.to_string())?;
        self.courses.clone_from(&kept.courses);
        self.hand.open(&mut self.instance);
        self.events.clear();
        Ok(())
    }

    /// The place of a body in the order of the scene.
    pub fn index_of(&self, body: BodyId) -> Option<usize> {
        self.instance.bodies.iter().position(|&other| other == body)
    }
}

//! The notched square of the catalog (`fig2-tear`, `fig2-tear-iso`, `fig2-tear-stable`) on any mesh: how it is run, and what
//! its tear leaves.

use super::super::VerifyError;
use glam::DVec2;
use rhexis::components::TearLog;
use rhexis::event::{Event, EventKind};
use rhexis::storage::{BodyId, TipKey, Tips, Triangles};
use rhexis_scene::schema::Mode;
use rhexis_scene::{Document, Instance};

/// Speed of each grip \[mm/ms\] in all of these scenes.
pub const GRIP_SPEED: f64 = 0.003;
/// Where the criterion is first looked at, as displacement of the grips \[mm\]: under a third of every tear load.
const FIRST_LOOK: f64 = 0.25;
/// Static solves \[fraction of the largest corner force\].
const EQUILIBRIUM: f64 = 1e-8;

/// What the square is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tissue {
    /// Fibres at so many degrees to x; 30° and less with a strength across them that keeps the tear on the fibre.
    Fibres(f64),
    /// No fibres, one strength.
    Isotropic,
}

impl Tissue {
    /// For tables.
    pub fn name(self) -> String {
        match self {
            Self::Fibres(degrees) => format!("{degrees}°"),
            Self::Isotropic => "isotropic".to_owned(),
        }
    }

    fn changes(self) -> Vec<String> {
        match self {
            Self::Fibres(degrees) => {
                let strength = if degrees <= 30.0 { 1.6 } else { 0.8 };
                vec![
                    format!("bodies.0.fibres.degrees={degrees}"),
                    format!("bodies.0.tearing.strength_across_fibres={strength}"),
                ]
            }
            Self::Isotropic => vec![
                "bodies.0.material={ young = 3, poisson = 0.3, thickness = 0.1 }".to_owned(),
                "bodies.0.tearing.strength_along_fibres=0.2".to_owned(),
                "bodies.0.tearing.strength_across_fibres=0.2".to_owned(),
            ],
        }
    }
}

/// One advance, from its event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Advanced {
    /// The tip.
    pub tip: TipKey,
    /// Displacement of each grip at that time \[mm\].
    pub u: f64,
    /// \[mm, rest shape\]
    pub from: DVec2,
    /// \[mm, rest shape\]
    pub to: DVec2,
    /// Unit direction that the criterion chose.
    pub direction: DVec2,
    /// Of the criterion to the runner-up.
    pub margin: f64,
    /// Whether that is under 5 %.
    pub is_ambiguous: bool,
}

/// A load at which a tear went on after it had rested.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Onset {
    /// Length torn before \[mm\], without the notch.
    pub length: f64,
    /// Displacement of each grip \[mm\] at which the criterion passed 1, interpolated within the step.
    pub u: f64,
}

/// A square while it tears.
pub struct Square {
    /// The scene.
    pub instance: Instance,
    /// All events so far.
    pub events: Vec<Event>,
    /// The loads at which the tear went on; the first is the tear load.
    pub onsets: Vec<Onset>,
    /// Edge of an equilateral triangle of the mean area \[mm\].
    pub edge: f64,
    length: f64,
    last: Option<[f64; 2]>,
}

impl Square {
    /// The catalog's scene `name` with the mesh, as a scene file writes it, the tissue, and further changes to the file.
    ///
    /// # Errors
    /// If the scene is refused.
    pub fn new(name: &str, mesh: &str, tissue: Tissue, changes: &[&str]) -> Result<Self, VerifyError> {
        let mut all = vec![format!("bodies.0.mesh={mesh}")];
        all.extend(tissue.changes());
        all.extend(changes.iter().map(|change| (*change).to_owned()));
        Self::scene(name, &all)
    }

    /// Any scene of the catalog whose first body tears, with changes to the file.
    ///
    /// # Errors
    /// If the scene is refused.
    pub fn scene(name: &str, changes: &[String]) -> Result<Self, VerifyError> {
        let mut document = Document::named(name)?;
        // Cases run side by side; a factor saves seven eighths of the time and changes nothing but digits under the tolerance.
        ["run.threads=1", "run.advanced.preconditioner=cholesky"]
            .into_iter()
            .try_for_each(|change| document.set(change))?;
        changes.iter().try_for_each(|change| document.set(change))?;
        let instance = document.scene()?.instantiate()?;
        let mut square = Self { instance, events: Vec::new(), onsets: Vec::new(), edge: 0.0, length: 0.0, last: None };
        let triangles = square.instance.simulation.world().get::<&Triangles>(square.body().entity());
        let area = triangles.map_or(f64::NAN, |t| t.rest.iter().map(|r| r.area).sum::<f64>() / t.len() as f64);
        square.edge = (area * 4.0 / 3.0_f64.sqrt()).sqrt();
        square.events.extend(square.instance.simulation.drain_events());
        Ok(square)
    }

    /// The body.
    pub fn body(&self) -> BodyId {
        self.instance.bodies[0]
    }

    /// Displacement of each grip now \[mm\].
    pub fn u(&self) -> f64 {
        GRIP_SPEED * self.instance.simulation.time()
    }

    /// The largest criterion of a tip at the current positions; zero without a tip.
    pub fn criterion(&mut self) -> f64 {
        let frame = self.instance.simulation.frame();
        frame.bodies.iter().flat_map(|body| &body.tips).map(|tip| tip.value).fold(0.0, f64::max)
    }

    /// Goes in equilibria to a load just below that of the first tear: saves the ramp.
    ///
    /// # Errors
    /// Where no equilibrium is found.
    pub fn approach(&mut self) -> Result<(), VerifyError> {
        self.stretch_to(FIRST_LOOK)?;
        // The criterion grows nearly in proportion to the load.
        for part in [0.85, 0.97] {
            let (u, c) = (self.u(), self.criterion());
            self.stretch_to(u.max(part * u / c))?;
        }
        self.last = Some([self.u(), self.criterion()]);
        Ok(())
    }

    /// Goes to equilibrium at a displacement of the grips \[mm\] without tearing.
    ///
    /// # Errors
    /// Where none is found.
    pub fn stretch_to(&mut self, u: f64) -> Result<(), VerifyError> {
        let dt = u / GRIP_SPEED - self.instance.simulation.time();
        self.instance.simulation.settle(dt.max(0.0), EQUILIBRIUM)?;
        Ok(())
    }

    /// One step as the scene says.
    ///
    /// # Errors
    /// In static mode where no equilibrium is found.
    pub fn step(&mut self) -> Result<(), VerifyError> {
        self.instance.advance()?;
        let before = self.events.len();
        self.events.extend(self.instance.simulation.drain_events());
        let now = self.u();
        let mut first = None;
        let mut length = 0.0;
        for event in &self.events[before..] {
            if let EventKind::Advanced { from, to, criterion, .. } = event.kind {
                first.get_or_insert(criterion);
                length += from.distance(to);
            }
        }
        // What the criterion has last seen: in static mode the state in which the tear rests.
        let tips = self.instance.simulation.world().get::<&Tips>(self.body().entity());
        let seen = tips.map_or(0.0, |tips| tips.criterion.iter().copied().fold(0.0, f64::max));
        let reached = first.unwrap_or(seen);
        if let Some([u, c]) = self.last
            && c < 1.0
            && reached >= 1.0
        {
            self.onsets.push(Onset { length: self.length, u: u + (now - u) * (1.0 - c) / (reached - c) });
        }
        self.length += length;
        self.last = Some([now, seen]);
        Ok(())
    }

    /// Steps until no tip is left or the scene's steps are done. Whether it is torn through.
    ///
    /// # Errors
    /// As [`step`](Self::step).
    pub fn tear_through(&mut self) -> Result<bool, VerifyError> {
        while !self.instance.is_finished() {
            self.step()?;
        }
        Ok(self.instance.tip_count() == 0)
    }

    /// Totals of the tear.
    pub fn log(&self) -> TearLog {
        self.instance
            .simulation
            .world()
            .get::<&TearLog>(self.body().entity())
            .map(|log| (*log).clone())
            .unwrap_or_default()
    }

    /// All advances in order.
    pub fn advances(&self) -> Vec<Advanced> {
        let advance = |e: &Event| match e.kind {
            EventKind::Advanced { tip, from, to, direction, margin, is_ambiguous, .. } => Some(Advanced {
                tip,
                u: e.time * GRIP_SPEED,
                from: from.truncate(),
                to: to.truncate(),
                direction: direction.truncate(),
                margin,
                is_ambiguous,
            }),
            _ => None,
        };
        self.events.iter().filter_map(advance).collect()
    }

    /// The way of one tip \[mm, rest shape\] from the end of its notch; empty where it has not advanced.
    pub fn path_of(&self, tip: TipKey) -> Vec<DVec2> {
        let advances: Vec<Advanced> = self.advances().into_iter().filter(|a| a.tip == tip).collect();
        advances.first().map(|a| a.from).into_iter().chain(advances.iter().map(|a| a.to)).collect()
    }

    /// The way of the first tip.
    pub fn path(&self) -> Vec<DVec2> {
        self.advances().first().map_or(Vec::new(), |first| self.path_of(first.tip))
    }

    /// Whether the scene is a sequence of equilibria.
    pub fn is_static(&self) -> bool {
        self.instance.run.mode == Mode::Static
    }
}

/// Length of a polyline \[mm\].
pub fn length(path: &[DVec2]) -> f64 {
    path.windows(2).map(|w| w[0].distance(w[1])).sum()
}

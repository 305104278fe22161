//! What a scene does to its bodies at given times: cuts, punctures and blades.
//!
//! An action belongs to the first step that begins at its time or later, by the number of the step: a resumed run goes on with the
//! same ones.

use super::error::{Fault, not_negative, positive};
use super::schema::BodySpec;
use super::{beginning, build};
use glam::DVec3;
use hecs::Entity;
use rhexis::components::{Blade, Path};
use rhexis::simulation::{Cut, CutError, Simulation};
use rhexis::storage::{BladeId, BodyId};
use std::fmt;

/// The most steps after which something may happen; beyond, a time is that of no run.
const LATEST: f64 = 1e15;

/// A cut that a scene asked for, and what has become of it.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct CutTold {
    /// Name of the body.
    pub body: String,
    /// Which one, as in `cuts.0`.
    pub what: String,
    /// Time of the step before which it was made \[ms\].
    #[serde(rename = "time_ms")]
    pub time: f64,
    /// Length \[mm\] that was asked for.
    #[serde(rename = "asked_mm")]
    pub asked: f64,
    /// Length \[mm, rest shape\] that was cut.
    #[serde(rename = "made_mm")]
    pub made: f64,
    /// Number of strokes: pieces of the line with a boundary or a slit between them.
    pub strokes: usize,
    /// Why it was not made.
    pub refused: Option<String>,
}

impl CutTold {
    pub(super) fn new(body: &str, what: String, time: f64, cut: &Result<Cut, CutError>) -> Self {
        let (asked, made, strokes) = cut.as_ref().map_or((0.0, 0.0, 0), |cut| (cut.asked, cut.made, cut.strokes.len()));
        let refused = cut.as_ref().err().map(ToString::to_string);
        Self { body: body.to_owned(), what, time, asked, made, strokes, refused }
    }
}

impl fmt::Display for CutTold {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { body, what, time, asked, made, strokes, refused } = self;
        write!(f, "{body}, {what} at {time} ms: ")?;
        match refused {
            Some(why) => write!(f, "not made, {why}"),
            None => write!(f, "{asked:.3} mm asked, {made:.3} mm cut in {strokes} stroke(s)"),
        }
    }
}

/// What is done to a body.
#[derive(Clone, Debug)]
enum Deed {
    Cut(Vec<DVec3>),
    Puncture { point: DVec3, direction: DVec3, length: f64 },
}

/// A deed before a step.
#[derive(Clone, Debug)]
struct Action {
    step: u64,
    /// \[ms\].
    at: f64,
    body: BodyId,
    name: String,
    what: String,
    deed: Deed,
}

/// A blade on its way.
#[derive(Clone, Debug)]
struct Drawn {
    body: BodyId,
    name: String,
    what: String,
    path: Path,
}

/// All that happens at given times.
#[derive(Clone, Debug, Default)]
pub(super) struct Timed {
    actions: Vec<Action>,
    blades: Vec<Drawn>,
}

impl Timed {
    /// Adds what a body's tables say.
    pub(crate) fn add(
        &mut self,
        simulation: &mut Simulation,
        (body, name): (BodyId, &str),
        spec: &BodySpec,
        dt: f64,
        key: &str,
    ) -> Result<(), Fault> {
        // The relative 1e-9 keeps a time that is a multiple of dt from moving on a step by rounding.
        let step = |key: String, at: f64| {
            let count = (not_negative(key.clone(), at, "ms")? / dt * (1.0 - 1e-9)).ceil();
            if count > LATEST {
                return Err(Fault::new(key, format!("{at} ms is after any run"), "give a time within the run"));
            }
            Ok(count as u64)
        };
        let action = |step, at, what, deed| Action { step, at, body, name: name.to_owned(), what, deed };
        for (i, cut) in spec.cuts.iter().enumerate() {
            let key = format!("{key}.cuts.{i}");
            let Some(at) = cut.at else { continue };
            let polyline = beginning::polyline(cut, &key)?;
            self.actions.push(action(step(format!("{key}.at"), at)?, at, format!("cuts.{i}"), Deed::Cut(polyline)));
        }
        for (i, puncture) in spec.punctures.iter().enumerate() {
            let key = format!("{key}.punctures.{i}");
            let direction = build::direction(puncture.direction.0, &format!("{key}.direction"))?;
            let length = positive(format!("{key}.length"), puncture.length, "mm")?;
            let deed = Deed::Puncture { point: puncture.point.0, direction, length };
            let at = puncture.at;
            self.actions.push(action(step(format!("{key}.at"), at)?, at, format!("punctures.{i}"), deed));
        }
        for (i, blade) in spec.blades.iter().enumerate() {
            let key = format!("{key}.blades.{i}");
            let reach = positive(format!("{key}.reach"), blade.reach, "mm")?;
            let least = positive(format!("{key}.least"), blade.least, "mm")?;
            let refused = |error| Fault::new(key.clone(), error, "give numbers of an ordinary size");
            simulation.spawn_blade(reach, least).map_err(refused)?;
            let (name, what, path) = (name.to_owned(), format!("blades.{i}"), blade.path.0.clone());
            self.blades.push(Drawn { body, name, what, path });
        }
        Ok(())
    }

    /// What comes after the last step of a run that ends at a time \[ms\].
    pub(crate) fn too_late(&self, steps: u64, end: f64) -> Vec<CutTold> {
        let late = self.actions.iter().filter(|action| action.step >= steps);
        let told = late.map(|Action { name, what, at, .. }| CutTold {
            body: name.clone(),
            what: what.clone(),
            time: *at,
            refused: Some(format!("the run ends at {end} ms")),
            ..CutTold::default()
        });
        told.collect()
    }

    /// Does what comes before a step, and moves the blades to where they are at its beginning.
    pub(crate) fn before(&self, simulation: &mut Simulation, step: u64, told: &mut Vec<CutTold>) {
        let time = simulation.time();
        for Action { body, name, what, deed, .. } in self.actions.iter().filter(|action| action.step == step) {
            let cut = match deed {
                Deed::Cut(polyline) => simulation.cut(*body, polyline),
                Deed::Puncture { point, direction, length } => simulation.puncture(*body, *point, *direction, *length),
            };
            told.push(CutTold::new(name, what.clone(), time, &cut));
        }
        if self.blades.is_empty() {
            return;
        }
        for (drawn, blade) in self.blades.iter().zip(blades(simulation)) {
            let Drawn { body, name, what, path } = drawn;
            let span = path.points.first().zip(path.points.last());
            if !span.is_some_and(|(first, last)| (first.0..=last.0).contains(&time)) {
                continue;
            }
            // A refused stroke is saved up: a longer one may pass.
            match simulation.draw_blade(blade, *body, path.at(time)) {
                Ok(None) => {}
                Ok(Some(cut)) => told.push(CutTold::new(name, what.clone(), time, &Ok(cut))),
                Err(error) => told.push(CutTold::new(name, what.clone(), time, &Err(error))),
            }
        }
    }
}

/// The blades in order of spawning.
fn blades(simulation: &Simulation) -> Vec<BladeId> {
    let mut blades: Vec<Entity> =
        simulation.world().query::<(Entity, &Blade)>().iter().map(|(entity, _)| entity).collect();
    blades.sort_unstable_by_key(|entity| entity.id());
    blades.into_iter().map(BladeId::from).collect()
}

//! The figures of a run as they stand, with the names that they have in `report.json`.

use crate::engine::Engine;
use rhexis::components::{Body, Grips, Holds, TearLog, Tearing};
use rhexis::event::Event;
use rhexis::storage::{BodyId, Tips, Triangles, Vertices};
use rhexis_scene::course::CourseReport;
use serde::Serialize;

/// The whole.
#[derive(Debug, Serialize)]
pub struct Measures {
    /// Name of the scene.
    pub scene: String,
    /// Steps of the scene done.
    pub steps: u64,
    /// Steps that it has.
    pub steps_planned: u64,
    /// Simulated time \[ms\].
    pub simulated_ms: f64,
    /// Time step \[ms\].
    pub dt_ms: f64,
    /// Whether the scene is at its end.
    pub is_finished: bool,
    /// Hash of the state, sixteen hexadecimal digits.
    pub hash: String,
    /// Length torn and cut, of all bodies \[mm, rest shape\].
    pub length_mm: f64,
    /// Tips alive, of all bodies.
    pub tips: usize,
    /// Largest criterion at a tip.
    pub criterion: f64,
    /// Amount of the hand's force on the tissue \[N\].
    pub hand_n: f64,
    /// Largest amount of a force of hand, grips and holds \[N\].
    pub force_n: f64,
    /// Figures of the last step's solver.
    pub solver: Solver,
    /// The bodies in the order of the scene.
    pub bodies: Vec<BodyFigures>,
}

/// What the solver did in the last step.
#[derive(Debug, Serialize)]
pub struct Solver {
    /// Linear iterations of all bodies.
    pub iterations: u32,
    /// Largest relative residual.
    pub residual: f64,
    /// Sub-steps undone and retried in halves.
    pub rolled_back: u32,
    /// Whether the step was given up; the last good state stands.
    pub has_failed: bool,
}

/// One body.
#[derive(Debug, Serialize)]
pub struct BodyFigures {
    /// Its name.
    pub name: String,
    /// Number of vertices.
    pub vertices: usize,
    /// Number of triangles.
    pub triangles: usize,
    /// Elastic energy \[mJ\].
    pub elastic_mj: f64,
    /// Kinetic energy \[mJ\].
    pub kinetic_mj: f64,
    /// Force of every hold on it.
    pub reactions: Vec<Force>,
    /// Force of every grip on it, the hand's among them.
    pub grips: Vec<Force>,
    /// Course of a tear about the axis of its rim; absent for a body that cannot tear or has no rim.
    pub course: Option<CourseReport>,
    /// What was torn; absent for a body that cannot tear.
    pub tear: Option<Tear>,
}

/// A force by its name.
#[derive(Debug, Serialize)]
pub struct Force {
    /// Name of the hold or grip.
    pub name: String,
    /// \[N\].
    pub force_n: [f64; 3],
}

/// What was torn.
#[derive(Debug, Serialize)]
pub struct Tear {
    /// Torn and cut \[mm, rest shape\].
    pub length_mm: f64,
    /// Tears begun.
    pub starts: u32,
    /// Edges torn.
    pub advances: u32,
    /// Tears ended.
    pub ended: u32,
    /// Pieces freed.
    pub fragments_freed: u32,
    /// Second tips of branches.
    pub branches: u32,
    /// Advances refused.
    pub refusals: u32,
    /// Tips alive.
    pub tips: usize,
}

/// An event in words.
#[derive(Debug, Serialize)]
pub struct EventFigures {
    /// Simulated time \[ms\].
    pub time_ms: f64,
    /// Name of the body.
    pub body: String,
    /// Kind, as `events.jsonl` has it, with its figures, in the engine's words.
    pub what: String,
}

impl Engine {
    /// The figures as they stand.
    pub fn measures(&mut self) -> Measures {
        let bodies: Vec<BodyFigures> =
            self.instance.bodies.clone().into_iter().map(|body| self.body_figures(body)).collect();
        let amount = |force: &Force| glam::DVec3::from_array(force.force_n).length();
        let forces = bodies.iter().flat_map(|body| body.reactions.iter().chain(&body.grips));
        let force_n = forces.map(amount).fold(0.0, f64::max);
        let report = self.instance.simulation.report();
        let of_bodies = if report.step == 0 { &[] } else { report.bodies.as_slice() };
        let solver = Solver {
            iterations: of_bodies.iter().map(|body| body.iterations).sum(),
            residual: of_bodies.iter().map(|body| body.residual).fold(0.0, f64::max),
            rolled_back: report.rolled_back,
            has_failed: report.has_failed,
        };
        let world = self.instance.simulation.world();
        let criterion = self.instance.bodies.iter().filter_map(|&body| world.get::<&Tips>(body.entity()).ok());
        let criterion = criterion.flat_map(|tips| tips.criterion.clone()).fold(0.0, f64::max);
        Measures {
            scene: self.name.clone(),
            steps: self.instance.step(),
            steps_planned: self.instance.run.steps,
            simulated_ms: self.instance.simulation.time(),
            dt_ms: self.instance.run.dt,
            is_finished: self.instance.is_finished(),
            hash: self.instance.simulation.hash().to_string(),
            length_mm: bodies.iter().filter_map(|body| body.tear.as_ref()).fold(0.0, |sum, tear| sum + tear.length_mm),
            tips: self.instance.tip_count(),
            criterion,
            hand_n: self.hand.force(&self.instance).length(),
            force_n,
            solver,
            bodies,
        }
    }

    fn body_figures(&mut self, body: BodyId) -> BodyFigures {
        let energies = self.instance.simulation.energies(body).unwrap_or_default();
        let reactions = self.instance.simulation.reactions(body).unwrap_or_default();
        let world = self.instance.simulation.world();
        let holds = world.get::<&Holds>(body.entity());
        // Before the first step there are holds but no reactions yet.
        let names = holds.iter().flat_map(|holds| &holds.groups).map(|hold| hold.name.clone());
        let forces = reactions.into_iter().map(|(_, force)| force).chain(std::iter::repeat(glam::DVec3::ZERO));
        let reactions = names.zip(forces).map(|(name, force)| Force { name, force_n: force.to_array() }).collect();
        let grips = world.get::<&Grips>(body.entity());
        let grips = grips.iter().flat_map(|grips| &grips.pinches);
        let grips = grips.map(|pinch| Force { name: pinch.name.clone(), force_n: pinch.force.to_array() }).collect();
        let tips = world.get::<&Tips>(body.entity()).map_or(0, |tips| tips.len());
        let log = world
            .get::<&TearLog>(body.entity())
            .ok()
            .filter(|log| log.length > 0.0 || world.satisfies::<&Tearing>(body.entity()));
        let tear = log.map(|log| Tear {
            length_mm: log.length,
            starts: log.nucleation_count,
            advances: log.advance_count,
            ended: log.end_count,
            fragments_freed: log.fragment_count,
            branches: log.branch_count,
            refusals: log.refusal_count,
            tips,
        });
        BodyFigures {
            name: world.get::<&Body>(body.entity()).map_or(String::new(), |body| body.name.clone()),
            vertices: world.get::<&Vertices>(body.entity()).map_or(0, |vertices| vertices.len()),
            triangles: world.get::<&Triangles>(body.entity()).map_or(0, |triangles| triangles.len()),
            elastic_mj: energies.elastic,
            kinetic_mj: energies.kinetic,
            reactions,
            grips,
            course: self.courses.iter().find(|course| course.body() == body).map(CourseReport::of),
            tear,
        }
    }

    /// Events in words.
    pub fn event_figures(&self, events: &[Event]) -> Vec<EventFigures> {
        let world = self.instance.simulation.world();
        let name = |body: BodyId| world.get::<&Body>(body.entity()).map_or(String::new(), |body| body.name.clone());
        events
            .iter()
            .map(|event| EventFigures {
                time_ms: event.time,
                body: name(event.body),
                what: format!("{:?}", event.kind),
            })
            .collect()
    }
}

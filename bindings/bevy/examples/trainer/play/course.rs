//! How far the tear has come, and what the hand has done.

use bevy::prelude::*;
use bevy_rhexis::rhexis::components::TearLog;
use bevy_rhexis::rhexis::event::Event;
use bevy_rhexis::rhexis::snapshot::Snapshot;
use bevy_rhexis::rhexis::storage::BodyId;
use bevy_rhexis::{RhexisWorld, TissueEvent};
use rhexis_scene::measures::{Outcome, TearCourse};

/// The course of the tear; none for a body without a rim.
#[derive(Resource)]
pub struct Course {
    tear: Option<TearCourse>,
    time: f64,
    /// States to go back to, one for each grasp.
    pub kept: Vec<(Snapshot, Option<TearCourse>)>,
}

/// The most states that are kept.
const MOST_KEPT: usize = 16;

impl Course {
    pub fn new(world: &RhexisWorld, body: BodyId) -> Self {
        let simulation = world.simulation();
        let tear = TearCourse::new(simulation.world(), body, simulation.time());
        Self { tear, time: simulation.time(), kept: Vec::new() }
    }

    pub fn outcome(&self) -> Outcome {
        self.tear.as_ref().map_or(Outcome::Unfinished, |tear| tear.figures().outcome)
    }

    /// Keeps the state before a grasp.
    pub fn keep(&mut self, world: &RhexisWorld) {
        if self.kept.len() == MOST_KEPT {
            self.kept.remove(0);
        }
        self.kept.push((world.simulation().snapshot(), self.tear.clone()));
    }

    /// Goes back to the state before the last grasp; whether there was one.
    pub fn undo(&mut self, world: &mut RhexisWorld) -> bool {
        let Some((snapshot, tear)) = self.kept.pop() else { return false };
        let is_back = world.simulation_mut().restore(&snapshot).is_ok();
        if is_back {
            (self.tear, self.time) = (tear, world.simulation().time());
        }
        is_back
    }

    /// The figures in lines of words.
    pub fn lines(&self, world: &RhexisWorld, body: BodyId) -> String {
        let log = world.simulation().world().get::<&TearLog>(body.entity()).map_or(0.0, |log| log.length);
        let Some(tear) = &self.tear else { return format!("tear          {log:.2} mm") };
        let figures = tear.figures();
        let outcome = match figures.outcome {
            Outcome::Unfinished => "under way",
            Outcome::Closed => "closed: well done",
            Outcome::RanOut => "run out to the rim",
            Outcome::TornOff => "the flap is torn off",
        };
        let mut lines = format!(
            "tear          {log:.2} mm, {outcome}\nround         {:.0} of 360 deg\nfarthest      {:.2} mm from the pole\n\
             grasps        {} in {:.1} s\nforce         {:.1} mN RMS, peak {:.1} mN",
            figures.completion.to_degrees(),
            figures.largest_radius,
            figures.grasps,
            figures.time * 1e-3,
            figures.force_rms * 1e3,
            figures.force_peak * 1e3,
        );
        if let Some(opening) = figures.opening {
            let (diameter, round, aside) = (opening.diameter, opening.circularity, opening.decentration);
            lines += &format!("\nopening       {diameter:.2} mm, roundness {round:.2}, {aside:.2} mm aside");
        }
        lines
    }
}

/// Takes in what the last steps did.
pub fn note(mut course: ResMut<Course>, world: Res<RhexisWorld>, mut events: MessageReader<TissueEvent>) {
    let events: Vec<Event> = events.read().map(|told| told.event.clone()).collect();
    let time = world.simulation().time();
    if time > course.time || !events.is_empty() {
        course.time = time;
        if let Some(tear) = &mut course.tear {
            tear.note(world.simulation().world(), time, &events);
        }
    }
}

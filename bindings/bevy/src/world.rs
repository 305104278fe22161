//! The engine's simulation as a resource of Bevy's.

use crate::space::Space;
use bevy::ecs::resource::Resource;
use bevy::platform::time::Instant;
use rhexis::simulation::{FixedStep, Simulation, SimulationError};
use std::time::Duration;

/// The engine's simulation, its clock and its place in Bevy's world.
#[derive(Resource)]
pub struct RhexisWorld {
    simulation: Simulation,
    clock: FixedStep,
    space: Space,
    is_interpolated: bool,
    revision: u64,
    step_time: Duration,
}

impl RhexisWorld {
    /// A simulation in steps of `dt` \[ms\], at most `most` of them per frame.
    ///
    /// # Errors
    /// For a `dt` that is not positive and finite, and for no steps at all.
    pub fn new(simulation: Simulation, dt: f64, most: u32) -> Result<Self, SimulationError> {
        Ok(Self {
            simulation,
            clock: FixedStep::new(dt, most)?,
            space: Space::default(),
            is_interpolated: true,
            revision: 0,
            step_time: Duration::ZERO,
        })
    }

    /// The same, lying elsewhere in Bevy's world.
    pub fn within(mut self, space: Space) -> Self {
        self.space = space;
        self
    }

    /// The same, shown between the last two steps or as the last step has left it.
    pub fn interpolated(mut self, is_interpolated: bool) -> Self {
        self.is_interpolated = is_interpolated;
        self
    }

    /// The simulation, to look at.
    pub fn simulation(&self) -> &Simulation {
        &self.simulation
    }

    /// The simulation, for all calls of the engine. Meshes are written anew after it.
    pub fn simulation_mut(&mut self) -> &mut Simulation {
        self.revision += 1;
        &mut self.simulation
    }

    /// The clock: length of a step \[ms\], where the frame is between two steps, time lost.
    pub fn clock(&self) -> &FixedStep {
        &self.clock
    }

    /// Where the engine's space lies in Bevy's world.
    pub fn space(&self) -> &Space {
        &self.space
    }

    /// Whether meshes are shown between the last two steps.
    pub fn is_interpolated(&self) -> bool {
        self.is_interpolated
    }

    /// Wall time of the last step.
    pub fn step_time(&self) -> Duration {
        self.step_time
    }

    /// The simulation for what leaves positions as they are.
    pub(crate) fn quietly(&mut self) -> &mut Simulation {
        &mut self.simulation
    }

    /// How often the simulation was handed out.
    pub(crate) fn revision(&self) -> u64 {
        self.revision
    }

    /// How far \[ms\] before the last step's end the frame is.
    pub(crate) fn behind(&self) -> f64 {
        if self.is_interpolated { (1.0 - self.clock.alpha()) * self.clock.dt() } else { 0.0 }
    }

    pub(crate) fn steps_after(&mut self, elapsed: f64) -> Result<u32, SimulationError> {
        self.clock.steps_after(elapsed)
    }

    pub(crate) fn step(&mut self) -> Result<(), SimulationError> {
        let begin = Instant::now();
        let outcome = self.simulation.step(self.clock.dt()).map(|_| ());
        self.step_time = begin.elapsed();
        outcome
    }
}

//! Steps of one length under a loop of any rate.

use super::{Simulation, SimulationError};
use crate::settings::OutOfRange;
use crate::storage::BodyId;
use glam::DVec3;

/// Turns the time between pictures into steps of one length, and places a picture between the last two steps: the tissue
/// behaves the same at any rate of pictures, and moves smoothly.
///
/// ```
/// use rhexis::{settings::Settings, simulation::{FixedStep, Simulation}};
///
/// let mut simulation = Simulation::new(Settings::default())?;
/// let mut clock = FixedStep::new(5.0, 4)?;
/// // In the loop, with the time of the last picture:
/// for _ in 0..clock.steps_after(16.7)? {
///     // Tools are moved here.
///     simulation.step(clock.dt())?;
/// }
/// assert_eq!(simulation.time(), 15.0);
/// assert!((clock.alpha() - 1.7 / 5.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FixedStep {
    dt: f64,
    most: u32,
    owed: f64,
    lost: f64,
}

impl FixedStep {
    /// Steps of `dt` \[ms\], at most `most` per picture: where they do not suffice the simulation falls behind instead of taking
    /// ever longer.
    ///
    /// # Errors
    /// For a `dt` that is not a positive finite number, and for no steps at all.
    ///
    /// # Examples
    /// ```
    /// use rhexis::prelude::*;
    ///
    /// let mut clock = FixedStep::new(5.0, 4)?;
    /// assert_eq!(clock.steps_after(16.0)?, 3);
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn new(dt: f64, most: u32) -> Result<Self, SimulationError> {
        if !(dt > 0.0 && dt.is_finite()) {
            return Err(SimulationError::TimeStep(dt));
        }
        OutOfRange::unless(most > 0, "the steps per picture", f64::from(most), "it must be 1 or more")?;
        Ok(Self { dt, most, owed: 0.0, lost: 0.0 })
    }

    /// How many steps are due after `elapsed` \[ms\] more; the caller makes them. One that fails counts as made: its report and event
    /// say so.
    ///
    /// # Errors
    /// For a time that is negative or not finite; nothing has changed then.
    pub fn steps_after(&mut self, elapsed: f64) -> Result<u32, SimulationError> {
        let is_right = elapsed >= 0.0 && elapsed.is_finite();
        OutOfRange::unless(
            is_right,
            "the time since the last picture",
            elapsed,
            "it must be zero or more, and finite",
        )?;
        self.owed += elapsed;
        let mut steps = 0;
        while self.owed >= self.dt && steps < self.most {
            self.owed -= self.dt;
            steps += 1;
        }
        // Time beyond the maximum is dropped; the part of a step stays, so that pictures do not jump.
        let part = self.owed % self.dt;
        self.lost += self.owed - part;
        self.owed = part;
        Ok(steps)
    }

    /// Where the picture is between the last two steps: 0 at the one before, towards 1 at the last.
    pub fn alpha(&self) -> f64 {
        self.owed / self.dt
    }

    /// Length of a step \[ms\].
    pub fn dt(&self) -> f64 {
        self.dt
    }

    /// Time \[ms\] that was dropped so far because the steps did not suffice.
    pub fn lost(&self) -> f64 {
        self.lost
    }

    /// Positions \[mm\] of a body for the picture, in the rows that it has now: a vertex that a tear or refinement has just made
    /// comes from between its parents. The buffer is filled anew and keeps its memory.
    ///
    /// # Errors
    /// If there is no such body.
    pub fn positions(
        &self,
        simulation: &mut Simulation,
        body: BodyId,
        into: &mut Vec<DVec3>,
    ) -> Result<(), SimulationError> {
        simulation.view(body)?.positions_before((1.0 - self.alpha()) * self.dt, into);
        Ok(())
    }
}

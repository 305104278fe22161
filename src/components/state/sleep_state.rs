//! Whether a body sleeps, and the loads that it sleeps under.

use crate::components::Obstacle;
use glam::DVec3;

/// Sleep state of a body: whether it sleeps, the loads when it fell asleep, and buffers of the trial solves. *State.*
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct SleepState {
    pub(crate) is_asleep: bool,
    /// Steps in which it has hardly moved.
    pub(crate) quiet_steps: u32,
    /// How many of these the next solves wait for: twice as many each time that they find too much left.
    pub(crate) wait: u32,
    /// The values of everything that drives the body, as they were when it fell asleep.
    pub(crate) driven: Vec<f64>,
    /// The obstacles, as they were then; none for a body that feels none.
    pub(crate) obstacles: Vec<Obstacle>,
    /// A ball around the body \[mm\].
    pub(crate) ball: (DVec3, f64),
    /// The first guess of the step, while the solves take its place.
    pub(crate) first_guess: Vec<DVec3>,
    /// Per vertex, how far it would still move \[mm\].
    pub(crate) left: Vec<f64>,
}

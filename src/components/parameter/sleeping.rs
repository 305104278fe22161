//! Lets a body that is at rest fall asleep.

use crate::components::BodyError;
use crate::components::Obstacle;
use crate::components::check::{Check, Host, MOST_COUNTED, positive};
use glam::DVec3;

/// Lets a body fall asleep: while it sleeps, no system runs on it. A body without this component never sleeps. *Parameter*
/// `strain`, `steps`; the rest follows from them.
///
/// It falls asleep where its remaining motion is below `strain`. Its velocity does not decide: it is small at a turning point
/// as well. Two linear solves do, of the remaining imbalance of its forces and of its momentum, over its stiffness. It stays awake
/// while a tip, or a place where it may start to tear, is so near its strength that this motion could tear it. It also stays awake
/// while its energy is audited, and, if nothing holds it, while it drifts.
///
/// It wakes when anything that acts on it changes:
/// - the motion of a hold or of closed forceps, and forceps that close or open;
/// - a load, a pressure, or an obstacle within its reach;
/// - a cut or a static solve;
/// - [`Simulation::entity_mut`] on it, and [`Simulation::world_mut`], which might change anything.
///
/// [`Simulation::wake`] wakes it in any case; a component changed through [`Simulation::world`], which is there to be looked at, is
/// not noticed.
///
/// [`Simulation::entity_mut`]: crate::simulation::Simulation::entity_mut
/// [`Simulation::world`]: crate::simulation::Simulation::world
/// [`Simulation::world_mut`]: crate::simulation::Simulation::world_mut
/// [`Simulation::wake`]: crate::simulation::Simulation::wake
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Sleeping {
    /// Largest strain, in any triangle, of the motion that a body gives up when it falls asleep, > 0; a triangle of height h
    /// moves by this times h at most. 1e-5 by default, under the thousandth of the working strain that a dynamic step with
    /// default settings solves to. With 1e-3 it is seen.
    pub strain: f64,
    /// Steps for which the body must have moved by less than that before the solves are made, ≥ 1; 10 by default.
    pub steps: u32,
    /// Sleep state.
    pub state: SleepState,
}

impl Default for Sleeping {
    fn default() -> Self {
        Self { strain: 1e-5, steps: 10, state: SleepState::default() }
    }
}

impl Sleeping {
    /// Whether the body is asleep.
    pub fn is_asleep(&self) -> bool {
        self.state.is_asleep
    }

    /// Wakes the body; whether it was asleep.
    pub(crate) fn wake(&mut self) -> bool {
        self.state.quiet_steps = 0;
        self.state.wait = self.steps;
        std::mem::take(&mut self.state.is_asleep)
    }
}

/// Sleep state of a body: whether it sleeps, the loads when it fell asleep, and buffers of the trial solves. *State*, rebuilt by itself.
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

impl Check for Sleeping {
    fn check(&self, _: &Host<'_>) -> Result<(), BodyError> {
        positive("Sleeping", "the strain of sleep", self.strain)?;
        let counts = [self.steps, self.state.quiet_steps, self.state.wait];
        let is_right = counts.iter().all(|&count| u64::from(count) <= MOST_COUNTED);
        let what = "its steps count what no run can do: they must be at most 1073741824";
        is_right.then_some(()).ok_or(BodyError::Contradiction { component: "Sleeping", what })
    }
}

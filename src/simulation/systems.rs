//! Systems of the caller's own.

use super::Simulation;
use crate::systems::StepContext;
use crate::systems::step::schedule::{BadPlace, Place};
use hecs::World;

impl Simulation {
    /// Puts a system of your own into the step: a function of the world and the step's context that returns on how many bodies it
    /// ran. Reports list it with its time. It works on components of your own, which a body gets by
    /// [`Membrane::with`](crate::membrane::Membrane::with) or through [`world_mut`](Self::world_mut), and on those of the engine:
    ///
    /// | place | read | may be written |
    /// |---|---|---|
    /// | before `hold` | everything, as the last step left it | parameters: holds, grips, loads, pressure, gravity, springs |
    /// | after `assembly`, `contact` or any other before `sleep` | positions, [`Frames`](crate::components::Frames), the step | added to: [`Forces::nodal`](crate::components::Forces), and [`ExternalStiffness::block`](crate::components::ExternalStiffness) by −∂f/∂x, symmetric and positive semidefinite |
    /// | after `criterion` | the stresses that tips are judged by | [`TearDecisions`](crate::components::TearDecisions), to forbid an advance |
    /// | after `split` | everything, as the step leaves it | components of your own |
    ///
    /// Never written: positions and velocities within a step, the columns and rows of the tables, derived components. A body
    /// has no [`ExternalStiffness`](crate::components::ExternalStiffness) unless it carries springs, grips, drag or contact, or is
    /// given one: `membrane.with(ExternalStiffness::default())`. Without stiffness a force is explicit, and stable only for steps
    /// short against the masses it acts on.
    ///
    /// A system that adds forces leaves out the bodies whose
    /// [`SolveResult::is_done`](crate::components::SolveResult) says that they are done or asleep; a force
    /// that changes while a body sleeps does not wake it. It may run several times in a step: once per Newton
    /// iteration, per stage, and each time a step is redone or halved. While a body whose step has failed is retried by itself the
    /// others have no [`SolveResult`](crate::components::SolveResult), so that a query for it leaves them out. A component that
    /// refers to vertices keeps their keys, as rows move. Forces of your own are in no
    /// [`EnergyAudit`](crate::components::EnergyAudit).
    ///
    /// A number that is not finite, written by a system, ends like any other: the step is undone, retried in halves, and given up
    /// with the last good state standing. A panic goes through to whoever called the step, and leaves it half done.
    ///
    /// # Errors
    /// For a name that is taken, and for a place that there is not, with the nearest that there is.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// use rhexis::schedule::Place;
    ///
    /// simulation.insert_system(Place::After("contact"), "count", |world, _| world.len() as usize)?;
    /// simulation.step(5.0)?;
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn insert_system(
        &mut self,
        place: Place<'_>,
        name: &'static str,
        system: impl FnMut(&mut World, &StepContext) -> usize + Send + Sync + 'static,
    ) -> Result<(), BadPlace> {
        self.schedule.insert(place, name, system)
    }

    /// Takes a system out that [`insert_system`](Self::insert_system) has put in.
    ///
    /// # Errors
    /// For a name that there is not, and for a system of the engine.
    pub fn remove_system(&mut self, name: &str) -> Result<(), BadPlace> {
        self.schedule.remove(name)
    }
}

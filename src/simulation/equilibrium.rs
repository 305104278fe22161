//! Static solves: equilibria, and the linear response.

use super::{Simulation, SimulationError, advice};
use crate::components::SolverScratch;
use crate::replay::Input;
use crate::report::Report;
use crate::settings::{LinearParams, OutOfRange};
use crate::systems::StepContext;
use crate::systems::forces;
use crate::systems::step::faults::is_finite;
use crate::systems::step::phases::STATIC_PHASES;
use crate::systems::step::run::{Excluded, Running};

impl Simulation {
    /// Moves time on by `dt` \[ms\] and finds the static equilibrium there by Newton's method with the exact tangent. It stops at
    /// `tolerance`, the largest free nodal imbalance over the largest corner force, or at the limit of rounding.
    ///
    /// # Errors
    /// For a `dt` or a tolerance that is negative or not finite, and where no equilibrium is found; the state is then the one
    /// before, and time has not moved.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// simulation.settle(0.0, 1e-9)?;
    /// assert!(simulation.report().bodies[0].is_converged);
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn settle(&mut self, dt: f64, tolerance: f64) -> Result<&Report, SimulationError> {
        self.note(|| Input::Settle { dt, tolerance });
        self.find_equilibrium(dt, tolerance)?;
        forces::end(&mut self.world, true);
        self.use_forces_up();
        Ok(&self.report)
    }

    /// As [`settle`](Self::settle), but for the history of tissue that relaxes, which goes on when the tears at this equilibrium are made.
    pub(super) fn find_equilibrium(&mut self, dt: f64, tolerance: f64) -> Result<&Report, SimulationError> {
        if !(dt >= 0.0 && (self.report.time + dt).is_finite()) {
            return Err(SimulationError::TimeStep(dt));
        }
        OutOfRange::unless_tolerance("the tolerance", tolerance)?;
        self.validate_dirty()?;
        self.begin_report();
        let iterations = self.settings.advanced.static_iterations.max(2);
        let (time, preconditioner) = (self.report.time + dt, self.settings.advanced.preconditioner);
        let step = StepContext::of_static_solve(dt, time, tolerance, iterations, preconditioner);
        self.solve_statically(&step)?;
        let is_finite = is_finite(&mut self.world) && self.have_finite_energies();
        let failed = self.report.bodies.iter().filter(|b| !(b.is_converged && is_finite));
        let worst = failed.map(|b| (b.imbalance, b.newton_iterations, b.body));
        if let Some((imbalance, iterations, body)) = worst.max_by(|a, b| a.0.total_cmp(&b.0)) {
            let least = self.world.get::<&SolverScratch>(body.entity()).map_or(0.0, |scratch| scratch.least_imbalance);
            let compression = self.compression(body);
            self.undo(&step);
            let (time, imbalance) = (step.time, imbalance.min(f64::MAX));
            let is_used_up = iterations >= step.newton_iterations;
            return Err(match self.advice(body) {
                None if is_used_up && imbalance < least => {
                    SimulationError::IterationsUsedUp { time, imbalance, least, iterations }
                }
                advice => {
                    let advice = advice.or(compression).unwrap_or_else(|| advice::in_general(is_used_up));
                    SimulationError::NoEquilibrium { time, imbalance, iterations, advice }
                }
            });
        }
        self.report.time = step.time;
        self.rest_obstacles();
        self.collect_events();
        Ok(&self.report)
    }

    /// Moves time on by `dt` \[ms\] and answers the loads and prescribed motion there linearly: one increment with the exact
    /// tangent of the present state, without inertia. From rest this is the solution of linear elasticity on the mesh.
    ///
    /// # Errors
    /// For a `dt` that is negative or not finite, and where the linear solve does not reach a residual of 1e-13; the state is
    /// then the one before, and time has not moved.
    pub fn linear_response(&mut self, dt: f64) -> Result<&Report, SimulationError> {
        self.note(|| Input::LinearResponse { dt });
        if !(dt >= 0.0 && (self.report.time + dt).is_finite()) {
            return Err(SimulationError::TimeStep(dt));
        }
        self.validate_dirty()?;
        self.begin_report();
        let linear = LinearParams::by_residual(1e-13, 50_000);
        let (time, preconditioner) = (self.report.time + dt, self.settings.advanced.preconditioner);
        let step = StepContext { linear, ..StepContext::of_static_solve(dt, time, 0.0, 1, preconditioner) };
        self.solve_statically(&step)?;
        let residual = self.report.bodies.iter().map(|b| b.residual).max_by(f64::total_cmp).unwrap_or(0.0);
        let has_failed = residual.is_nan() || residual > linear.tolerance;
        if has_failed || !is_finite(&mut self.world) {
            self.undo(&step);
            return Err(SimulationError::NoLinearAnswer { time: step.time, residual });
        }
        forces::end(&mut self.world, true);
        self.report.time = step.time;
        self.note_contact_forces();
        self.use_forces_up();
        Ok(&self.report)
    }

    /// Runs a static solve, and tells of it in the report.
    fn solve_statically(&mut self, step: &StepContext) -> Result<(), SimulationError> {
        let Self { world, pool, schedule, report, spare, .. } = self;
        let mut running = Running { schedule, report, spare };
        // Its phases check nothing, so that nothing is put aside.
        pool.run(|| running.step(world, step, STATIC_PHASES, &mut Excluded::new()));
        self.check_callers(step)?;
        self.finish_report();
        Ok(())
    }

    /// Whether the energies of all bodies, and the energies that their audits have put in, are finite.
    fn have_finite_energies(&mut self) -> bool {
        self.bodies().into_iter().all(|body| {
            // Whoever looks next finds the stresses of the answer.
            let _ = self.refresh(body);
            let is_stored = self.energies(body).is_ok_and(|energies| (energies.elastic + energies.kinetic).is_finite());
            let balance = self.energy_balance(body).ok().flatten();
            is_stored && balance.is_none_or(|balance| balance.terms().iter().all(|(_, term)| term.is_finite()))
        })
    }
}

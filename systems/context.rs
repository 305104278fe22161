//! What every system of a step is told.

use crate::settings::{LinearParams, Precision, Preconditioner, Settings, Tangent};

/// One step, or one Newton iteration of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepContext {
    /// Time step \[ms\], > 0; in a static solve the time by which the loads move on.
    pub dt: f64,
    /// Time at the end of the step \[ms\]: where prescribed motion and loads are taken.
    pub time: f64,
    /// Equilibrium without inertia, damping and drag.
    pub is_static: bool,
    /// Taken up again after tears have advanced: no new allowance for tips.
    pub is_resumed: bool,
    /// Tangent of the solves.
    pub tangent: Tangent,
    /// Limits of each linear solve.
    pub linear: LinearParams,
    /// What makes its iterations few.
    pub preconditioner: Preconditioner,
    /// What its iterations compute in.
    pub precision: Precision,
    /// Newton iterations at the most.
    pub newton_iterations: u32,
    /// Imbalance, as a fraction of the largest corner force, at which Newton stops.
    pub newton_tolerance: f64,
}

impl StepContext {
    /// A dynamic step of `dt` \[ms\] that ends at `time` \[ms\].
    pub fn of_step(settings: &Settings, dt: f64, time: f64) -> Self {
        Self {
            dt,
            time,
            is_static: false,
            is_resumed: false,
            tangent: settings.tangent,
            linear: settings.linear,
            preconditioner: settings.preconditioner,
            precision: settings.precision,
            newton_iterations: settings.newton_iterations.max(1),
            newton_tolerance: settings.newton_tolerance,
        }
    }

    /// A static solve by Newton's method with the exact tangent, under the loads of `time` \[ms\].
    pub fn of_static_solve(
        dt: f64,
        time: f64,
        tolerance: f64,
        iterations: u32,
        preconditioner: Preconditioner,
    ) -> Self {
        Self {
            dt: if dt > 0.0 { dt } else { 1.0 },
            time,
            is_static: true,
            is_resumed: false,
            tangent: Tangent::Exact,
            linear: LinearParams::by_residual(1e-12, 20_000),
            preconditioner,
            precision: Precision::Double,
            newton_iterations: iterations,
            newton_tolerance: tolerance,
        }
    }

    /// 1/dt² \[1/ms²\], the factor of the mass; zero in a static solve.
    pub fn inertia(&self) -> f64 {
        if self.is_static { 0.0 } else { 1.0 / (self.dt * self.dt) }
    }

    /// 1/dt \[1/ms\], the factor of damping and drag; zero in a static solve.
    pub fn rate(&self) -> f64 {
        if self.is_static { 0.0 } else { 1.0 / self.dt }
    }
}

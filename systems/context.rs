//! The context that every system of a step receives: its length, its limits and its formula. By the formula the displacement u
//! since its start gives the velocity and the inertial terms.
//!
//! Every formula has the form v = (u − a)/s and M·u/s² = f + M·b with an effective time step s and knowns a, b of its own. Backward Euler: s = Δt.
//! TR-BDF2 (Bank et al. 1985; Hosea, Shampine 1996): both stages have s = (1 − 1/√2)·Δt, so that one matrix serves both. The
//! first is the trapezoidal rule from 0 to γ·Δt, the second the backward difference formula through both and Δt.

use crate::components::{Increment, SolveResult};
use crate::settings::ablation::Part;
use crate::settings::{Integrator, LinearParams, Precision, Preconditioner, Settings, Tangent};
use glam::DVec3;
use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

/// Relative residual of the solves of a fallback sub-step.
const TIGHT: f64 = 1e-8;

/// Fraction of the step at which the first stage of TR-BDF2 ends: γ = 2 − √2, for which both stages have one effective time step.
const GAMMA: f64 = 2.0 - SQRT_2;

/// The effective time step over Δt: γ/2 = (1 − γ)/(2 − γ).
const EFFECTIVE_DT: f64 = 1.0 - FRAC_1_SQRT_2;

/// Weight 1/(γ·(2 − γ)) of the middle in the second stage; that of the start is one less, (1 − γ)²/(γ·(2 − γ)), and negative.
pub const MIDDLE: f64 = 0.5 * (1.0 + SQRT_2);

/// The second stage's length over the first's.
pub const SECOND_STAGE: f64 = 1.0 / GAMMA - 1.0;

/// The formula of time that an evaluation or a solve obeys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Formula {
    /// Backward Euler over the whole step.
    #[default]
    BackwardEuler,
    /// None yet: the forces at the start of a step of two stages.
    Start,
    /// The first stage of TR-BDF2.
    Trapezoidal,
    /// The second stage of TR-BDF2, which ends the step.
    SecondBackwardDifference,
}

/// One step, or a stage or one Newton iteration of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepContext {
    /// Time step \[ms\], > 0; in a static solve the time by which the loads move on. The whole step in its stages too.
    pub dt: f64,
    /// Time at the end of the step or stage \[ms\]: where prescribed motion and loads are taken.
    pub time: f64,
    /// Time integration formula of the stage that is evaluated or solved.
    pub formula: Formula,
    /// Equilibrium without inertia, damping and drag.
    pub is_static: bool,
    /// Static solve at the time of the state before: no time passes.
    pub is_instant: bool,
    /// Redone after tears have advanced.
    pub is_resumed: bool,
    /// Retried part of a step that has failed: a few vertices that would create energy are relaxed locally.
    pub is_retried: bool,
    /// Fallback sub-step: no shorter one is tried, and a body that would create energy takes a fraction of its increment.
    pub is_fallback: bool,
    /// The corrector: a second solve of the step, which decides on tears that are due.
    pub is_corrector: bool,
    /// Newton corrections left, for bodies that would create energy.
    pub newton_corrections: u32,
    /// Whether this solve is a Newton correction.
    pub is_correction: bool,
    /// Tangent of the solves.
    pub tangent: Tangent,
    /// Limits of each linear solve.
    pub linear: LinearParams,
    /// Position error at which a dynamic solve may stop, as a fraction of the mean edge; infinite for none.
    pub position_tolerance: f64,
    /// Maximum re-solves per step while a tear may still advance.
    pub max_tear_passes: u32,
    /// Work that a body may take in the whole step, of which this may be a part.
    pub budget: Option<u32>,
    /// Number of later solves for which the budget reserves work.
    pub reserved: u32,
    /// Preconditioner of its solves.
    pub preconditioner: Preconditioner,
    /// Precision of its iterations.
    pub precision: Precision,
    /// Maximum Newton iterations.
    pub newton_iterations: u32,
    /// Imbalance, as a fraction of the largest corner force, at which Newton stops.
    pub newton_tolerance: f64,
    /// Part that a measurement leaves out.
    pub without: Option<Part>,
}

impl StepContext {
    /// A dynamic step of `dt` \[ms\] that ends at `time` \[ms\]; its last stage where it has two.
    pub fn of_step(settings: &Settings, dt: f64, time: f64) -> Self {
        Self {
            dt,
            time,
            formula: match settings.advanced.integrator {
                Integrator::BackwardEuler => Formula::BackwardEuler,
                Integrator::TrBdf2 => Formula::SecondBackwardDifference,
            },
            is_static: false,
            is_instant: false,
            is_resumed: false,
            is_retried: false,
            is_fallback: false,
            is_corrector: false,
            newton_corrections: settings.advanced.newton_corrections,
            is_correction: false,
            tangent: settings.advanced.tangent,
            linear: settings.advanced.linear,
            position_tolerance: settings.position_tolerance,
            max_tear_passes: settings.max_tear_passes,
            budget: settings.budget,
            reserved: 0,
            preconditioner: settings.advanced.preconditioner,
            precision: settings.advanced.precision,
            newton_iterations: settings.advanced.newton_iterations.max(1),
            newton_tolerance: settings.advanced.newton_tolerance,
            without: settings.without,
        }
    }

    /// Whether the step has a part that a measurement may leave out.
    pub fn has(&self, part: Part) -> bool {
        self.without != Some(part)
    }

    /// This part of a step, with work for `solves` more reserved after it.
    pub fn before(self, solves: u32) -> Self {
        Self { reserved: self.reserved + solves, ..self }
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
            formula: Formula::BackwardEuler,
            is_static: true,
            is_instant: !(dt > 0.0),
            is_resumed: false,
            is_retried: false,
            is_fallback: false,
            is_corrector: false,
            newton_corrections: 0,
            is_correction: false,
            tangent: Tangent::Exact,
            linear: LinearParams::by_residual(1e-12, 20_000),
            position_tolerance: f64::INFINITY,
            max_tear_passes: 0,
            budget: None,
            reserved: 0,
            preconditioner,
            precision: Precision::Double,
            newton_iterations: iterations,
            newton_tolerance: tolerance,
            without: None,
        }
    }

    /// The fallback sub-step, as dissipative as can be: one tight solve by backward Euler along the rotated tangent. A body that would still
    /// create energy takes a fraction of its increment.
    pub fn fallback(self) -> Self {
        let tolerance = self.linear.tolerance.min(TIGHT);
        Self {
            formula: Formula::BackwardEuler,
            is_fallback: true,
            newton_corrections: 0,
            tangent: Tangent::Rotated,
            linear: LinearParams { tolerance, ..self.linear },
            position_tolerance: f64::INFINITY,
            newton_iterations: 1,
            ..self
        }
    }

    /// Whether a stage comes before this one.
    pub fn has_first_stage(&self) -> bool {
        self.formula == Formula::SecondBackwardDifference
    }

    /// The evaluation at the start of a step of two stages.
    pub fn at_start(&self) -> Self {
        Self { formula: Formula::Start, time: self.time - self.dt, ..*self }
    }

    /// The first of its two stages.
    pub fn first_stage(&self) -> Self {
        Self { formula: Formula::Trapezoidal, time: self.time - self.dt + GAMMA * self.dt, ..self.before(1) }
    }

    /// Time \[ms\] from the start of the step to the end of this stage.
    pub fn stage_dt(&self) -> f64 {
        if self.formula == Formula::Trapezoidal { GAMMA * self.dt } else { self.dt }
    }

    /// Time \[ms\] since the start of the step over which tissue relaxes until this evaluation.
    pub fn relaxed_span(&self) -> f64 {
        if self.is_instant || self.formula == Formula::Start { 0.0 } else { self.stage_dt() }
    }

    /// Time at the end of the whole step \[ms\].
    pub fn end(&self) -> f64 {
        self.time + (self.dt - self.stage_dt())
    }

    /// Effective time step s of the formula \[ms\].
    fn effective_dt(&self) -> f64 {
        if self.formula == Formula::BackwardEuler { self.dt } else { EFFECTIVE_DT * self.dt }
    }

    /// 1/s² \[1/ms²\], the factor of the mass; zero in a static solve.
    pub fn inertia(&self) -> f64 {
        if self.is_static { 0.0 } else { 1.0 / (self.effective_dt() * self.effective_dt()) }
    }

    /// 1/s \[1/ms\], the factor of damping and drag; zero in a static solve.
    pub fn inv_effective_dt(&self) -> f64 {
        if self.is_static { 0.0 } else { 1.0 / self.effective_dt() }
    }

    /// Displacement of vertex `v` over the effective step at its velocity \[mm\]: times [`inv_effective_dt`](Self::inv_effective_dt) that velocity.
    #[inline]
    pub fn velocity_displacement(&self, increment: &Increment, v: usize) -> DVec3 {
        match self.formula {
            Formula::BackwardEuler => increment.displacement[v],
            Formula::Start => increment.start_velocity[v] * self.effective_dt(),
            Formula::Trapezoidal => increment.displacement[v] - increment.start_velocity[v] * self.effective_dt(),
            Formula::SecondBackwardDifference => increment.displacement[v] - increment.middle_displacement[v] * MIDDLE,
        }
    }

    /// Inertial force of vertex `v` over its mass \[mm/ms²\]: the known term of the formula less the term of its displacement.
    #[inline]
    pub fn momentum(&self, increment: &Increment, v: usize) -> DVec3 {
        let (inertia, inv_effective_dt) = (self.inertia(), self.inv_effective_dt());
        let known = match self.formula {
            Formula::BackwardEuler => increment.start_velocity[v] * inv_effective_dt,
            Formula::Start => DVec3::ZERO,
            Formula::Trapezoidal => {
                increment.start_velocity[v] * (2.0 * inv_effective_dt) + increment.start_acceleration[v]
            }
            Formula::SecondBackwardDifference => {
                let [start, middle] = [increment.start_velocity[v], increment.middle_velocity[v]];
                increment.middle_displacement[v] * (MIDDLE * inertia)
                    + (middle * MIDDLE - start * (MIDDLE - 1.0)) * inv_effective_dt
            }
        };
        known - increment.displacement[v] * inertia
    }

    /// Fraction of the tissue's own least shear stiffness that the rotated tangent has beyond the geometric one. One solve by backward
    /// Euler is stable down to half of the true stiffness. One per stage of TR-BDF2 is stable only where nothing is missing: at 0.9
    /// of it a wave grows by 1.3 % per step, at two thirds by 15 %. The geometric stiffness is that of one kind of wave; the whole
    /// of the shear stiffness covers the others. Tuned on `rhexis verify stability`: half of it is just too little at 30 % stretch
    /// along fibres a hundred times as stiff.
    pub fn reserve(&self) -> f64 {
        if self.formula == Formula::BackwardEuler { Self::RESERVE_OF_EULER } else { 1.0 }
    }

    /// [`reserve`](Self::reserve) of backward Euler.
    pub const RESERVE_OF_EULER: f64 = -0.5;

    /// Whether the residual of a solve has to be exact: a balance of energies or the end of a stage counts it.
    pub fn asks_for_exact_residual(&self, is_audited: bool) -> bool {
        is_audited || self.formula != Formula::BackwardEuler && self.newton_iterations == 1
    }

    /// The tangent of a body's next solve. The projected and the weighted one come after a rotated one; and it goes on where an exact one was
    /// indefinite. Where it is to be rotated, corrector solves take the weighted one, and so does the first solve after a glide. Those of tips that
    /// glide take the projected one: the release beside slack lips then settles in fewer of them.
    pub fn tangent_of(&self, result: &SolveResult) -> Tangent {
        match self.tangent {
            Tangent::Exact if result.fell_back => Tangent::Projected,
            Tangent::Projected | Tangent::Weighted if result.newton_iterations == 0 => Tangent::Rotated,
            Tangent::Rotated if self.is_fallback => Tangent::Rotated,
            Tangent::Rotated if self.is_corrector && result.has_gliding_tips => Tangent::Projected,
            Tangent::Rotated if self.is_corrector => Tangent::Weighted,
            Tangent::Rotated if result.follows_glide && self.newton_iterations == 1 => Tangent::Weighted,
            tangent => tangent,
        }
    }
}

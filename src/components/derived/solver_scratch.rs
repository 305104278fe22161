//! Solver state of a body: vectors of the linear solve, its result, and the sums of the energy guard.

use crate::components::{Allowed, Fault, FreeAxes, Readings, Stops};
use crate::settings::Tangent;
use glam::{DVec2, DVec3};

/// What a step of several Newton iterations or of two stages is judged by at its end; empty in others.
#[derive(Clone, Debug, Default)]
pub struct StepAccount {
    /// The body's own forces \[N\], of stress, damping and bending, at the last evaluation.
    pub own: Vec<DVec3>,
    /// Those at the start of a step of two stages and, in its second, with those at the end of the first, less the imbalance there
    /// along free axes. In a step that is redone, the displacement \[mm\] from where it is.
    pub earlier: Vec<DVec3>,
    /// Energy stored and of motion \[mJ\] at the start, or where the step is redone, until that is judged.
    pub energy: Option<f64>,
}

/// Vectors of the linear solve, one entry per vertex, and what it reached.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct SolverScratch {
    /// 1 along free axes, 0 along prescribed ones.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub free: FreeAxes,
    /// Motions of guided vertices, which have no free axes for them.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub allowed: Box<Allowed>,
    /// Residual \[N\].
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub residual: Vec<DVec3>,
    /// Right-hand side \[N\] of a solve in double precision that may have to begin anew.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub rhs: Vec<DVec3>,
    /// Search direction \[mm\].
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub direction: Vec<DVec3>,
    /// Operator times direction \[N\], and in turn the preconditioned residual \[mm\].
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub product: Vec<DVec3>,
    /// Inverse diagonal blocks \[mm/N\], symmetric: xx, yy, zz and yz, zx, xy; where nothing is free along z xx, yy, xy and nothing.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub inverse_block: [Vec<DVec3>; 2],
    /// Sums per chunk of rows.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub partials: Vec<f64>,
    /// Pairs of sums per chunk of rows.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub pairs: Vec<DVec2>,
    /// What a step of several iterations is judged by.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub account: Box<StepAccount>,
    /// Where solves have stopped because time was up.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub stops: Box<Stops>,
    /// Of the triangles that have to be put outside an obstacle.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub sweeps: Box<Sweeps>,
    /// Twice the energy stored in the body \[mJ\], where the solve asks for it; else zero.
    pub stored: f64,
    /// Whether `residual` has to be exact after the solve: an energy balance counts it.
    pub is_audited: bool,
    /// Linear iterations in this step.
    pub iterations: u32,
    /// Newton iterations in this step, or in its last stage.
    pub newton_iterations: u32,
    /// Relative residual of the last linear solve.
    pub linear_residual: f64,
    /// Estimated error of the stress after it, relative to the stress in the body; zero where it was not asked for.
    pub stress_error: f64,
    /// Whether a linear solve of this step stopped because time was up.
    pub is_late: bool,
    /// Largest free nodal imbalance at the last evaluation \[N\].
    pub imbalance: f64,
    /// The smallest of those at the evaluations before it in this solve \[N\].
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub least_imbalance: f64,
    /// Whether this body needs no further iteration in this step.
    pub is_converged: bool,
    /// Whether the exact tangent was indefinite and the rotated one took its place.
    pub fell_back: bool,
    /// The tangent that the last linear solve used.
    pub tangent: Tangent,
    /// Spurious energy \[mJ\]: what steps along the tangent have created and not taken away again; never negative.
    pub spurious_energy: f64,
    /// Upper bound \[mJ\] of the spurious energy since the last full sum.
    pub unchecked_bound: f64,
    /// `spurious_energy` and `unchecked_bound` at the start of the step.
    pub start_spurious_energy: [f64; 2],
    /// What can be read of the last step, to be put back if this one is undone.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub readings: Box<Readings>,
    /// The work \[mJ\] of the residual that the last solve has left, along its answer.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub residual_work: f64,
    /// Whether a solve of this step is in `spurious_energy` already.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub is_counted: bool,
    /// Why the last step of the body was given up.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub fault: Option<Fault>,
    /// Whether the spurious energy of the last solve exceeds the limit.
    pub creates_energy: bool,
    /// Limit \[mJ\] of the spurious energy in this step, where a solve has exceeded it and the next one is to correct it.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub to_correct: Option<f64>,
    /// Whether this step is limited to a fraction of its increment, lest that happen.
    pub is_step_limited: bool,
    /// Number of times the next fallback sub-step is shortened: once more each time that the body is step-limited again.
    pub fallback_shortenings: u32,
    /// Whole steps in which vertices may still [find their own way](crate::report::GuardFigures::relaxed) at once, after one in which some had to.
    pub relaxing: u32,
    /// Work that this step has taken, retries and resumes included, in iterations of linear solves.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub work: u32,
    /// Energy \[mJ\] of the body's motion by an edge in one step, where the solve asks for the error of positions; else zero.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub motion_scale: f64,
    /// Estimated error of positions after the last linear solve, over the mean edge; zero where it was not asked for.
    pub position_error: f64,
    /// The static increment that is being tried.
    pub line_search: Option<LineSearch>,
}

impl SolverScratch {
    /// What it tells of the last step, without the vectors, which the next one overwrites.
    pub(crate) fn without_vectors(&self) -> Self {
        let empty = Self::default();
        let Self { free, residual, rhs, direction, product, inverse_block, partials, pairs, account, stops, .. } =
            empty;
        let Self {
            sweeps,
            readings,
            residual_work,
            is_counted,
            fault,
            to_correct,
            work,
            motion_scale,
            least_imbalance,
            allowed,
            ..
        } = empty;
        let Self { stored, is_audited, iterations, newton_iterations, linear_residual, stress_error, .. } = *self;
        let Self { is_late, imbalance, is_converged, fell_back, tangent, line_search, .. } = *self;
        let Self {
            spurious_energy,
            unchecked_bound,
            start_spurious_energy,
            creates_energy,
            is_step_limited,
            fallback_shortenings,
            ..
        } = *self;
        let Self { relaxing, position_error, .. } = *self;
        Self {
            free,
            residual,
            rhs,
            direction,
            product,
            inverse_block,
            partials,
            pairs,
            account,
            stops,
            sweeps,
            stored,
            is_audited,
            iterations,
            newton_iterations,
            linear_residual,
            stress_error,
            is_late,
            imbalance,
            is_converged,
            fell_back,
            tangent,
            spurious_energy,
            unchecked_bound,
            start_spurious_energy,
            readings,
            residual_work,
            is_counted,
            fault,
            creates_energy,
            to_correct,
            is_step_limited,
            fallback_shortenings,
            relaxing,
            work,
            motion_scale,
            least_imbalance,
            allowed,
            position_error,
            line_search,
        }
    }

    /// Forgets what an attempt that is undone has come to.
    pub(crate) fn forget_attempt(&mut self) {
        (self.linear_residual, self.stored, self.stress_error, self.imbalance) = (0.0, 0.0, 0.0, 0.0);
        (self.creates_energy, self.to_correct, self.line_search) = (false, None, None);
        [self.spurious_energy, self.unchecked_bound] = self.start_spurious_energy;
    }

    /// How many of a body's rows are to be worked on in this iteration: all of them, or none.
    pub fn rows_to_solve(&self, rows: usize) -> usize {
        if self.is_converged { 0 } else { rows }
    }
}

/// When corners have last moved and triangles last been looked at, counted in motions.
#[derive(Clone, Debug, Default)]
pub struct Sweeps {
    /// Motions so far.
    pub motions: u64,
    /// Of every vertex.
    pub moved: Vec<u64>,
    /// Of every triangle.
    pub looked_at: Vec<u64>,
}

/// What a static increment is compared with.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct LineSearch {
    /// |increment · imbalance| before it \[mJ\].
    pub work: f64,
    /// Squared norm of the imbalance before it \[N²\].
    pub norm_sq: f64,
    /// Fraction of the increment that stands.
    pub fraction: f64,
}

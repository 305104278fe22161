//! How a simulation solves: every number with its unit, default and cost.

#[doc(hidden)]
pub mod ablation;
mod range;

pub use range::OutOfRange;

use std::time::Duration;

/// More threads than any machine that this runs on has cores for; each takes a stack of its own.
const MOST_THREADS: usize = 1024;

/// Default budget of a step: enough for studies, and no frame of seconds where a few vertices are in trouble.
const USUAL_BUDGET: u32 = 4000;

/// Budget of a step under a hand that feels: slack cloth keeps its grasps and tears with it (`docs/speed.md`).
const HAPTIC_BUDGET: u32 = 1000;

/// Which derivative of the nodal forces a linear solve uses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub enum Tangent {
    /// Constant stiffness rotated with the triangle, contracted with the exact stretch rate, plus the tensile part of the
    /// geometric stiffness along the normal and a bound of it on in-plane waves. Always positive semidefinite; stable at any
    /// tension; keeps the angular momentum of a body that spins in its plane.
    #[default]
    Rotated,
    /// The Hessian of the energy. Quadratic convergence of Newton's method; may be indefinite under compression, then the
    /// rotated one takes its place for that solve, and the projected one in the next iterations of the step.
    Exact,
    /// The Hessian of the energy, in each triangle made positive semidefinite by the least stiffness against its spin, and the
    /// tensile part of its stress along the normal. The first solve of a step, or of a stage of it, takes the rotated one: the
    /// tension that a displacement along the tangent brings would brake rotation. For `newton_iterations` of 2 and more:
    /// Newton's method at nearly quadratic convergence that never meets an indefinite operator.
    Projected,
    /// Mean of the projected and the rotated one by the state of each triangle: projected where it is in tension, rotated where it is
    /// slack and turns freely. The first solve of a step takes the rotated one. Where this setting is `Rotated`, corrector solves of a tear by
    /// whole triangles take it, and the first solve after a tip has glided; corrector solves of tips that glide take the projected one.
    Weighted,
}

/// The formula of dynamic steps in time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub enum Integrator {
    /// Backward Euler: of first order, one solve per step, damps every motion that a step does not resolve.
    #[default]
    BackwardEuler,
    /// TR-BDF2 (Bank et al. 1985; Hosea, Shampine 1996): of second order. One stage by the trapezoidal rule over 0.586 of the step,
    /// one by the backward difference formula over the rest. It damps motion far too fast for the step like backward Euler, and
    /// hardly damps motion that the step resolves. Two solves per step. Second order takes two Newton iterations per stage with the
    /// projected tangent, or the exact one. A single rotated solve per stage damps noise, but is of first order and less accurate
    /// than backward Euler. It makes a body that spins about its normal spin faster. An energy audit is of backward Euler only.
    TrBdf2,
}

/// The preconditioner of a linear solve. It changes the time that a solve takes, and its answer within the solve's tolerance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub enum Preconditioner {
    /// By kind of solve and size. In static solves a Cholesky factor (block Jacobi without feature `direct`), over 200,000 free axes multigrid. In
    /// dynamic steps an incomplete factor; multigrid on planar bodies from 1,000 free axes on, 2,000 where they may tear, and over
    /// 40,000 on all. In mixed precision, a solve of up to 40,000 free axes that fails in 500 iterations makes a Cholesky factor on the
    /// spot, with which the next 16 begin.
    #[default]
    Auto,
    /// The inverse of each vertex' own block: no memory and no time to set up, but hundreds of iterations per solve, more the
    /// finer the mesh. Right where memory is short, and for dynamic steps so short that inertia keeps the iterations few.
    BlockJacobi,
    /// An incomplete Cholesky factor with the fill of level one, made anew for every solve: about a quarter of block Jacobi's
    /// iterations, each twice as long. Right for dynamic steps of bodies that tear, bend and slacken. It serves the rotated and projected tangents
    /// in [`Precision::Mixed`]; elsewhere this is block Jacobi.
    IncompleteCholesky,
    /// Multigrid: a cycle over coarser and coarser levels that follow the surface and its tears. About 6 iterations per solve to
    /// 1e-3 and 15 to 1e-6 whatever the mesh, each as long as two or three of block Jacobi's. Its numbers are kept from solve to
    /// solve while that saves time. Right for large bodies, torn or not. On a crumpled body it needs a third of the incomplete
    /// factor's iterations, but new numbers at every step, each as long as six of them. With less than 20,000 triangles the
    /// incomplete factor is faster there.
    Multigrid,
    /// A sparse Cholesky factor of the operator, renewed on the spot as soon as it needs more than ten iterations, 60 with guides. One to ten per
    /// solve, and a step now and then that takes as long as twenty others. Right for static solves and for tight tolerances. A
    /// factor of a sheet of 100,000 free axes takes 0.1 GB and half a second. Without the crate's feature `direct` this is the
    /// incomplete one.
    Cholesky,
}

/// Arithmetic precision of the iterations of dynamic steps. Answers agree within the solve's tolerance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub enum Precision {
    /// Residuals in double precision, iterations in single: several times as fast. A tolerance that single precision does not
    /// reach takes several rounds, each of which starts from a residual in double precision.
    #[default]
    Mixed,
    /// Double precision alone, preconditioned by block Jacobi or a Cholesky factor: the plain path that the other is tested
    /// and timed against. Static solves and exact tangents iterate in it; multigrid cycles are single.
    Double,
}

/// Limits of the linear solve.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct LinearParams {
    /// Relative residual to stop at, 1e-4 by default: the part of the largest right-hand side of the step's solves so far. A piece
    /// that is torn free turns and moves at next to no energy; only a small residual holds the error of that motion down. A body
    /// that is held everywhere may have 0.1, and half the iterations.
    pub tolerance: f64,
    /// Estimated error of the stress to stop at as well, relative to the stress in the body as a whole, 1e-3 by default. It is the
    /// root of the energy of the strains still missing over the stored energy. A residual says the less of the stress the finer the
    /// mesh; this means the same on any. A sheet of 1,500 triangles is itself 5 % off the continuum. A residual of 1e-3 times this
    /// is small enough whatever the stress: a body at rest stores nothing. With `INFINITY` it is not asked for and the residual
    /// decides alone.
    pub stress_tolerance: f64,
    /// Stop after so many iterations at the latest; the report then shows the residual reached.
    pub iterations: u32,
    /// Stop when a solve has taken so long: a frame must go out. The result then depends on the machine and its load, so
    /// that such a step is not the same on every run; the report marks it. `None` by default, and of no effect where there is no clock.
    pub time: Option<Duration>,
}

impl LinearParams {
    /// Limits that leave the residual to decide alone.
    pub const fn by_residual(tolerance: f64, iterations: u32) -> Self {
        Self { tolerance, stress_tolerance: f64::INFINITY, iterations, time: None }
    }
}

impl Default for LinearParams {
    fn default() -> Self {
        Self { tolerance: 1e-4, stress_tolerance: 1e-3, iterations: 2000, time: None }
    }
}

/// Presets of [`Settings`]: accuracy against time per step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Accuracy {
    /// One linearly implicit step of backward Euler, to a stress error of 1e-3, with a budget of 4,000 iterations: the default.
    #[default]
    Fast,
    /// Steps for a hand that feels them: [`Fast`](Self::Fast) with at most two passes for tears, one halving, no Newton corrections
    /// and a budget of 1,000 iterations. The longest step is then a few times the usual one.
    Haptic,
    /// Steps for display: [`Haptic`](Self::Haptic) with a position tolerance of a fiftieth of an edge and a budget of 80 iterations.
    /// Tuned on 3,042 triangles of slack cloth under a mouse: `docs/speed.md` has the times.
    Game,
    /// Steps that are right rather than fast: TR-BDF2 with two Newton iterations per stage, the second with the projected tangent.
    /// Linear solves go to a residual down to 1e-10, as far as the linear model holds.
    ///
    /// A step takes three to seven times as long as a default one, and the error falls with the square of its length. It is the
    /// faster way from a stress error of 1e-3 down where waves run through a body, and for bodies that fly and spin. A body that is
    /// nearly in equilibrium at every step, as tissue under a hand is, gains little. A report says `is_converged` only for steps
    /// that have reached `newton_tolerance`, which two iterations do not always; `newton_iterations` of three and more get nearer.
    Accurate,
    /// Equilibria by [`settle`](crate::simulation::Simulation::settle): [`Fast`](Self::Fast) with the linear solves of
    /// [`Accurate`](Self::Accurate) and at most 200 static Newton iterations.
    Static,
}

impl Accuracy {
    /// All presets.
    pub const ALL: [Self; 5] = [Self::Fast, Self::Haptic, Self::Game, Self::Accurate, Self::Static];

    /// Name in scenes and bindings, such as `"game"`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Fast => "fast",
            Self::Haptic => "haptic",
            Self::Game => "game",
            Self::Accurate => "accurate",
            Self::Static => "static",
        }
    }

    /// The preset of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|accuracy| accuracy.name() == name)
    }
}

/// Settings of a simulation: an [`Accuracy`], with five numbers that programs choose, and the rest in [`Advanced`].
///
/// # Examples
/// ```
/// use rhexis::prelude::*;
///
/// let settings = Settings { budget: Some(120), threads: 1, ..Settings::new(Accuracy::Game) };
/// let advanced = Advanced { max_step_halvings: 2, ..settings.advanced };
/// let simulation = Simulation::new(Settings { advanced, ..settings })?;
/// assert_eq!(simulation.settings().position_tolerance, 0.02);
/// # Ok::<(), rhexis::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Settings {
    /// Work that a body may take in one step, in iterations of linear solves, 4,000 by default; `None` for any amount. Counted are iterations, 7 for each
    /// evaluation, 11 for each matrix with its preconditioner, 80 for a Cholesky factor and 10 for an iteration with it, and advances of tears and halved
    /// triangles by the size of the body; retries and passes for tears included. The count, and so the answer, is the same on every machine;
    /// [`work_per_millisecond`](crate::report::Report::work_per_millisecond) measures the rate on this machine.
    ///
    /// Work beyond the budget is not begun: the step ends with the best answer so far, and where that would create energy with a
    /// fraction of it (`any_substep_limited`). One solve, of 4 iterations at the least, and one advance are made whatever the budget. Newton's
    /// iterations end with the last that it allows. Tears and refinement that are due go on in the next step, the tip first that has waited longest.
    /// No Cholesky factor is made where less than 380 is left.
    pub budget: Option<u32>,
    /// Threads; 0 means one per core. The result has the same bits for any number.
    pub threads: usize,
    /// Maximum re-solves per dynamic step while a tear may still advance, 8 by default. Each is one more solve and
    /// one more advance per tip; with 0 a tip makes one advance per step.
    pub max_tear_passes: u32,
    /// Position error at which a dynamic solve may stop whatever its residual, as a fraction of the mean edge: the mean over the masses that the
    /// error's energy allows at most. `INFINITY`, the default, disables it. The residual of such a solve does no work. A free piece much
    /// smaller than the body may be off by more.
    pub position_tolerance: f64,
    /// Use only the instructions that every processor of the family has, instead of the best there are. The result has the
    /// same bits (but for solves with a Cholesky factor, whose library chooses its instructions itself); it takes longer.
    pub portable_instructions: bool,
    /// Numbers and methods of the solver, which a preset sets.
    pub advanced: Advanced,
    /// Part of a step that a measurement leaves out; in no file.
    #[doc(hidden)]
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub without: Option<ablation::Part>,
}

/// Settings of the solver that a preset sets and few programs change.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Advanced {
    /// Preconditioner of linear solves, static ones and those of dynamic steps.
    pub preconditioner: Preconditioner,
    /// Arithmetic precision of the iterations of dynamic steps.
    pub precision: Precision,
    /// Tangent of a dynamic step.
    pub tangent: Tangent,
    /// Time integration formula of a dynamic step.
    pub integrator: Integrator,
    /// Maximum Newton iterations per dynamic step, or per stage of it: 1 (default) is linearly implicit, more converge the
    /// nonlinear step to `newton_tolerance`.
    pub newton_iterations: u32,
    /// Largest free nodal imbalance at which Newton stops, as a fraction of the largest corner force.
    pub newton_tolerance: f64,
    /// Maximum Newton iterations of a static solve.
    pub static_iterations: u32,
    /// Maximum Newton corrections of a step that fails the energy check: Newton's method along the projected tangent with a line search
    /// on the incremental potential, for bodies in space under holds, pins or jaws. A step that would still create energy is retried in
    /// halves. 0 for none: halves are a little nearer to the truth where tears spring open, but many where a hand flings slack cloth.
    pub newton_corrections: u32,
    /// Maximum halvings of a step that would leave a non-finite state or create energy; each retries it as two steps of half the length.
    /// A body that would still create energy then takes a fraction of its increment.
    pub max_step_halvings: u32,
    /// Limits of the linear solves of a dynamic step.
    pub linear: LinearParams,
}

impl Default for Advanced {
    fn default() -> Self {
        Self {
            preconditioner: Preconditioner::Auto,
            precision: Precision::Mixed,
            tangent: Tangent::Rotated,
            integrator: Integrator::BackwardEuler,
            newton_iterations: 1,
            newton_tolerance: 1e-9,
            static_iterations: 60,
            newton_corrections: 10,
            max_step_halvings: 4,
            linear: LinearParams::default(),
        }
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            budget: Some(USUAL_BUDGET),
            threads: 0,
            max_tear_passes: 8,
            position_tolerance: f64::INFINITY,
            portable_instructions: false,
            advanced: Advanced::default(),
            without: None,
        }
    }
}

impl Settings {
    /// The settings of a preset.
    pub fn new(accuracy: Accuracy) -> Self {
        let fast = Self::default();
        let tight = LinearParams { tolerance: 1e-10, stress_tolerance: f64::INFINITY, ..LinearParams::default() };
        match accuracy {
            Accuracy::Fast => fast,
            Accuracy::Haptic => {
                let advanced = Advanced { max_step_halvings: 1, newton_corrections: 0, ..fast.advanced };
                Self { budget: Some(HAPTIC_BUDGET), max_tear_passes: 2, advanced, ..fast }
            }
            Accuracy::Game => Self { position_tolerance: 0.02, budget: Some(80), ..Self::new(Accuracy::Haptic) },
            Accuracy::Accurate => {
                let (tangent, integrator) = (Tangent::Projected, Integrator::TrBdf2);
                let advanced = Advanced { linear: tight, tangent, integrator, newton_iterations: 2, ..fast.advanced };
                Self { budget: None, advanced, ..fast }
            }
            Accuracy::Static => {
                let advanced = Advanced { linear: tight, static_iterations: 200, ..fast.advanced };
                Self { budget: None, advanced, ..fast }
            }
        }
    }

    /// Checks that every number is in its range.
    ///
    /// # Errors
    /// For a tolerance below zero or not finite (those of stress and positions may be infinite), and for more than 1024 threads.
    pub fn validate(&self) -> Result<(), OutOfRange> {
        let LinearParams { tolerance, stress_tolerance, .. } = self.advanced.linear;
        OutOfRange::unless_tolerance("advanced.linear.tolerance", tolerance)?;
        for (what, value) in
            [("advanced.linear.stress_tolerance", stress_tolerance), ("position_tolerance", self.position_tolerance)]
        {
            OutOfRange::unless(value >= 0.0, what, value, "it must be zero or more, or infinite")?;
        }
        OutOfRange::unless_tolerance("advanced.newton_tolerance", self.advanced.newton_tolerance)?;
        let must = "it must be at most 1024, or 0 for one per core";
        OutOfRange::unless(self.threads <= MOST_THREADS, "threads", self.threads as f64, must)
    }
}

//! How a simulation solves: every number with its unit, default and cost.

mod range;

pub use range::OutOfRange;

use std::time::Duration;

/// More threads than any machine that this runs on has cores for; each takes a stack of its own.
const MOST_THREADS: usize = 1024;

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
    /// A Cholesky factor or multigrid, by size. In static solves a factor renewed on the spot, over 200,000 free axes multigrid. In
    /// dynamic steps up to 40,000 free axes a factor made aside on a thread of its own. It takes effect a fixed number of solves
    /// later and is kept while it is better than none, edits of the mesh included. Meanwhile an incomplete one; on planar bodies
    /// from 1,000 free axes on, 2,000 where they may tear, multigrid. Over 40,000 multigrid.
    #[default]
    Auto,
    /// The inverse of each vertex' own block: no memory and no time to set up, but hundreds of iterations per solve, more the
    /// finer the mesh. Right where memory is short, and for dynamic steps so short that inertia keeps the iterations few.
    BlockJacobi,
    /// An incomplete Cholesky factor with the fill of level one, made anew for every solve: about a quarter of block Jacobi's
    /// iterations, each twice as long. Right for dynamic steps of bodies that tear, bend and slacken. It serves the rotated tangent
    /// in [`Precision::Mixed`]; elsewhere this is block Jacobi.
    IncompleteCholesky,
    /// Multigrid: a cycle over coarser and coarser levels that follow the surface and its tears. About 6 iterations per solve to
    /// 1e-3 and 15 to 1e-6 whatever the mesh, each as long as two or three of block Jacobi's. Its numbers are kept from solve to
    /// solve while that saves time. Right for large bodies, torn or not. On a crumpled body it needs a third of the incomplete
    /// factor's iterations, but new numbers at every step, each as long as six of them. With less than 20,000 triangles the
    /// incomplete factor is faster there.
    Multigrid,
    /// A sparse Cholesky factor of the operator, renewed on the spot as soon as it needs more than ten iterations. One to ten per
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
    /// and timed against. Static solves and the exact tangent always take it.
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
    /// Position error at which a dynamic solve may stop whatever its residual, as a fraction of the mean edge: the mean over the masses that the
    /// error's energy allows at most. `INFINITY`, the default, disables it. The residual of such a solve does no work. A free piece much
    /// smaller than the body may be off by more.
    pub position_tolerance: f64,
    /// Stop after so many iterations at the latest; the report then shows the residual reached.
    pub iterations: u32,
    /// Stop when a solve has taken so long: a frame must go out. The result then depends on the machine and its load, so
    /// that such a step is not the same on every run; the report marks it. `None` by default, and of no effect where there is no clock.
    pub time: Option<Duration>,
}

impl LinearParams {
    /// Limits that leave the residual to decide alone.
    pub const fn by_residual(tolerance: f64, iterations: u32) -> Self {
        let unasked = f64::INFINITY;
        Self { tolerance, stress_tolerance: unasked, position_tolerance: unasked, iterations, time: None }
    }
}

impl Default for LinearParams {
    fn default() -> Self {
        Self {
            tolerance: 1e-4,
            stress_tolerance: 1e-3,
            position_tolerance: f64::INFINITY,
            iterations: 2000,
            time: None,
        }
    }
}

/// Settings of a simulation.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Settings {
    /// Linear solve of a dynamic step.
    pub linear: LinearParams,
    /// The preconditioner of linear solves, static ones and those of dynamic steps.
    pub preconditioner: Preconditioner,
    /// Arithmetic precision of the iterations of dynamic steps.
    pub precision: Precision,
    /// Tangent of a dynamic step.
    pub tangent: Tangent,
    /// Formula of a dynamic step in time.
    pub integrator: Integrator,
    /// Newton iterations per dynamic step, or per stage of it, at the most: 1 (default) is linearly implicit, more converge the
    /// nonlinear step to `newton_tolerance`.
    pub newton_iterations: u32,
    /// Newton stops where the largest free nodal imbalance is below this fraction of the largest corner force.
    pub newton_tolerance: f64,
    /// Newton iterations of a static solve at the most.
    pub static_iterations: u32,
    /// Maximum re-solves per step while a tear may still advance: each time one more solve
    /// and one more advance per tip. With 0 a tip makes one advance per step.
    pub resumes: u32,
    /// Maximum Newton corrections of a step that fails the energy check: Newton's method along the projected
    /// tangent with a line search on the incremental potential, for the bodies in space under holds, pins or jaws. A step that would still
    /// create energy is retried in halves. 0 for none: halves are a little nearer to the truth where tears spring open, but many where a hand
    /// flings slack cloth.
    pub corrections: u32,
    /// How often a step that would leave a non-finite state or create energy is retried with two steps of half the length each. A
    /// body that would still create energy then takes a fraction of its increment.
    pub halvings: u32,
    /// Work that a body may take in one step, in iterations of linear solves; `None`, the default, for any amount. Counted are iterations, 7 for each
    /// evaluation, 11 for each matrix with its preconditioner, and advances of tears and halved triangles by the size of the body; retries and
    /// resumes included. The count, and so the answer, is the same on every machine;
    /// [`work_per_millisecond`](crate::report::Report::work_per_millisecond) measures the rate on this machine.
    ///
    /// Work beyond the budget is not begun: the step ends with the best answer so far, and where that would create energy with a
    /// fraction of it (`any_substep_limited`). One solve, of 4 iterations at the least, and one advance are made whatever the budget; so are
    /// the solves of Newton's method. Tears and refinement that are due go on in the next step, the tip first that has waited longest.
    /// With a budget no Cholesky factor serves.
    pub budget: Option<u32>,
    /// Threads; 0 means one per core. The result has the same bits for any number. A Cholesky factor that is made aside has
    /// one of its own for as long as that takes.
    pub threads: usize,
    /// Use only the instructions that every processor of the family has, instead of the best there are. The result has the
    /// same bits (but for solves with a Cholesky factor, whose library chooses its instructions itself); it takes longer.
    pub portable_instructions: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            linear: LinearParams::default(),
            preconditioner: Preconditioner::Auto,
            precision: Precision::Mixed,
            tangent: Tangent::Rotated,
            integrator: Integrator::BackwardEuler,
            newton_iterations: 1,
            newton_tolerance: 1e-9,
            static_iterations: 60,
            resumes: 8,
            corrections: 10,
            halvings: 4,
            budget: None,
            threads: 0,
            portable_instructions: false,
        }
    }
}

impl Settings {
    /// Dynamic steps that are right rather than fast: TR-BDF2 with two Newton iterations per stage, the second with the projected
    /// tangent. Linear solves go to a residual down to 1e-10, as far as the linear model holds.
    ///
    /// A step takes three to seven times as long as a default one, and the error falls with the square of its length. It is the
    /// faster way from a stress error of 1e-3 down where waves run through a body, and for bodies that fly and spin. A body that is
    /// nearly in equilibrium at every step, as tissue under a hand is, gains little. A report says `is_converged` only for steps
    /// that have reached `newton_tolerance`, which two iterations do not always; `newton_iterations` of three and more get nearer.
    pub fn accurate() -> Self {
        Self {
            linear: LinearParams { tolerance: 1e-10, stress_tolerance: f64::INFINITY, ..LinearParams::default() },
            tangent: Tangent::Projected,
            integrator: Integrator::TrBdf2,
            newton_iterations: 2,
            ..Self::default()
        }
    }

    /// Steps for a hand that feels them: as the default, but a step is redone for tears twice at the most. A body that would create
    /// energy is not solved further, and retried once in halves. The longest step is then a few times the usual one.
    pub fn haptic() -> Self {
        Self { resumes: 2, halvings: 1, corrections: 0, ..Self::default() }
    }

    /// Steps that are looked at: solves stop where positions are right to a fiftieth of an edge, with the limits of [`haptic`](Self::haptic)
    /// and a budget of 80 iterations. Tuned on 3,042 triangles of slack cloth under a mouse: `docs/speed.md` has the times.
    pub fn game() -> Self {
        let haptic = Self::haptic();
        let linear = LinearParams { position_tolerance: 0.02, ..haptic.linear };
        Self { linear, budget: Some(80), ..haptic }
    }

    /// The default, with solves of the dynamic steps between equilibria as tight as those of [`accurate`](Self::accurate): for equilibria
    /// by [`settle`](crate::simulation::Simulation::settle), whose own limits are `static_iterations` and its tolerance.
    pub fn equilibrium() -> Self {
        Self { linear: Self::accurate().linear, static_iterations: 200, ..Self::default() }
    }

    /// Checks that every number is in its range.
    ///
    /// # Errors
    /// For a tolerance below zero or not finite (those of stress and positions may be infinite), and for more than 1024 threads.
    pub fn validate(&self) -> Result<(), OutOfRange> {
        let LinearParams { tolerance, stress_tolerance, position_tolerance, .. } = self.linear;
        OutOfRange::unless_tolerance("linear.tolerance", tolerance)?;
        for (what, value) in
            [("linear.stress_tolerance", stress_tolerance), ("linear.position_tolerance", position_tolerance)]
        {
            OutOfRange::unless(value >= 0.0, what, value, "it must be zero or more, or infinite")?;
        }
        OutOfRange::unless_tolerance("newton_tolerance", self.newton_tolerance)?;
        let must = "it must be at most 1024, or 0 for one per core";
        OutOfRange::unless(self.threads <= MOST_THREADS, "threads", self.threads as f64, must)
    }

    /// The presets by name.
    pub fn presets() -> [(&'static str, Self); 4] {
        [
            ("haptic", Self::haptic()),
            ("game", Self::game()),
            ("accurate", Self::accurate()),
            ("static", Self::equilibrium()),
        ]
    }
}

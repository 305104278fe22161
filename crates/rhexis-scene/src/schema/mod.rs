//! What a scene file may say: one struct per table, one field per key.
//!
//! Units are fixed: mm, g, ms, hence N, MPa = N/mm², mJ, kHz. A point is `[x, y, z]` or `[x, y]`; a quantity over time is a
//! number or `[[time, value], …]`, linear between and constant outside, or a trembling hand ([`HandSpec`]). An unknown key is
//! refused.

mod body;
mod compartment;
mod constraint;
mod fibre_law;
mod hand;
mod mesh;
mod mesh_file;
mod number;
mod per_triangle;
mod tool;

pub use super::table_file::{ColumnSpec, TableSpec, TimeUnitSpec};
pub use body::{
    AxisSpec, BendingSpec, BodySpec, BranchSpec, ContactSpec, CriterionSpec, EnergyCriterionSpec, FibreSpec,
    GradingSpec, InitialSpec, MaterialModelSpec, MaterialSpec, PartSpec, PlaceSpec, RefinementSpec, SelfContactSpec,
    SleepSpec, TearModeSpec, TearRateSpec, TearingSpec,
};
pub use compartment::{CompartmentSpec, GasSpec, LiquidSpec};
pub use constraint::{
    ArcSpec, ArrayRangeSpec, BallSpec, BedSpec, ClampSpec, EdgeLoadSpec, GripSpec, HoldSpec, LegSpec, MoveSpec,
    NearTipSpec, PointLoadSpec, RegionSpec, SpringSpec,
};
pub use fibre_law::{Angles, FibreFamilySpec, HolzapfelGasserOgdenSpec, StiffeningFibresSpec};
pub use hand::HandSpec;
pub use mesh::MeshSpec;
pub use mesh_file::{FileSpec, ReadingSpec, UnitSpec};
pub use number::{Exactly, Interval, Numbers, Point, Strain, TimeCurve, TimePath};
pub use per_triangle::{PerTriangleSpec, Values};
pub use tool::{BladeSpec, CutSpec, PunctureSpec};

use rhexis::settings::LinearParams;
use serde::Deserialize;
use std::path::PathBuf;

/// The whole file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneFile {
    /// `[scene]`: what this is.
    pub scene: AboutSpec,
    /// `[run]`: how it is run.
    pub run: RunSpec,
    /// `[output]`: what a run writes.
    #[serde(default)]
    pub output: OutputSpec,
    /// `[[bodies]]`: the membranes, at least one.
    pub bodies: Vec<BodySpec>,
    /// `[[obstacles]]`: rigid surroundings, felt by bodies with `contact`.
    #[serde(default)]
    pub obstacles: Vec<ObstacleSpec>,
    /// `[[probes]]`: points of the tissue whose place and stress stand in `series.csv`, and sections whose force does.
    #[serde(default)]
    pub probes: Vec<ProbeSpec>,
}

/// One of `[[probes]]`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProbeSpec {
    /// Name of its columns in `series.csv`.
    pub name: String,
    /// Name of its body. Default the only one.
    pub body: Option<String>,
    /// Point of the rest shape \[mm\]; the nearest one of the body is taken. Of a section a point of its plane.
    pub point: Point,
    /// Makes it a section: the force across a plane in place of a point's place and stress.
    pub section: Option<SectionSpec>,
}

/// `section = { normal = [x, y, z] }`: a plane of the rest shape that cuts the body. The columns in `series.csv` are the force \[N\] of the tissue
/// on the side of the normal on the tissue behind it: a pull is along the normal. It is the sum of stress × thickness × length over the
/// triangles that the plane cuts, without bending and damping; of tissue at rest the holds of one side balance it exactly.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SectionSpec {
    /// Normal of the plane; need not be unit.
    pub normal: Point,
    /// Distance from `point` \[mm, rest shape\], > 0, within which triangles count by their middle. Default: the whole plane counts.
    pub radius: Option<f64>,
}

/// `[scene]`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AboutSpec {
    /// Short name; the default output directory is called after it.
    pub name: String,
    /// One sentence for the list of scenes.
    #[serde(default)]
    pub about: String,
    /// Where the numbers come from.
    #[serde(default)]
    pub reference: String,
    /// Name of the preset whose values take the places of the file's own: a table `[presets.NAME]` with a dotted key in quotes
    /// per value, as in `"bodies.0.material.young_fibre" = 6`. Default none.
    #[serde(default)]
    pub preset: String,
    /// Names of the doubts of `rhexis check` that are meant so. Default none.
    #[serde(default)]
    pub allow: Vec<String>,
}

/// How time passes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// Steps with inertia, damping and drag.
    #[default]
    Dynamic,
    /// Equilibrium at every step; time only moves the curves.
    Static,
}

/// Which derivative of the forces a dynamic step uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TangentSpec {
    /// Always positive semidefinite, keeps angular momentum.
    Rotated,
    /// The Hessian of the energy.
    Exact,
    /// The same made positive semidefinite; the first solve of a step takes the rotated one.
    Projected,
    /// Projected where a triangle is in tension, rotated where it is slack; the first solve of a step takes the rotated one.
    Weighted,
}

/// The formula of a dynamic step in time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum IntegratorSpec {
    /// First order, one solve per step.
    BackwardEuler,
    /// Second order, two solves per step.
    TrBdf2,
}

/// Preset of the settings; keys of `[run]` and `run.advanced` go before it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AccuracySpec {
    /// One linear solve by backward Euler: for interaction.
    #[default]
    Fast,
    /// For references.
    Accurate,
    /// For a hand that feels.
    Haptic,
    /// For an eye that looks.
    Game,
    /// For equilibria and the states between them.
    Static,
}

/// What makes the iterations of linear solves few.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PreconditionerSpec {
    /// An incomplete factor, multigrid or a Cholesky factor, by the kind of solve and the body's size.
    #[default]
    Auto,
    /// The inverse of each vertex' own block.
    BlockJacobi,
    /// An incomplete Cholesky factor, made anew for every solve of a dynamic step.
    IncompleteCholesky,
    /// Multigrid on levels that follow the surface and its tears.
    Multigrid,
    /// A sparse Cholesky factor, kept while it serves.
    Cholesky,
}

/// What the iterations of dynamic steps compute in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PrecisionSpec {
    /// Residuals in double precision, iterations in single.
    #[default]
    Mixed,
    /// Double precision alone.
    Double,
}

/// `[run]`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunSpec {
    /// `"dynamic"` (default) or `"static"`.
    #[serde(default)]
    pub mode: Mode,
    /// Time step \[ms\], > 0; in static mode the time by which the curves move on per load step.
    pub dt: f64,
    /// Number of steps, at most 10⁹. Give either this or `duration`.
    pub steps: Option<u64>,
    /// Simulated time \[ms\]; the number of steps is this over `dt`, rounded up.
    pub duration: Option<f64>,
    /// End early as soon as a tear has begun and no tip is left: the sheet is torn through. Default false.
    #[serde(default)]
    pub until_torn: bool,
    /// End early as soon as a tear has ended: run into the rim, into another one, or closed on itself, so that a piece is free.
    /// Default false.
    #[serde(default)]
    pub until_ended: bool,
    /// `"fast"` (default), `"haptic"`, `"game"`, `"accurate"` or `"static"`: preset of all settings that no other key gives.
    /// - Haptic is `budget = 1000`, `max_tear_passes = 2`, `advanced.max_step_halvings = 1`, `advanced.newton_corrections = 0`.
    /// - Game is that with `position_tolerance = 0.02` and `budget = 80`.
    /// - Static is `linear_tolerance = 1e-10`, `stress_tolerance = inf`, `static_iterations = 200` of `advanced`.
    /// - Accurate is `integrator = "tr_bdf2"`, `newton_iterations = 2`, `tangent = "projected"`, `linear_tolerance = 1e-10`,
    ///   `stress_tolerance = inf` of `advanced`. A step takes three to seven times as long; for references, waves and spins.
    #[serde(default)]
    pub accuracy: AccuracySpec,
    /// Maximum iterations of linear solves that a body may take in one dynamic step, retries and passes for tears included; 0 for no limit. A
    /// count, hence equal bits on every machine; the report tells the solves that it ends. Default 4000. Not with several Newton iterations.
    pub budget: Option<u32>,
    /// Threads; 0 (default) means one per core. The results are the same bits for any number.
    #[serde(default)]
    pub threads: usize,
    /// Maximum re-solves per dynamic step while a tear may still advance, at most 1000. Default 8.
    pub max_tear_passes: Option<u32>,
    /// Estimated error of positions, over the mean edge, at which the linear solve of a dynamic step may stop; its residual is then not
    /// asked for. Above zero; `inf` (default): not asked for.
    pub position_tolerance: Option<f64>,
    /// Use only the instructions that every processor of the family has; slower, the same results.
    #[serde(default)]
    pub portable_instructions: bool,
    /// Numbers and methods of the solver, which `accuracy` sets.
    #[serde(default)]
    pub advanced: AdvancedSpec,
}

/// `[run.advanced]`, or `advanced.KEY = …` in `[run]`: settings of the solver that few scenes change.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AdvancedSpec {
    /// `"backward_euler"` (default) or `"tr_bdf2"`: the formula of a dynamic step in time, of first or second order. Without
    /// `energy` in `[output]`.
    pub integrator: Option<IntegratorSpec>,
    /// Maximum Newton iterations per dynamic step or stage of it, at most 1000; 1 (default) is linearly implicit.
    pub newton_iterations: Option<u32>,
    /// Largest free nodal imbalance at which Newton stops in a dynamic step, over the largest corner force. Default 1e-9.
    pub newton_tolerance: Option<f64>,
    /// Maximum Newton corrections of a step that fails the energy check, before it is retried in halves; at most 100. Default 10.
    pub newton_corrections: Option<u32>,
    /// Maximum halvings of a step that fails, at most 20. Default 4.
    pub max_step_halvings: Option<u32>,
    /// Relative residual at which the linear solve of a dynamic step may stop. Default 1e-4; where no piece can come free 0.1 is enough.
    pub linear_tolerance: Option<f64>,
    /// Estimated error of the stress, relative to the stress in the body as a whole, at which the linear solve of a dynamic step
    /// stops, where its residual has reached `linear_tolerance` too.
    /// Above zero, default 1e-3; with `inf` it is not asked for and the
    /// residual decides alone.
    pub stress_tolerance: Option<f64>,
    /// Time \[ms\] after which a linear solve stops however far it has come; the run is then not the same every time. Default none.
    pub solve_milliseconds: Option<f64>,
    /// Maximum iterations of a linear solve, 1 to 10⁶. Default 2000.
    pub linear_iterations: u32,
    /// `"rotated"` (default), `"exact"` or `"projected"`.
    pub tangent: Option<TangentSpec>,
    /// `"auto"` (default), `"block_jacobi"`, `"incomplete_cholesky"`, `"multigrid"` or `"cholesky"`: the same answer
    /// within the tolerance, at other costs.
    pub preconditioner: PreconditionerSpec,
    /// `"mixed"` (default) or `"double"`: arithmetic of the iterations of dynamic steps; the same answer within the tolerance.
    pub precision: PrecisionSpec,
    /// Largest free nodal imbalance at which a static solve ends, over the largest corner force. Default 1e-9.
    pub static_tolerance: f64,
    /// Maximum Newton iterations of a static solve, 1 to 10⁴. Default 60.
    pub static_iterations: Option<u32>,
    /// Maximum rounds of tearing and equilibrium within one static step. Default 1000; a tear that would go on is
    /// held until the next step.
    pub static_advances: u32,
}

impl Default for AdvancedSpec {
    fn default() -> Self {
        Self {
            integrator: None,
            newton_iterations: None,
            newton_tolerance: None,
            newton_corrections: None,
            max_step_halvings: None,
            linear_tolerance: None,
            stress_tolerance: None,
            solve_milliseconds: None,
            linear_iterations: LinearParams::default().iterations,
            tangent: None,
            preconditioner: PreconditionerSpec::Auto,
            precision: PrecisionSpec::Mixed,
            static_tolerance: 1e-9,
            static_iterations: None,
            static_advances: 1000,
        }
    }
}

/// `[output]`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct OutputSpec {
    /// Number of PNG pictures, spread evenly from the first to the last state; 0 for none. Default 5.
    pub pictures: u32,
    /// Number of ParaView frames, spread likewise; 0 for none. Default 50.
    pub frames: u32,
    /// Time between pictures \[ms\], in place of `pictures`.
    pub pictures_every: Option<f64>,
    /// Time between frames \[ms\], in place of `frames`.
    pub frames_every: Option<f64>,
    /// Whether frames have the vertices' `velocity` \[mm/ms\]. Default false.
    pub velocities: bool,
    /// Whether frames have the elastic `force` of the membrane on the vertices \[N\]. Default false.
    pub forces: bool,
    /// Whether arrows in pictures show the forces of obstacles and jaws on the bodies. Default false.
    pub force_arrows: bool,
    /// Whether the energy balance of every body is kept: terms in `series.csv` and `report.json`, what each advance has
    /// released in static mode in `events.jsonl`. Default false.
    pub energy: bool,
    /// Whether the bodies as they lie at the end are written as `surface-INDEX.obj`, with normals. Default false.
    pub obj: bool,
    /// The same as `surface-INDEX.ply`, binary. Default false.
    pub ply: bool,
    /// The same as `surface-INDEX.glb`, with texture coordinates, colours and `texture` where they have them. Default false.
    pub gltf: bool,
    /// Scoring of the courses of tears: `"capsulorhexis"`, or the path of a scoring file, relative to the scene file (see
    /// [`score`](crate::score)). Default none.
    pub scoring: Option<PathBuf>,
}

impl Default for OutputSpec {
    fn default() -> Self {
        Self {
            pictures: 5,
            frames: 50,
            pictures_every: None,
            frames_every: None,
            velocities: false,
            forces: false,
            force_arrows: false,
            energy: false,
            obj: false,
            ply: false,
            gltf: false,
            scoring: None,
        }
    }
}

/// One of `[[obstacles]]`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObstacleSpec {
    /// Name in reports. Default `obstacle-0` and so on, in the order of the file.
    pub name: Option<String>,
    /// `plane = { point, normal }`: the half space below. An obstacle has one shape.
    pub plane: Option<PlaneSpec>,
    /// `sphere = { centre, radius }`.
    pub sphere: Option<SphereSpec>,
    /// `ellipsoid = { centre, half_axes }`, its axes along x, y, z.
    pub ellipsoid: Option<EllipsoidSpec>,
    /// `capsule = { from, to, radius }`: a cylinder with round ends.
    pub capsule: Option<CapsuleSpec>,
    /// `box = { centre, half }`, its edges along x, y, z.
    #[serde(rename = "box")]
    pub cuboid: Option<BoxSpec>,
    /// `cylinder = { from, to, radius }`, with flat ends.
    pub cylinder: Option<CapsuleSpec>,
    /// `mesh = { file = … }`, as of a body: the solid within a closed mesh. Only vertices of bodies feel it.
    pub mesh: Option<MeshSpec>,
    /// `path = [[time, [x, y, z]], …]`: by how much it is displaced \[mm\] over time \[ms\], straight between the points, at rest before
    /// and after. What it meets on its way is taken along. Default: it stands still.
    pub path: Option<TimePath>,
    /// `rotate = [[time, [x, y, z]], …]`: by how much it is turned, before it is displaced: along the axis, as long as the angle \[°\]; from a
    /// table also as quaternions ([`TableSpec`]).
    pub rotate: Option<TimePath>,
    /// Constant turn from time zero on \[°/ms\]: along the axis, as long as the rate. In place of `rotate`. With `mass` the angular velocity at
    /// time zero.
    pub spin: Option<Point>,
    /// The point about which it turns \[mm\]. Default its middle.
    pub pivot: Option<Point>,
    /// Mass \[g\], > 0: a homogeneous rigid body that tissue pushes. Not with `path`, `rotate` and `pivot`, and not of a plane. Default: the obstacle
    /// yields to nothing.
    pub mass: Option<f64>,
    /// Velocity of such a body at time zero \[mm/ms\]. Default 0.
    pub velocity: Option<Point>,
    /// Acceleration of such a body by its weight \[mm/ms²\]. Default 0.
    pub gravity: Option<Point>,
}

/// A cylinder, with round or flat ends.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CapsuleSpec {
    /// One end of its axis \[mm\].
    pub from: Point,
    /// The other end \[mm\].
    pub to: Point,
    /// Radius \[mm\], > 0.
    pub radius: f64,
}

/// A box.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoxSpec {
    /// Centre \[mm\].
    pub centre: Point,
    /// Half edges \[mm\], each > 0.
    pub half: Point,
}

/// A half space.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlaneSpec {
    /// A point of the plane \[mm\].
    pub point: Point,
    /// Points out of the obstacle; need not be unit.
    pub normal: Point,
}

/// A ball.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SphereSpec {
    /// Centre \[mm\].
    pub centre: Point,
    /// Radius \[mm\], > 0.
    pub radius: f64,
}

/// An ellipsoid.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EllipsoidSpec {
    /// Centre \[mm\].
    pub centre: Point,
    /// Half axes \[mm\], each > 0.
    pub half_axes: Point,
}

//! Verification: the engine against independent computations, exact solutions and conservation laws.
//!
//! The same cases are run by `cargo test` (coarse meshes only, [`Depth::Quick`]) and by `rhexis verify`. A case returns
//! rows; a row is an error, the tolerance that it must meet and the unit of both. Reference files are part of the
//! program, so it verifies itself anywhere.

mod artifacts;
mod bed;
mod bodies;
mod compartment;
mod constitutive;
mod contact;
mod drum;
mod dynamics;
mod fig2;
mod flap;
mod free_triangle;
mod hole;
mod integrator;
mod modes;
mod motion;
mod patch;
mod plane;
mod published_law;
mod reference;
mod relaxation;
mod stability;
pub mod tear;

pub use artifacts::{Artifacts, Axes, Depth, Line};
pub use artifacts::{FONT_NAME, load_font};

use rhexis::components::BadCurve;
use rhexis::membrane::BodyError;
use rhexis::simulation::{CutError, MotionError, SetError, SimulationError, SpawnError};
use rhexis_scene::output::OutputError;
use rhexis_scene::{SceneError, generate::GenerateError};
use std::path::PathBuf;

/// One comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Name of the case.
    pub case: &'static str,
    /// What is compared.
    pub what: String,
    /// How far the engine is off, ≥ 0.
    pub error: f64,
    /// The largest error that passes; infinite for a figure that is only reported.
    pub tolerance: f64,
    /// Unit of both; `"1"` for relative errors and ratios.
    pub unit: &'static str,
}

impl Row {
    /// Whether the error is within its tolerance. NaN is not.
    pub fn passes(&self) -> bool {
        self.error <= self.tolerance
    }

    /// Whether the figure is only reported: it has no tolerance.
    pub fn is_informative(&self) -> bool {
        self.tolerance == f64::INFINITY
    }
}

/// Why a case could not be run to its end.
#[derive(Debug, thiserror::Error)]
pub enum VerifyError {
    /// A reference file that is not as the case expects it.
    #[error("reference {file}: {what}")]
    Reference {
        /// The file.
        file: &'static str,
        /// What is wrong.
        what: String,
    },
    /// The mesh.
    #[error(transparent)]
    Mesh(#[from] GenerateError),
    /// The body.
    #[error(transparent)]
    Body(#[from] BodyError),
    /// Of a body that is spawned.
    #[error(transparent)]
    Spawn(#[from] SpawnError),
    /// The run.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// A linear solve within the verification itself.
    #[error("linear solve: {0}")]
    Linear(#[from] rhexis::systems::solver::CgError),
    /// The scene.
    #[error("{0}")]
    Scene(#[from] SceneError),
    /// A turn of a body.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// Another value of a component.
    #[error(transparent)]
    Set(#[from] SetError),
    /// A motion over time.
    #[error(transparent)]
    Curve(#[from] BadCurve),
    /// A cut that makes a crack.
    #[error(transparent)]
    Cut(#[from] CutError),
    /// A file that cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A plot that cannot be drawn.
    #[error("cannot draw {}: {what}", path.display())]
    Plot {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
}

/// What a case is about; `rhexis verify` takes the name of a group as well as that of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// Elasticity, membranes and time integration.
    Mechanics,
    /// Viscoelastic tissue.
    Time,
    /// Tissue that is stuck to a bed.
    Bed,
    /// Closed volumes under bodies.
    Compartments,
    /// Contact with obstacles and of a body with itself.
    Contact,
    /// Tears: stress at tips, loads, paths, energies.
    Tear,
}

impl Group {
    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mechanics => "mechanics",
            Self::Time => "time",
            Self::Bed => "bed",
            Self::Compartments => "compartments",
            Self::Contact => "contact",
            Self::Tear => "tear",
        }
    }
}

/// A verification case.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// Name on the command line.
    pub name: &'static str,
    /// What it shows.
    pub about: &'static str,
    /// What it is about.
    pub group: Group,
    /// Runs it.
    pub run: fn(&Artifacts) -> Result<Vec<Row>, VerifyError>,
}

/// All cases.
pub const CASES: &[Case] = &[
    mechanics("constitutive", "the orthotropic law at any fibre angle, strips of an artery", constitutive::run),
    mechanics("patch", "constant strain, small and under a large rotation", patch::run),
    mechanics("free-triangle", "energy and angular momentum of a free triangle", free_triangle::run),
    mechanics("cook", "Cook's membrane on the same meshes", plane::cook),
    mechanics("fig2-small", "the square of Figure 2 under a small pull", plane::fig2_small),
    mechanics("hole", "a hole in an infinite plate, orthotropic and isotropic", hole::run),
    mechanics("fig2-large", "the square of Figure 2 pulled by 10 %", fig2::large),
    mechanics("fig2-dynamic", "the same pulled over time with backward Euler", fig2::dynamic),
    mechanics("dynamics", "natural frequencies, decay of a mode, order in time", dynamics::run),
    mechanics("membrane", "vibration and deflection out of the plane", drum::run),
    mechanics("motion", "rigid motion, resultants, energy balance, spin", motion::run),
    mechanics("integrator", "order in time of TR-BDF2 and of backward Euler", integrator::run),
    mechanics("stability", "steps of any length damp noise on a taut sheet", stability::run),
    time(
        "time-relaxation",
        "stress under a held strain, torn, curved and in steps of either formula",
        relaxation::held,
    ),
    time("time-limits", "steps far longer and far shorter than the relaxation time", relaxation::limits),
    time("time-creep", "strain of a standard solid under a dead load", relaxation::creep),
    time("time-rate", "stress under a constant rate of strain", relaxation::rate),
    time("time-cycle", "loss per cycle and phase under a harmonic strain", relaxation::cycle),
    time("time-spin", "a turn changes no stress", relaxation::spin),
    Case { name: "bed-peel", about: "the force that peels a strip off its bed", group: Group::Bed, run: bed::peel },
    compartments(
        "compartment-laplace",
        "pressure in a sphere that a liquid fills, by mesh and time step",
        compartment::sphere_under_pressure,
    ),
    compartments("compartment-gas", "a gas as a spring: its law, and a sphere that breathes", compartment::gas_spring),
    compartments("compartment-bulge", "a disc that bulges over a given volume", compartment::bulge),
    compartments("compartment-orifice", "pressure that falls through an opening", compartment::orifice),
    compartments("compartment-hole", "a balloon with a hole goes slack", compartment::hole),
    contact("contact-balance", "forces of obstacles, rim and inertia add up at every step", contact::balance),
    contact("contact-landing", "a sheet thrown on a table: impulse and weight", contact::landing),
    contact(
        "contact-friction",
        "a sheet on a slope sticks without creep, and slides by Coulomb's law",
        contact::friction,
    ),
    contact("contact-layers", "sheets bear each other, a ribbon goes through a slot without crossing", contact::layers),
    contact("contact-flap", "the flap of a capsulorhexis keeps off the sheet, and it closes as without", flap::run_all),
    tear("tear-fibre", "the notched square tears along its fibres", tear::fibre::run),
    tear("tear-mesh", "path and load of a tear on four kinds of mesh", tear::mesh::run),
    tear("tear-mesh-stable", "the same in equilibria, over the whole tear", tear::mesh::stable),
    tear("tear-mesh-edge", "the same along edges", tear::mesh::edge),
    tear("tear-quality", "angles, triangles, area and mass of torn meshes", tear::quality::run),
    tear("tear-symmetry", "symmetric squares tear symmetrically", tear::symmetry::run),
    tear("tear-shape", "the hyperbola between two pulling points, forbidden directions", tear::shape::run),
    tear("tear-time-step", "path and load of a tear as the time step falls", tear::time_step::run),
    tear("tear-energy", "the energy balance of whole tears, dynamic and quasi-static", tear::energy::run),
    tear("tear-tip-stress", "the mean stress over the disc at a crack's tip", tear::tip_stress::run),
    tear("tear-release", "the energy that a crack releases, against its length", tear::release::run),
    tear("tear-load", "the load at which edge and centre cracks tear", tear::load::run),
    tear("tear-kink", "where slanted cracks turn", tear::kink::run),
    tear("tear-strip", "the strain at which a long crack between clamps runs", tear::strip::run),
    tear("tear-start", "where tears start: dog-bone, strength against notch length, hole", tear::start::run),
    tear("tear-trouser", "the pull that tears trousers, whatever R, stiffness, toughness and step", tear::trouser::run),
    tear("tear-trouser-mesh", "the same on three kinds of mesh and three sizes", tear::trouser::meshes),
    tear("tear-trouser-fibre", "where trousers with fibres tear", tear::trouser::fibres),
    tear(
        "tear-hand-force",
        "the mean pull of trousers whose tips glide, and the work per area torn",
        tear::hand_force::run,
    ),
    tear("tear-rate", "the speed of a tear under a dead load, by a toughness that grows with speed", tear::rate::run),
    tear("tear-flap", "a flap folded over and drawn ahead: pull and paths", tear::flap::run),
    tear("tear-turn", "the turn of the path of a gliding tip", tear::turn::run),
    tear("tear-two-points", "the pull that tears a sheet between two points", tear::two_points::run),
];

type Run = fn(&Artifacts) -> Result<Vec<Row>, VerifyError>;

const fn mechanics(name: &'static str, about: &'static str, run: Run) -> Case {
    Case { name, about, group: Group::Mechanics, run }
}

const fn time(name: &'static str, about: &'static str, run: Run) -> Case {
    Case { name, about, group: Group::Time, run }
}

const fn compartments(name: &'static str, about: &'static str, run: Run) -> Case {
    Case { name, about, group: Group::Compartments, run }
}

const fn contact(name: &'static str, about: &'static str, run: Run) -> Case {
    Case { name, about, group: Group::Contact, run }
}

const fn tear(name: &'static str, about: &'static str, run: Run) -> Case {
    Case { name, about, group: Group::Tear, run }
}

/// Collects the rows of one case.
struct Rows {
    case: &'static str,
    rows: Vec<Row>,
}

impl Rows {
    fn new(case: &'static str) -> Self {
        Self { case, rows: Vec::new() }
    }

    /// A dimensionless error.
    fn ratio(&mut self, what: impl Into<String>, error: f64, tolerance: f64) {
        self.add(what, error, tolerance, "1");
    }

    /// `found` against `wanted`, relative to `wanted`.
    fn relative(&mut self, what: impl Into<String>, found: f64, wanted: f64, tolerance: f64) {
        self.ratio(what, ((found - wanted) / wanted).abs(), tolerance);
    }

    fn add(&mut self, what: impl Into<String>, error: f64, tolerance: f64, unit: &'static str) {
        self.rows.push(Row { case: self.case, what: what.into(), error, tolerance, unit });
    }

    /// A figure without a tolerance.
    fn note(&mut self, what: impl Into<String>, value: f64, unit: &'static str) {
        self.add(what, value, f64::INFINITY, unit);
    }

    fn finish(self) -> Result<Vec<Row>, VerifyError> {
        Ok(self.rows)
    }
}

/// The largest of some errors; NaN if one is NaN, so that it cannot hide.
fn largest(errors: impl IntoIterator<Item = f64>) -> f64 {
    errors.into_iter().fold(0.0, |worst, e| if e.is_nan() || e > worst { e } else { worst })
}

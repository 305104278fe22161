//! Components of an entity. Each component is exactly one of *state* (in the tables, copied on a split, saved), *parameter*
//! (written by the user) and *derived* (rewritten each step, never saved). A component that is absent costs nothing: the
//! system that would read it finds no match.
//!
//! Means of holding tissue have one word each:
//!
//! | word | meaning |
//! |---|---|
//! | [hold](Hold) | prescribed vertices, along a curve over time |
//! | [pin](crate::simulation::Simulation::pin) | a hold at fixed places, put on and taken off between two steps |
//! | [forceps](Forceps) | a tool of the world that the host moves |
//! | [grip](Grip) | forceps by script: when they close, which way they go, when they open |
//! | [jaws](Jaws) | how forceps or a grip hold: radius, stiffness, limit of force |
//! | [grasp](Grasp) | one closing of jaws, and the place where they close |
//! | [pinch](Pinch) | the tissue between closed jaws, with their force on it |

mod body_error;
pub(crate) mod check;
mod check_state;
mod derived;
mod parameter;
mod state;

pub use crate::event::{BlockedNucleation, DecidedBy, PartedBy, RingFault};
pub use crate::math::{FibreFamily, GroundSubstance, HolzapfelGasserOgden, StiffeningFibres};
pub use body_error::BodyError;
pub use derived::evaluation::{ExternalStiffness, Forces, Frames};
#[doc(hidden)]
pub use derived::free_axes::{EachFree, FreeAxes};
#[doc(hidden)]
pub use derived::guide_constraints::GuideConstraints;
pub use derived::ligament_failure::LigamentFailure;
#[doc(hidden)]
pub use derived::solver_scratch::{LineSearch, SolverScratch, StepAccount, Sweeps};
pub use derived::tear_decisions::{RefusedSite, TearDecision, TearDecisions, TearSite};
pub use parameter::attributes::{Attributes, Channel};
pub use parameter::bending::Bending;
pub use parameter::body::{Body, Planar};
pub use parameter::curve::{BadCurve, Curve};
pub use parameter::energy_criterion::EnergyCriterion;
pub use parameter::environment::{Damping, Drag, Gravity, PreStretch, Pressure};
pub use parameter::fibre_laws::{FibreLaws, fibre_law};
pub use parameter::fibres::Fibres;
pub use parameter::grip::{Grip, Grips, NearTip, Path};
pub use parameter::hold::{Hold, Holds};
pub use parameter::hold_guides::{Guide, HoldGuides};
pub use parameter::hull::{Hull, HullError};
pub use parameter::loads::{EdgeLoad, EdgeLoads, PointLoad, PointLoads};
pub use parameter::material::Material;
pub use parameter::obstacle::{Contact, FrictionState, Obstacle, ObstacleMotion, ObstaclePath, Shape};
pub use parameter::refinement::{Refined, Refinement};
#[doc(hidden)]
pub use parameter::sleeping::SleepState;
pub use parameter::sleeping::Sleeping;
pub use parameter::springs::{Anchor, Springs};
pub use parameter::tearing::{InadmissibleToughness, TearMode, Tearing, Toughness};
pub use parameter::turning::{HoldTurns, Turning};
pub use state::blade::Blade;
pub use state::changes::{Change, ChangeSet, Changes};
pub use state::energy_audit::{Energies, EnergyAudit, EnergyBalance};
pub(crate) use state::energy_audit::{Equilibrium, Shares};
pub use state::forceps::{Forceps, Grasp, Jaws, Motion, Pinch, Pose, Slip};
pub use state::guard::{Fault, GuardFigures};
#[doc(hidden)]
pub use state::guard_ledger::GuardLedger;
pub(crate) use state::increment::fraction_of;
pub use state::increment::{Increment, Reactions, Tautness};
#[doc(hidden)]
pub use state::outputs::Outputs;
pub(crate) use state::outputs::OutputsMut;
pub use state::solve_result::SolveResult;
pub use state::step_forces::StepForces;
#[doc(hidden)]
pub use state::stops::Stops;
pub use state::tear_log::TearLog;

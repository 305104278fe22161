//! What an entity can carry. Each component is exactly one of *state* (in the tables, copied on a split, saved), *parameter*
//! (written by the user) and *derived* (rewritten each step, never saved). A component that is absent costs nothing: the
//! system that would read it finds no match.

mod allowed;
mod attributes;
mod bending;
mod blade;
mod body;
mod body_error;
mod changes;
pub(crate) mod check;
mod check_state;
mod curve;
mod derived;
mod energy_audit;
mod energy_criterion;
mod environment;
mod fibre_laws;
mod fibres;
mod forceps;
mod free_axes;
mod grip;
mod guard;
mod hold;
mod hold_guides;
mod hull;
mod loads;
mod material;
mod obstacle;
mod obstacle_check;
mod parting;
mod readings;
mod refinement;
mod sleeping;
mod solid;
mod solver_scratch;
mod springs;
mod step_forces;
mod stops;
mod tear_decisions;
mod tear_log;
mod tearing;
mod turning;

pub use crate::event::{DecidedBy, PartedBy, RingFault, WithheldStart};
pub use crate::math::{FibreFamily, GroundSubstance, HolzapfelGasserOgden, StiffeningFibres};
#[doc(hidden)]
pub use allowed::Allowed;
pub use attributes::{Attributes, Channel};
pub use bending::Bending;
pub use blade::Blade;
pub use body::{Body, Planar};
pub use body_error::BodyError;
pub use changes::{Change, ChangeSet, Changes};
pub use curve::{BadCurve, Curve};
pub(crate) use derived::fraction_of;
pub use derived::{ExternalStiffness, Forces, Frames, Increment, Reactions, Tautness};
pub use energy_audit::{Energies, EnergyAudit, EnergyBalance};
pub(crate) use energy_audit::{Equilibrium, Shares};
pub use energy_criterion::EnergyCriterion;
pub use environment::{Damping, Drag, Gravity, PreStretch, Pressure};
pub use fibre_laws::{FibreLaws, fibre_law};
pub use fibres::Fibres;
pub use forceps::{Forceps, Grasp, Jaws, Motion, Pinch, Pose, Slip};
#[doc(hidden)]
pub use free_axes::{EachFree, FreeAxes};
pub use grip::{Grip, Grips, NearTip, Path};
pub use guard::{Fault, GuardFigures};
pub use hold::{Hold, Holds};
pub use hold_guides::{Guide, HoldGuides};
pub use hull::{Hull, HullError};
pub use loads::{EdgeLoad, EdgeLoads, PointLoad, PointLoads};
pub use material::Material;
pub use obstacle::{Contact, Obstacle, ObstaclePath, Rubbing, Shape, Swept};
pub use parting::Parting;
pub(crate) use readings::Read;
#[doc(hidden)]
pub use readings::Readings;
pub use refinement::{Refined, Refinement};
#[doc(hidden)]
pub use sleeping::SleepState;
pub use sleeping::Sleeping;
#[doc(hidden)]
pub use solver_scratch::{LineSearch, SolverScratch, StepAccount, Sweeps};
pub use springs::{Anchor, Springs};
pub use step_forces::StepForces;
#[doc(hidden)]
pub use stops::Stops;
pub use tear_decisions::{RefusedSite, TearDecision, TearDecisions, TearSite};
pub use tear_log::TearLog;
pub use tearing::{InadmissibleToughness, TearMode, Tearing, Toughness};
pub use turning::{HoldTurns, Turning};

//! Components of an entity. Each component is exactly one of *state* (carried on by steps, saved), *parameter* (written by the
//! user, saved) and *derived* (thrown away at any moment, it comes back the same; never saved). The kind is its folder here, its
//! section in the registry and the word in its doc. A component that is absent costs nothing: the system that would read it finds
//! no match.
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

#[doc(hidden)]
pub use crate::event::{BlockedNucleation, DecidedBy, PartedBy, RingFault};
pub use crate::math::compartment::Content;
pub use crate::math::holzapfel_gasser_ogden::{FibreFamily, GroundSubstance, HolzapfelGasserOgden};
pub use crate::math::relaxation::Branch;
pub use crate::math::stiffening_fibres::StiffeningFibres;
pub use body_error::BodyError;
pub use derived::changes::{Change, ChangeSet, Changes};
#[doc(hidden)]
pub use derived::evaluation::Frames;
pub use derived::evaluation::{ExternalStiffness, Forces};
#[doc(hidden)]
pub use derived::free_axes::{EachFree, FreeAxes};
#[doc(hidden)]
pub use derived::guide_constraints::GuideConstraints;
pub(crate) use derived::layers::{BodyGroup, Bounds, Candidate, Candidates, Layers, Pair, PairSpring, PairStart};
#[doc(hidden)]
pub use derived::outputs::Outputs;
pub(crate) use derived::outputs::OutputsMut;
pub(crate) use derived::rigid_coupling::{RigidCoupling, Six, cholesky, solve_lower, solve_upper};
pub(crate) use derived::solver_scratch::{
    ContactScratch, FrictionPoint, LocalRelaxation, MomentumBalance, Push, Touch,
};
#[doc(hidden)]
pub use derived::solver_scratch::{LineSearch, SolverScratch, StepAccount, Sweeps};
#[doc(hidden)]
pub use derived::stops::Stops;
pub use parameter::attributes::{Attributes, Channel};
pub use parameter::bending::Bending;
pub use parameter::body::{Body, Planar};
pub use parameter::compartment::Compartment;
pub(crate) use parameter::compartment::check_volume;
pub use parameter::curve::{BadCurve, Curve};
pub use parameter::energy_criterion::EnergyCriterion;
pub use parameter::environment::{Damping, Drag, Gravity, PreStretch, Pressure};
#[doc(hidden)]
pub use parameter::fibre_laws::{FibreLaws, fibre_law};
pub use parameter::fibres::Fibres;
pub use parameter::grip::{Grip, Grips, NearTip, Path};
pub use parameter::hold::{Hold, Holds};
pub use parameter::hold_guides::{Guide, HoldGuides};
pub use parameter::hull::{Hull, HullError};
pub use parameter::jaws::{Jaws, Slip};
pub use parameter::loads::{EdgeLoad, EdgeLoads, PointLoad, PointLoads};
pub use parameter::material::Material;
pub use parameter::obstacle::{Contact, Obstacle, ObstaclePath, Shape};
pub use parameter::refinement::Refinement;
pub use parameter::relaxation::Relaxation;
pub use parameter::self_contact::SelfContact;
pub use parameter::sleeping::Sleeping;
pub use parameter::springs::{Anchor, Bond, Springs};
pub use parameter::tearing::{InadmissibleToughness, TearMode, TearRate, Tearing, Toughness};
pub use parameter::turning::{HoldTurns, Turning};
pub use state::blade::Blade;
pub use state::compartment_state::CompartmentState;
#[doc(hidden)]
pub use state::compartment_state::VolumeStiffness;
pub(crate) use state::compartment_state::{CompartmentWork, Outcome, Trial};
pub use state::energy_audit::{Energies, EnergyAudit, EnergyBalance};
pub(crate) use state::energy_audit::{Equilibrium, Shares};
pub use state::forceps::{Forceps, Grasp, Motion, Pose};
#[doc(hidden)]
pub use state::forceps::{JawsTarget, Pinch};
#[doc(hidden)]
pub use state::guard::{Fault, GuardFigures};
#[doc(hidden)]
pub use state::guard_ledger::GuardLedger;
#[doc(hidden)]
pub use state::increment::Increment;
pub use state::increment::Reactions;
pub(crate) use state::last_step::FrictionContact;
#[doc(hidden)]
pub use state::last_step::LastStep;
pub(crate) use state::ligament_failure::LigamentFailure;
#[doc(hidden)]
pub use state::obstacle_motion::{ContactForces, ObstacleMotion};
pub(crate) use state::obstacle_motion::{RigidState, RigidStep};
#[doc(hidden)]
pub use state::refined::Refined;
pub use state::rigid::Rigid;
pub(crate) use state::rigid::turned_inertia;
#[doc(hidden)]
pub use state::sleep_state::SleepState;
pub use state::solve_result::SolveResult;
#[doc(hidden)]
pub use state::step_forces::StepForces;
pub use state::tear_decisions::TearDecision;
#[doc(hidden)]
pub use state::tear_decisions::{RefusedSite, TearDecisions, TearSite, TipGlide};
pub use state::tear_log::TearLog;

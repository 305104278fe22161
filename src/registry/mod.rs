//! The registry of components: each is named once, with its kind, and all that is done with every one of them is made from that list:
//! validation of input, snapshots, recordings, [`Simulation::set`](crate::simulation::Simulation::set).
//!
//! The check of a component stands in its own file. A new component is its own file, its system and a line here (two where
//! hosts change it); a line that is saved or
//! moved is a new version of the bytes (`snapshot::bytes::VERSION`).

mod check;
mod companions;
mod parameters;

pub use check::Rejected;
pub(crate) use check::{
    Changed, Look, check_changed, check_rules, owner_of, validate, validate_all, validate_tables, with_host,
};
pub(crate) use companions::{complete, complete_in};
pub(crate) use parameters::{ParameterVisitor, Parameters};

use crate::components::check::Check;

/// Hands the list to a macro. Each section begins with the kind of its components. *Saved* ones are in snapshots, *remade* ones in
/// part: they are rebuilt from it. Hosts may change *recorded* ones between two calls. Those *saved last* stand at the end of an entity's bytes, which
/// are those of older versions where they are not there.
macro_rules! components {
    ($made:ident) => {
        $made! {
            parameter, saved, recorded {
                holds: Holds,
                hold_turns: HoldTurns,
                hold_guides: HoldGuides,
                springs: Springs,
                grips: Grips,
                point_loads: PointLoads,
                edge_loads: EdgeLoads,
                damping: Damping,
                gravity: Gravity,
                pressure: Pressure,
                drag: Drag,
                pre_stretch: PreStretch,
                stiffening_fibres: StiffeningFibres,
                holzapfel_gasser_ogden: HolzapfelGasserOgden,
                contact: Contact,
                bending: Bending,
                tearing: Tearing,
                energy_criterion: EnergyCriterion,
                refinement: Refinement,
                sleeping: Sleeping,
                obstacle: Obstacle,
                obstacle_path: ObstaclePath,
                attributes: Attributes,
            }
            state, saved, recorded {
                forceps: Forceps,
                blade: Blade,
            }
            parameter, saved last, recorded {
                relaxation: Relaxation,
                compartment: Compartment,
            }
            state, saved last {
                contents: CompartmentState,
            }
            parameter, saved {
                body: Body,
                planar: Planar,
            }
            state, saved {
                vertices: Vertices,
                triangles: Triangles,
                tips: Tips,
                increment: Increment,
                step_forces: StepForces,
                refined: Refined,
                tear_log: TearLog,
                energy_audit: EnergyAudit,
            }
            state, saved, of the last step {
                reactions: Reactions,
                obstacle_motion: ObstacleMotion,
                contact_forces: ContactForces,
                tear_decisions: TearDecisions,
            }
            derived {
                has_frames: Frames,
                has_forces: Forces,
                has_external_stiffness: ExternalStiffness,
                has_tear_scratch: TearScratch,
                has_tip_memory: TipMemory,
                has_folds: DihedralAngles,
                has_changes: Changes,
            }
            state, remade {
                result: SolveResult,
                ledger: GuardLedger,
                factor: Factor,
                mixed: MixedSolver,
            }
            derived, remade {
                topology: Topology,
                scratch: SolverScratch,
                passes: BendingPasses,
            }
        }
    };
}
pub(crate) use components;

/// Hands the recorded components to a macro by name, each with the value that a new one starts from, where it has one.
#[doc(hidden)]
#[macro_export]
macro_rules! recorded_components {
    ($made:ident) => {
        $made! {
            Attributes or Attributes::default();
            Bending or Bending::default();
            Blade;
            Compartment or Compartment::default();
            Contact or Contact::default();
            Damping;
            Drag;
            EdgeLoads or EdgeLoads::default();
            EnergyCriterion;
            Forceps;
            Gravity;
            Grips or Grips::default();
            HoldGuides or HoldGuides::default();
            HoldTurns or HoldTurns::default();
            Holds or Holds::default();
            HolzapfelGasserOgden or HolzapfelGasserOgden::default();
            Obstacle;
            ObstaclePath;
            PointLoads or PointLoads::default();
            PreStretch;
            Pressure;
            Refinement or Refinement::default();
            Relaxation or Relaxation::default();
            Sleeping or Sleeping::default();
            Springs;
            StiffeningFibres;
            Tearing or Tearing::default();
        }
    };
}

/// Seal of the components of the list.
pub(crate) mod sealed {
    use super::{Check, Parameters};

    /// A recorded component.
    pub trait Listed: Check {
        /// List of changes with this one alone: its new value, or its removal.
        fn change(to: Option<Self>) -> Parameters
        where
            Self: Sized;
    }
}

/// A component that hosts may change while a simulation runs, by [`Simulation::set`](crate::simulation::Simulation::set): the recorded
/// ones of the engine, and no others.
pub trait Parameter: hecs::Component + Clone + PartialEq + sealed::Listed {
    /// Name of the component in errors.
    const NAME: &'static str;
}

//! *Parameters*: values that the user has written. A step changes none of them.

pub(super) mod attributes;
pub(super) mod bending;
pub(super) mod body;
pub(super) mod compartment;
pub(super) mod curve;
pub(super) mod energy_criterion;
pub(super) mod environment;
pub(super) mod fibre_laws;
pub(super) mod fibres;
pub(super) mod grip;
pub(super) mod hold;
pub(super) mod hold_guides;
pub(super) mod hull;
pub(super) mod jaws;
pub(super) mod loads;
pub(super) mod material;
pub(super) mod obstacle;
pub(super) mod obstacle_check;
pub(super) mod refinement;
pub(super) mod relaxation;
#[cfg(feature = "snapshot")]
mod saved_anchor;
#[cfg(feature = "snapshot")]
mod saved_contact;
#[cfg(feature = "snapshot")]
mod saved_grip;
#[cfg(feature = "snapshot")]
mod saved_tearing;
pub(super) mod self_contact;
pub(super) mod sleeping;
pub(super) mod solid;
pub(super) mod springs;
pub(super) mod tearing;
pub(super) mod turning;

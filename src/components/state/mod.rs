//! *State*: values that steps carry on and snapshots save, including ledgers and reports of the last step.

pub(super) mod blade;
pub(super) mod compartment_state;
pub(super) mod energy_audit;
pub(super) mod forceps;
pub(super) mod guard;
pub(super) mod guard_ledger;
pub(super) mod increment;
pub(super) mod last_step;
pub(super) mod ligament_failure;
pub(super) mod obstacle_motion;
pub(super) mod refined;
pub(super) mod rigid;
#[cfg(feature = "snapshot")]
mod saved_balance;
#[cfg(feature = "snapshot")]
mod saved_pinch;
pub(super) mod sleep_state;
pub(super) mod solve_result;
pub(super) mod step_forces;
pub(super) mod tear_decisions;
pub(super) mod tear_log;

//! *State*: values that steps carry on and snapshots save, including ledgers and reports of the last step.

pub(super) mod blade;
pub(super) mod changes;
pub(super) mod energy_audit;
pub(super) mod forceps;
pub(super) mod guard;
pub(super) mod guard_ledger;
pub(super) mod increment;
pub(super) mod outputs;
pub(super) mod solve_result;
pub(super) mod step_forces;
pub(super) mod stops;
pub(super) mod tear_log;

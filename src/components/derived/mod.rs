//! *Derived*: values that each step rewrites.

pub(super) mod allowed;
pub(super) mod evaluation;
pub(super) mod free_axes;
pub(super) mod parting;
pub(super) mod solver_scratch;
pub(super) mod tear_decisions;

//! *Derived*: values that each step rewrites.

pub(super) mod evaluation;
pub(super) mod free_axes;
pub(super) mod guide_constraints;
pub(super) mod ligament_failure;
pub(super) mod solver_scratch;
pub(super) mod tear_decisions;

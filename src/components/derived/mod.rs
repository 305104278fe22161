//! *Derived*: values that can be thrown away at any moment and come back the same; most of them each step rewrites.

pub(super) mod changes;
pub(super) mod evaluation;
pub(super) mod free_axes;
pub(super) mod guide_constraints;
pub(super) mod layers;
pub(super) mod outputs;
pub(super) mod rigid_coupling;
pub(super) mod solver_scratch;
pub(super) mod stops;

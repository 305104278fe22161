//! The mesh around tears: refinement and coarsening, detection of fragments and ligaments.

pub(super) mod bisect;
pub(super) mod coarsen;
pub(super) mod fragment;
pub(super) mod ligaments;
pub mod refine;

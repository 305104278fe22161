//! Edits of the mesh around tears: refinement, coarsening, fragments and ligaments.

pub(super) mod bisect;
pub(super) mod coarsen;
pub(super) mod fragment;
pub(super) mod ligaments;
pub mod refine;

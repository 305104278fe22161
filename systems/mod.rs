//! Behaviour: one file per system of the step, and the kernels they share.

pub mod kernels;

//! The step: its list of systems, time integration, sleep.

pub mod integrate;
pub mod schedule;
pub mod sleep;

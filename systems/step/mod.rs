//! The step: its list of systems, their order and loops, retries, time integration, sleep.

pub mod faults;
pub mod integrate;
pub mod phases;
pub mod retry;
pub mod run;
pub mod schedule;
pub mod sleep;

//! Behaviour: one file per system of the step, wired into an order by [`crate::schedule`].
//!
//! A system is a plain function of the world and the step's context. Its query is its declaration: what it borrows mutably it
//! writes, what it borrows it reads, and a body without one of the components is not touched. It returns how many bodies it
//! ran on. Systems do not name each other; what two of them need is a kernel, or the linear operator in [`linear`].

pub mod assembly;
pub mod bending;
pub mod contact;
pub mod contain;
pub mod context;
pub mod corners;
pub mod corotation;
pub mod criterion;
pub mod drag;
pub mod energy;
pub mod gravity;
pub mod grip;
pub mod hold;
pub mod integrate;
pub mod kernels;
pub mod linear;
pub mod loads;
pub mod parallel;
pub mod pressure;
pub mod refine;
pub mod sleep;
pub mod solve;
pub mod split;
pub mod springs;
pub mod tearing;

pub use context::{Formula, StepContext};

//! Behaviour: one file per system of the step, wired into an order by [`crate::systems::step::schedule`].
//!
//! A system is a plain function of the world and the step's context. Its query is its declaration: it writes the components
//! that it borrows mutably and reads the others, and a body without one of the components is not touched. It returns how many
//! bodies it ran on. Systems do not name each other; code that two of them need is a kernel, or the linear operator in
//! [`solver`].

pub mod bending;
pub mod contact;
pub mod context;
pub mod forces;
pub mod fracture;
pub mod guard;
pub mod kernels;
pub mod parallel;
pub mod solver;
pub mod step;
pub mod tools;
pub mod work;

pub use context::{Formula, StepContext};

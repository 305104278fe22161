//! Measures of a tear: course and opening as surgeons judge them, and the account of its energy.
//!
//! ```
//! use rhexis_scene::{Scene, measures::{Outcome, TearCourse}};
//! let mut instance = Scene::named("capsulorhexis")?.instantiate()?;
//! let world = instance.simulation.world();
//! let mut course = TearCourse::new(world, instance.bodies[0], 0.0).ok_or("the body has no rim")?;
//! for _ in 0..3 {
//!     instance.advance()?;
//!     let events: Vec<_> = instance.simulation.drain_events().collect();
//!     course.note(instance.simulation.world(), instance.simulation.time(), &events);
//! }
//! assert_eq!(course.figures().outcome, Outcome::Unfinished);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod hand_force;
mod opening;
mod outline;
mod tear_account;
mod tear_course;
mod tool_motion;

pub use hand_force::{HandForce, HandForceFigures};
pub use opening::{Axis, Opening};
pub use outline::{OpticOverlap, spikes};
pub use tear_account::{AccountFigures, Overshoot, TearAccount, TearSpan};
pub use tear_course::{CourseFigures, GraspFigures, Limits, Outcome, TearCourse};

//! What criterion and split share: the stress at a tip, and the geometry of an advancing tear.

mod tip_decision;
mod tip_stress;

pub use tip_decision::{decision, strength, tip_decision};
pub use tip_stress::{DiscAverage, Surface, disc_average};

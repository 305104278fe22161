//! Cases of the group `tear`.

pub mod energy;

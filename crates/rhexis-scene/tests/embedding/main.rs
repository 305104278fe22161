//! What a host relies on, in scenes: equal bits, going back, a mesh file torn.

mod determinism;
mod examples;
mod hands;
mod snapshot;
mod whole_tear;

#[path = "../../../../tests/common/mod.rs"]
mod common;

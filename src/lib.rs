//! Rhexis: an embeddable, data-oriented engine for the real-time tearing of fibre-reinforced soft-tissue membranes.

#[cfg(feature = "cli")]
pub mod cli;
pub mod components;
pub mod event;
pub mod frame;
pub mod math;
pub mod membrane;
#[cfg(feature = "cli")]
pub mod output;
pub mod report;
#[cfg(feature = "scenes")]
pub mod scene;
pub mod schedule;
pub mod settings;
pub mod simulation;
pub mod storage;
#[cfg(feature = "cli")]
pub mod verify;

#[path = "../systems/mod.rs"]
pub mod systems;

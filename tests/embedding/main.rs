//! What a host relies on: its hold on a simulation, equal bits, going back, sleep, and bad calls and bodies contained.

mod absence;
mod absurd;
mod derived;
mod doors;
mod early_stop;
mod embed;
mod examples;
mod forces;
mod guarded;
mod hostile_calls;
mod migration;
mod obstacles;
mod one_bad_body;
#[cfg(feature = "snapshot")]
mod play;
mod reorder;
mod replay;
mod rollback;
mod sleep;
mod undone;

#[path = "../common/mod.rs"]
mod common;

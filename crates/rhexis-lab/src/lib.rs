//! What judges the engine: comparisons with independent results, benchmarks at equal error, random hostile tools, maps of stability,
//! and minutes of tearing that must not leak. Each is a subcommand of the program `rhexis`.

#![cfg_attr(not(test), warn(clippy::disallowed_methods, unreachable_pub))]
#![cfg_attr(not(test), warn(clippy::expect_used, clippy::panic, clippy::unreachable, clippy::unwrap_used))]

#[allow(clippy::disallowed_methods, reason = "figures and plots of runs, no part of a step")]
pub mod bench;
pub mod soak;
#[allow(clippy::disallowed_methods, reason = "maps of runs, no part of a step")]
pub mod stability;
pub mod stress;
#[allow(clippy::disallowed_methods, reason = "exact solutions beside the engine, no part of a step")]
pub mod verify;

/// DejaVu Sans: bare machines have no fonts, so one is part of the program (licence beside it).
#[doc(hidden)]
pub static FONT: &[u8] = include_bytes!("../assets/fonts/DejaVuSans.ttf");

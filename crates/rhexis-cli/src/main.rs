//! The `rhexis` program; everything it does is in [`rhexis_cli`].

use stats_alloc::{INSTRUMENTED_SYSTEM, StatsAlloc};
use std::alloc::System;

/// Counts, so that `rhexis bench systems` can tell what a body and a step take. A warm step allocates nothing: it costs no time.
#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

fn main() -> std::process::ExitCode {
    rhexis_cli::main()
}

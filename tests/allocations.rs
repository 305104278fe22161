//! A step allocates nothing once it is warm. One test alone in its process: the counter sees every thread.

mod common;

use common::Square;
use rhexis::components::Tearing;
use rhexis::settings::Settings;
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};
use std::alloc::System;

#[global_allocator]
static GLOBAL: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Allocations, growths included, while `work` runs.
fn allocations(work: impl FnOnce()) -> usize {
    let region = Region::new(GLOBAL);
    work();
    let change = region.change();
    change.allocations + change.reallocations
}

#[test]
fn a_warm_step_allocates_nothing() {
    let strong = Tearing { strength_fibre: 1e6, strength_transverse: 1e6, ..Tearing::default() };
    for threads in [1, 2] {
        let square = Square { tearing: strong, ..Square::new([40, 34], 60.0) };
        let mut run = square.spawn(Settings { threads, ..Settings::default() });
        for _ in 0..20 {
            run.simulation.step(1.0).unwrap();
        }
        let count = allocations(|| {
            for _ in 0..1000 {
                run.simulation.step(1.0).unwrap();
            }
        });
        println!("{threads} threads: {count} allocations in 1000 elastic steps");
    }
    let mut run = Square::new([40, 34], 60.0).spawn(Settings { threads: 1, ..Settings::default() });
    run.stretch_to(0.65);
    for _ in 0..200 {
        let before = run.log().advance_count;
        let count = allocations(|| {
            run.simulation.step(2.0).unwrap();
        });
        run.events.extend(run.simulation.drain_events());
        let advances = run.log().advance_count - before;
        println!("{advances} advances: {count} allocations");
    }
}

//! A short soak, on a coarse capsule: what is on the heap after a round is what was there before it. One test alone in its process: the
//! counter sees every thread.

use rhexis_lab::soak::{Soak, Verdict};
use stats_alloc::{INSTRUMENTED_SYSTEM, StatsAlloc};
use std::alloc::System;

#[global_allocator]
static GLOBAL: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

#[test]
fn rounds_leave_nothing_behind() {
    let sets = [
        "bodies.0.mesh.cap.triangles=1500",
        "bodies.0.refinement.budget=1.2",
        "bodies.0.refinement.edge=0.15",
        "run.advanced.preconditioner=incomplete_cholesky",
    ];
    let mut soak = Soak::new(&sets.map(str::to_owned), 1).unwrap();
    (0..24).for_each(|_| soak.round().unwrap());
    let rounds = soak.rounds();
    rounds.iter().for_each(|round| println!("{} bytes after {} steps", round.heap, round.steps));
    assert!(rounds.iter().map(|round| round.tears).sum::<u64>() > 24, "the tear goes on in every round");
    let Verdict { heap_growth, is_same, .. } = Verdict::of(rounds).unwrap();
    assert!(is_same, "every round ends in the same state");
    // A list may come to be longer once more; 1e-4 is 0.3 kB. Less is no fault: lists that steps taken in parts have made go with their
    // simulation where a round begins with another one.
    assert!(heap_growth < 1e-4, "{heap_growth}");
}

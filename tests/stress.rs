//! Hostile random tools on random scenes: the quick part of `rhexis stress`.
#![cfg(feature = "cli")]

use rhexis::stress;

#[test]
fn some_cases_break_nothing() {
    let mut steps = 0;
    for case in 0..25 {
        let outcome = stress::run(1, case);
        assert_eq!(outcome.failure, None, "case {case}");
        steps += outcome.counts.steps;
    }
    assert!(steps > 500, "{steps}");
}

/// Cases that have gained energy: tissue turned into its mirror image in a plane, damped sheets that spin and
/// damped ones that go back within a step.
#[test]
fn cases_that_once_gained_energy_gain_none() {
    for (seed, case) in
        [(3, 18), (3, 100), (3, 345), (3, 360), (3, 409), (3, 481), (3, 655), (3, 682), (3, 697), (3, 807)]
    {
        assert_eq!(stress::run(seed, case).failure, None, "seed {seed}, case {case}");
    }
}

#[test]
fn a_case_is_the_same_whenever_it_is_run() {
    let [mut one, mut other] = [(); 2].map(|()| stress::run(7, 3).counts);
    (one.slowest_step, other.slowest_step) = (0.0, 0.0);
    assert_eq!(one, other);
}

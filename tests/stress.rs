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

#[test]
fn a_case_is_the_same_whenever_it_is_run() {
    let [mut one, mut other] = [(); 2].map(|()| stress::run(7, 3).counts);
    (one.slowest_step, other.slowest_step) = (0.0, 0.0);
    assert_eq!(one, other);
}

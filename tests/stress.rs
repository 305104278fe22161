//! Hostile random tools on random scenes: the quick part of `rhexis stress`.
#![cfg(feature = "cli")]

use rhexis::stress;

fn assert_sound(cases: impl IntoIterator<Item = u64>) {
    for case in cases {
        let outcome = stress::run(1, case);
        assert_eq!(outcome.failure, None, "case {case}");
        assert!(outcome.counts.steps > 0, "case {case}");
    }
}

#[test]
fn some_cases_break_nothing() {
    assert_sound([4, 7, 8, 9, 11]);
}

#[test]
fn a_snapshot_of_a_body_just_set_elsewhere_is_read_back() {
    // `Simulation::teleport` left velocities of a start that it had taken away.
    assert_sound([13, 38, 75]);
}

#[test]
fn a_body_that_is_held_back_again_and_again_gains_no_energy() {
    // Where a body was not let go at all, what it had gained before was forgotten, and it gained another share.
    assert_sound([95, 203, 229]);
}

#[test]
fn a_case_is_the_same_whenever_it_is_run() {
    let [mut one, mut other] = [(); 2].map(|()| stress::run(7, 3).counts);
    (one.slowest_step, other.slowest_step) = (0.0, 0.0);
    assert_eq!(one, other);
}

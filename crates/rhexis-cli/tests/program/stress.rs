//! Hostile random tools on random scenes: the quick part of `rhexis stress`.

use rhexis_lab::stress;

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

fn break_nothing(cases: &[(u64, u64)]) {
    for &(seed, case) in cases {
        assert_eq!(stress::run(seed, case).failure, None, "seed {seed}, case {case}");
    }
}

#[test]
fn cases_that_once_gained_energy_gain_none() {
    // Tissue turned into its mirror image in a plane, damped sheets that spin and damped ones that go back within a step.
    break_nothing(&[(3, 18), (3, 100), (3, 345), (3, 360), (3, 409), (3, 481), (3, 655), (3, 682), (3, 697)]);
    // The exact tangent of a body that bends; a second solve that counted what was motion at the start and stored since twice.
    break_nothing(&[(31, 7393), (31, 610)]);
    // Folds at 180 degrees between crushed triangles, in the second solve of a part of a step that goes next to nowhere.
    break_nothing(&[(1016, 836), (1017, 4670)]);
}

/// One of two bodies in contact tears no further while the other's step is redone.
#[test]
fn bodies_that_have_done_their_step_are_left_as_they_are() {
    break_nothing(&[(31, 11_615), (31, 13_071), (31, 19_855)]);
}

/// Tips that glide: lips that were halved into slivers, rows that a collapse had taken away, levels of multigrid that a glide had left behind.
#[test]
fn tips_that_glide_break_nothing() {
    let glides: Vec<(u64, u64)> = (0..25).map(|case| (10_000, case)).collect();
    break_nothing(&glides);
}

/// A body that pressure has blown up to 1e155 mm is set spinning.
#[test]
fn no_velocity_is_set_whose_energy_is_not_finite() {
    break_nothing(&[(31, 5763)]);
}

#[test]
fn a_case_is_the_same_whenever_it_is_run() {
    let [mut one, mut other] = [(); 2].map(|()| stress::run(7, 3).counts);
    (one.slowest_step, other.slowest_step) = (0.0, 0.0);
    assert_eq!(one, other);
}

/// Bodies that touch each other: one asleep since the start, which no solve has given stresses, and a rigid obstacle between two that is thrown beyond the range of coordinates.
#[test]
fn bodies_that_touch_each_other_break_nothing() {
    break_nothing(&[(40_000, 0), (40_000, 1), (40_001, 23), (40_001, 42)]);
}

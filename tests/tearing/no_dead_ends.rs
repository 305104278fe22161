//! A tear leaves a piece or a live tip, turns as much over a length however small its advances, splits where two ways tie, and
//! tissue fails without a tip where it is a narrow ligament or stretched too far.

use crate::common::{Run, SIDE, Square};
use glam::DVec3;
use rhexis::components::{PartedBy, Tearing};
use rhexis::event::{EventKind, Renewal};
use rhexis::settings::Settings;
use rhexis::storage::Tips;
use rhexis::systems::fracture::turned_axis;
use std::f64::consts::{FRAC_PI_2, PI};

fn mm(x: f64, y: f64) -> DVec3 {
    DVec3::new(x, y, 0.0)
}

fn one_thread() -> Settings {
    Settings { threads: 1, ..Settings::default() }
}

/// Strength that no test reaches.
fn strong(radius: f64) -> Tearing {
    Tearing { strength_across_fibres: 1e6, strength_along_fibres: 1e6, radius, ..Tearing::default() }
}

fn tips(run: &Run) -> Vec<DVec3> {
    let world = run.simulation.world();
    let vertices = world.get::<&rhexis::storage::Vertices>(run.body.entity()).unwrap();
    world.get::<&Tips>(run.body.entity()).unwrap().vertex.iter().map(|&v| vertices.rest_position[v as usize]).collect()
}

/// Steps until `is_done`, which need not come.
fn try_until(run: &mut Run, limit: usize, is_done: impl Fn(&Run) -> bool) {
    for _ in 0..limit {
        if is_done(run) {
            return;
        }
        run.step();
    }
}

fn count(run: &Run, is_such: impl Fn(&EventKind) -> bool) -> u32 {
    run.events.iter().filter(|event| is_such(&event.kind)).count() as u32
}

#[test]
fn the_cones_axis_turns_over_a_length_not_per_advance() {
    let tearing = Tearing { radius: 1.5, ..Tearing::default() };
    let wanted = mm(-0.6, 0.8);
    for length in [0.1, 0.4, 0.9] {
        let at_once = turned_axis(DVec3::X, wanted, length, &tearing);
        for parts in [2, 7, 50] {
            let step = |axis, _| turned_axis(axis, wanted, length / f64::from(parts), &tearing);
            let in_parts = (0..parts).fold(DVec3::X, step);
            // Fifty rotations, each exact to some roundings.
            assert!((in_parts - at_once).length() < 1e-13, "{length} mm in {parts}: {in_parts} {at_once}");
        }
        // θ_P per R, until the axis is the tear's own direction.
        let turn = (FRAC_PI_2 * length / 1.5).min(wanted.x.acos());
        assert!((at_once.x.acos() - turn).abs() < 1e-13, "{length} mm");
    }
}

#[test]
fn a_tear_that_hardly_turns_is_its_own_axis_to_the_bit() {
    let tearing = Tearing::default();
    let wanted = DVec3::new(0.96, 0.28, 0.0);
    assert_eq!(turned_axis(DVec3::X, wanted, 0.4, &tearing), wanted);
    assert_eq!(turned_axis(DVec3::ZERO, wanted, 1e-6, &tearing), wanted);
    // A half turn admits everything: there is no axis to keep.
    assert_eq!(turned_axis(DVec3::X, -DVec3::X, 1e-6, &Tearing { cone: PI, ..tearing }), -DVec3::X);
}

#[test]
fn tissue_beyond_its_ultimate_stretch_parts() {
    let torn = |ultimate_stretch: Option<f64>| {
        let tearing = Tearing { ultimate_stretch, ..strong(1.0) };
        let square = Square { tearing, notches: Vec::new(), ..Square::isotropic([12, 9]) };
        let mut run = square.spawn(one_thread());
        try_until(&mut run, 80, |run| run.log().fragment_count > 0);
        run.assert_sound();
        run
    };
    // 80 steps stretch the sheet by 16 %.
    let run = torn(Some(1.05));
    let log = run.log();
    assert!(log.parted_count > 0 && log.fragment_count > 0, "{log:?}");
    let is_stretch =
        |kind: &EventKind| matches!(kind, EventKind::Parted { by: PartedBy::Stretch, value, .. } if *value > 1.0);
    assert_eq!(count(&run, is_stretch), log.parted_count);
    assert_eq!(run.fragment_count() as u32, 1 + log.fragment_count);
    let run = torn(None);
    assert_eq!((run.log().parted_count, run.fragment_count()), (0, 1));
}

/// A bite out of the rim without a tip, and R wider than what is left beside it.
#[test]
fn a_ligament_narrower_than_r_parts_beyond_its_strength() {
    let torn = |strength: f64| {
        let tearing = Tearing { strength_across_fibres: strength, strength_along_fibres: strength, ..strong(5.0) };
        let square = Square { tearing, notches: Vec::new(), ..Square::isotropic([30, 30]) };
        let mut run = square.spawn(one_thread());
        // Two bites, from above and from below, leave 3 mm.
        for bite in [[mm(10.0, 30.0), mm(15.0, 16.5), mm(20.0, 30.0)], [mm(10.0, 0.0), mm(15.0, 13.5), mm(20.0, 0.0)]] {
            run.simulation.cut(run.body, &bite).unwrap();
        }
        assert_eq!(tips(&run), []);
        let bites = run.log().fragment_count;
        assert_eq!(bites, 2);
        try_until(&mut run, 60, |run| run.log().fragment_count > bites);
        run.assert_sound();
        run
    };
    let run = torn(0.2);
    let log = run.log();
    assert_eq!((log.parted_count, log.nucleation_count, log.fragment_count), (1, 0, 3), "{log:?}");
    let is_ligament =
        |kind: &EventKind| matches!(kind, EventKind::Parted { by: PartedBy::Ligament, value, .. } if *value > 1.0);
    assert_eq!((count(&run, is_ligament), run.fragment_count()), (1, 4));
    assert_eq!(torn(1e6).log().parted_count, 0);
}

/// Fibres across the notch, so weak along themselves that the two ways along them tie.
#[test]
fn a_notch_whose_ways_tie_tears_both_ways() {
    let torn = |branch_margin: Option<f64>| {
        let mut square = Square::isotropic([30, 30]);
        square.notches = vec![[mm(15.0, 30.0), mm(15.0, 20.0)]];
        square.tearing = Tearing {
            strength_across_fibres: 50.0,
            strength_along_fibres: 0.02,
            radius: 3.0,
            branch_margin,
            ..square.tearing
        };
        let mut run = square.spawn(one_thread());
        try_until(&mut run, 60, |run| run.log().advance_count >= 2);
        run.assert_sound();
        run
    };
    // The mesh's diagonals all lean one way, so the tie is one to some parts in a hundred.
    let run = torn(Some(0.1));
    let log = run.log();
    assert_eq!((log.branch_count, tips(&run).len()), (1, 2), "{log:?} {:?}", tips(&run));
    let is_branch = |kind: &EventKind| matches!(kind, EventKind::Renewed { by: Renewal::Branch, .. });
    assert_eq!(count(&run, is_branch), 1);
    let at = tips(&run);
    assert!((at[0].x - 15.0) * (at[1].x - 15.0) < 0.0 && at.iter().all(|at| (at.y - 20.0).abs() < 0.2), "{at:?}");
    assert_eq!(torn(None).log().branch_count, 0);
}

/// A hook that ends before its own lip: its tip cuts a chip out and ends, and the notch that is left goes on.
#[test]
fn a_tear_that_bites_its_own_lip_leaves_a_live_tip() {
    let mut square = Square::isotropic([30, 30]);
    square.notches = Vec::new();
    square.tearing =
        Tearing { strength_across_fibres: 2e-3, strength_along_fibres: 2e-3, radius: 3.0, ..square.tearing };
    let mut run = square.spawn(one_thread());
    let hook = [mm(15.0, 30.0), mm(15.0, 18.0), mm(17.0, 17.0), mm(18.0, 19.0), mm(15.9, 20.2)];
    run.simulation.cut(run.body, &hook).unwrap();
    assert_eq!(tips(&run).len(), 1);
    run.run_until(60, |run| run.log().end_count > 0);
    run.assert_sound();
    let log = run.log();
    assert_eq!((log.end_count, log.renewed_count, tips(&run).len()), (1, 1, 1), "{:?}", tips(&run));
    let torn = log.length;
    // So weak that ligaments between the hook and the lip part as well.
    run.run_until(100, |run| run.log().length > torn + square.tearing.radius);
    run.assert_sound();
    assert!(tips(&run).iter().all(|at| at.y < SIDE));
}

//! A step that cannot leave a finite state leaves the last good one, and says so.

use crate::common::{self, DT, Square, state_bits};
use glam::DVec3;
use rhexis::components::{Curve, Holds};
use rhexis::event::EventKind;
use rhexis::settings::Settings;
use rhexis::storage::Vertices;

fn failures(run: &mut common::Run) -> usize {
    run.simulation.drain_events().filter(|e| matches!(e.kind, EventKind::StepFailed { .. })).count()
}

#[test]
fn an_absurd_velocity_is_undone_and_the_body_goes_on_without_it() {
    let mut run = Square::new([20, 16], 45.0).spawn(Settings::default());
    run.step();
    let good = run.vertices().velocity[100];
    for absurd in [1e300, f64::MAX] {
        let poison = |run: &common::Run, v: DVec3| {
            run.simulation.world().get::<&mut Vertices>(run.body.entity()).unwrap().velocity[100] = v;
        };
        poison(&run, DVec3::X * absurd);
        let (before, time) = (state_bits(&run.simulation, run.body), run.simulation.time());
        let report = run.simulation.step(DT).unwrap();
        // The whole step and four halvings of its first part.
        assert!(report.has_failed && report.rolled_back == 5, "{report:?}");
        assert!(state_bits(&run.simulation, run.body) == before && run.simulation.time() == time);
        assert_eq!(failures(&mut run), 1);
        poison(&run, good);
        run.step();
        assert_eq!((run.simulation.report().rolled_back, failures(&mut run)), (0, 0));
    }
}

#[test]
fn a_grip_that_runs_away_stops_the_step_at_the_last_good_moment() {
    let mut run = Square::new([20, 16], 45.0).spawn(Settings::default());
    let away = Curve::new(vec![(0.0, 0.0), (7.0, 0.02), (7.5, 1e200)]).unwrap();
    let holds = |run: &common::Run, curve: &Curve| {
        let mut holds = run.simulation.world().get::<&mut Holds>(run.body.entity()).unwrap();
        holds.groups.iter_mut().for_each(|hold| hold.curve = curve.clone());
    };
    holds(&run, &away);
    let report = run.simulation.step(DT).unwrap();
    // Sixteenths of 10 ms: 6.875 ms is the last before the grip leaves.
    assert!(report.has_failed && report.time == 6.875, "{report:?}");
    assert_eq!(failures(&mut run), 1);
    assert!(run.vertices().position.iter().all(|p| p.length() < 50.0));
    run.assert_sound();
    holds(&run, &Curve::constant(0.02));
    run.step();
}

/// Nothing can be done about a state that is already broken, except to say so.
#[test]
fn a_state_that_is_not_finite_is_reported_and_does_not_panic() {
    let mut run = Square::new([20, 16], 45.0).spawn(Settings::default());
    for broken in [f64::NAN, f64::INFINITY] {
        run.simulation.world().get::<&mut Vertices>(run.body.entity()).unwrap().position[100].x = broken;
        assert!(run.simulation.step(DT).unwrap().has_failed);
        assert_eq!(failures(&mut run), 1);
        assert!(run.simulation.settle(DT, 1e-8).is_err());
        assert!(run.simulation.settle_and_tear(DT, 1e-8, 3).is_err());
        run.simulation.frame();
    }
}

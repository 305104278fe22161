//! A recording repeats everything that a host has done, to the same bits.
#![cfg(feature = "snapshot")]

use crate::common::{self, Square};
use glam::DVec3;
use rhexis::components::{
    Bending, ChangeSet, Changes, Contact, Curve, Fibres, Hold, Holds, Jaws, Material, Obstacle, Path, Pose, Shape,
    Sleeping, Slip, TearLog, Tearing,
};
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::replay::{Input, Recording, ReplayError};
use rhexis::settings::{Advanced, LinearParams, Settings};
use rhexis::simulation::{Grasp, Simulation, Solid};
use rhexis::snapshot::Snapshot;
use rhexis::storage::{Attached, Vertices};
use std::time::Duration;

fn simulation() -> Simulation {
    Simulation::new(Settings { threads: 1, ..Settings::default() }).unwrap()
}

/// Ends the recording and repeats it from its bytes: with all that is kept the same, not the hash alone.
fn repeats(mut simulation: Simulation) -> Recording {
    let bytes = simulation.end_recording().unwrap().to_bytes().unwrap();
    let recording = Recording::from_bytes(&bytes).unwrap();
    let mut again = recording.replay().unwrap();
    assert!(again.snapshot().to_bytes() == simulation.snapshot().to_bytes());
    assert!(again.drain_events().eq(simulation.drain_events()));
    recording
}

#[test]
fn every_call_is_repeated() {
    let mut s = simulation();
    let square = Square::new([16, 14], 60.0);
    let first = s.spawn(square.membrane().with(Sleeping::default())).unwrap();
    s.step(5.0).unwrap();
    s.record();
    let second = s.spawn(square.hanging()).unwrap();
    s.cut(first, &common::NOTCH).unwrap();
    let ball = Obstacle { shape: Shape::Sphere { centre: DVec3::NEG_Z * 40.0, radius: 1.0 } };
    let (obstacle, gone) = (s.spawn_obstacle(ball.clone()).unwrap(), s.spawn_obstacle(ball).unwrap());
    (0..5).for_each(|_| _ = s.step(5.0));
    s.despawn(gone).unwrap();
    assert!(s.despawn(gone).is_err() && s.step(f64::NAN).is_err() && s.cut(first, &[]).is_err());
    s.settle(10.0, 1e-9).unwrap();
    let before = s.snapshot();
    s.reorder(first).unwrap();
    s.settle_and_tear(200.0, 1e-9, 2).unwrap();
    s.linear_response(1.0).unwrap();
    s.restore(&before).unwrap();
    s.entity_mut::<&mut Obstacle>(obstacle).unwrap().shape = Shape::Sphere { centre: DVec3::NEG_Z * 30.0, radius: 2.0 };
    let curve = Curve::new(vec![(0.0, 0.0), (400.0, 1.5)]).unwrap();
    s.entity_mut::<&mut Holds>(first).unwrap().groups.iter_mut().for_each(|hold| hold.curve = curve.clone());
    s.entity_mut::<&mut Vertices>(second).unwrap().velocity.iter_mut().for_each(|v| *v += DVec3::X * 1e-3);
    (0..30).for_each(|_| _ = s.step(10.0));
    s.world_mut().remove_one::<Sleeping>(first.entity()).unwrap();
    s.wake(second).unwrap();
    s.set_settings(Settings { advanced: Advanced { newton_iterations: 3, ..s.settings().advanced }, ..*s.settings() })
        .unwrap();
    let third = s.spawn(square.membrane()).unwrap();
    (0..10).for_each(|_| _ = s.step(10.0));
    s.despawn(third).unwrap();
    assert!(s.world().query::<&TearLog>().iter().any(|log| log.advance_count > 2), "the state must be one after tears");
    let recording = repeats(s);
    assert_eq!(recording.inputs().iter().filter(|input| matches!(input, Input::Change { .. })).count(), 4);
}

/// A host that pins, pulls, cuts and moves things about, on a sheet that bends and touches.
#[test]
fn tools_are_repeated_and_restored() {
    let mut s = simulation();
    let mesh = generate::grid(16.0, 14.0, 16, 14).unwrap();
    let mut sheet = Membrane::new("sheet", mesh, Material::allard_2009()).fibres(Fibres::at_degrees(60.0));
    let members = Attached::new(sheet.select(|p| p.x == 0.0 || p.x == 16.0).into_iter().map(|row| (row, DVec3::ZERO)));
    sheet = sheet.hold(Hold { name: "sides".into(), members, axes: [true; 3], curve: Curve::constant(0.0) });
    sheet = sheet.with(Bending::default()).with(Contact::default()).with(Tearing::default());
    let body = s.spawn(sheet.with(Changes::default())).unwrap();
    s.record();
    let ball = |x: f64| Shape::Sphere { centre: DVec3::new(x, 8.0, -2.1), radius: 2.0 };
    let path = Path { points: vec![(0.0, DVec3::ZERO), (300.0, DVec3::Z)] };
    s.spawn_obstacle(Solid::new(ball(12.0)).path(path)).unwrap();
    let pushed = s.spawn_obstacle(Obstacle { shape: ball(5.0) }).unwrap();
    let middle = DVec3::new(8.0, 4.0, 0.0);
    let jaws = Jaws { radius: 1.5, stiffness: Some(0.5), force_limit: Some(0.02), slip: Slip::Slide };
    let soft = s.spawn_forceps("soft", jaws, Pose::at(middle)).unwrap();
    let rigid =
        s.spawn_forceps("rigid", Jaws { radius: 1.0, ..Jaws::default() }, Pose::at(DVec3::new(3.0, 3.0, 0.0))).unwrap();
    assert!(s.close_forceps(rigid, rigid.entity().into(), &Grasp::Nearest { reach: 1.0 }).is_err());
    for forceps in [soft, rigid] {
        s.close_forceps(forceps, body, &Grasp::Nearest { reach: 1.0 }).unwrap();
    }
    let blade = s.spawn_blade(0.5, 1.0).unwrap();
    let keys: Vec<_> = s.world().get::<&Vertices>(body.entity()).unwrap().keys()[106..110].to_vec();
    s.pin(body, "tool", &keys).unwrap();
    for i in 0..40 {
        let by = DVec3::new(0.02, 0.03, 0.05) * f64::from(i);
        s.move_forceps(soft, Pose::at(middle + by), 5.0).unwrap();
        s.move_pins(body, "tool", |pin| pin.place + DVec3::Z * 0.01).unwrap();
        s.move_obstacle(pushed, ball(5.0 + 0.02 * f64::from(i))).unwrap();
        // Refused or not, as the sheet lies.
        let _ = s.draw_blade(blade, body, DVec3::new(6.0 + 0.2 * f64::from(i), 13.0, 0.0));
        s.step(5.0).unwrap();
        if i == 20 {
            s.open_forceps(rigid).unwrap();
            s.unpin(body, &keys[..2]).unwrap();
            let _ = s.puncture(body, DVec3::new(4.0, 10.0, 0.0), DVec3::X, 2.0);
        }
    }
    s.despawn(blade).unwrap();
    s.unpin_all(body, "tool").unwrap();
    s.set_velocity(body, |x| DVec3::Z * (1e-3 * x.x)).unwrap();
    let before = Snapshot::from_bytes(&s.snapshot().to_bytes().unwrap()).unwrap();
    (0..10).for_each(|_| _ = s.step(5.0));
    let mut other = Simulation::from_snapshot(&before).unwrap();
    (0..10).for_each(|_| _ = other.step(5.0));
    assert!(other.hash() == s.hash() && other.snapshot().to_bytes() == s.snapshot().to_bytes());
    // What a host has a copy of is to be taken anew.
    let mut changes = ChangeSet::default();
    other.drain_changes(body, &mut changes).unwrap();
    assert!(changes.is_whole);
    let log = s.world().get::<&TearLog>(body.entity()).map(|log| log.length).unwrap();
    assert!(log > 2.0, "the blade has cut {log} mm");
    repeats(s);
}

#[test]
fn solves_that_ran_out_of_time_stop_where_they_stopped() {
    for precision in [rhexis::settings::Precision::Mixed, rhexis::settings::Precision::Double] {
        // Times that end some solves early, whatever the machine, and let others end.
        for time in [Duration::ZERO, Duration::from_micros(150), Duration::from_secs(100)] {
            let linear = LinearParams { time: Some(time), tolerance: 1e-7, ..LinearParams::default() };
            let mut s = Simulation::new(Settings {
                threads: 1,
                advanced: Advanced { linear, precision, ..Advanced::default() },
                ..Settings::default()
            })
            .unwrap();
            s.record();
            Square::new([20, 16], 60.0).spawn_into(&mut s);
            let late = (0..50).filter(|_| s.step(6.0).unwrap().bodies[0].is_late).count();
            assert!(if time.is_zero() { late > 40 } else { late == 0 || time < Duration::from_secs(1) }, "{late} late");
            repeats(s);
        }
    }
}

#[test]
fn what_is_not_recorded_is_told() {
    let mut s = simulation();
    s.record();
    let body = Square::new([8, 6], 60.0).spawn_into(&mut s);
    s.step(5.0).unwrap();
    // Through what is there to be looked at.
    s.world().get::<&mut Vertices>(body.entity()).unwrap().velocity[20].x += 1.0;
    s.step(5.0).unwrap();
    let recording = s.end_recording().unwrap();
    assert!(matches!(recording.replay(), Err(ReplayError::Diverged { .. })));
    assert!(s.end_recording().is_none());
}

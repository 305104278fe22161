//! A run that is restored from a snapshot goes on to the same bits as the one that was never interrupted: state, topology,
//! keys, events, and what the solvers remember.
#![cfg(feature = "snapshot")]

use crate::common::{self, Square};
use glam::DVec3;
use rhexis::components::{Curve, EnergyAudit, Grips, Obstacle, Refined, Shape, Sleeping, TearLog};
use rhexis::event::EventKind;
use rhexis::settings::{Advanced, Integrator, Precision, Preconditioner, Settings};
use rhexis::simulation::Simulation;
use rhexis::snapshot::Snapshot;
use rhexis_scene::Document;

/// A run as a function that moves it on by one step.
type Step = fn(&mut Simulation);

/// Every number that is kept, solver memory included.
fn all(simulation: &Simulation) -> Vec<u8> {
    simulation.snapshot().to_bytes().unwrap()
}

/// Runs `steps` steps without a break; then from bytes of a snapshot at each of `at`, in a new simulation.
fn goes_on_alike(what: &str, mut simulation: Simulation, at: &[usize], steps: usize, step: Step) -> Simulation {
    let mut kept = Vec::new();
    let start = simulation.snapshot();
    for i in 0..=steps {
        if at.contains(&i) {
            kept.push((i, all(&simulation)));
        }
        if i < steps {
            step(&mut simulation);
        }
    }
    let end = all(&simulation);
    for (i, bytes) in kept {
        let snapshot = Snapshot::from_bytes(&bytes).unwrap_or_else(|error| panic!("{what}, step {i}: {error}"));
        let mut other = Simulation::from_snapshot(&snapshot).unwrap();
        assert!(all(&other) == bytes, "{what}, step {i}: what is restored is what was kept");
        (i..steps).for_each(|_| step(&mut other));
        assert_eq!(other.hash(), simulation.hash(), "{what}, from step {i}");
        assert!(all(&other) == end, "{what}, from step {i}: what solvers remember");
    }
    // Without the snapshots, from the start: neither taking them nor going back to the start shows.
    let mut again = Simulation::new(*simulation.settings()).unwrap();
    again.restore(&start).unwrap();
    (0..steps).for_each(|_| step(&mut again));
    assert!(all(&again) == end, "{what}, again");
    simulation
}

/// A scene of the catalog with changes.
fn scene(name: &str, changes: &[&str]) -> Simulation {
    let mut document = Document::named(name).unwrap();
    changes.iter().for_each(|change| document.set(change).unwrap());
    document.set("run.threads=1").unwrap();
    document.scene().unwrap().instantiate().unwrap().simulation
}

fn advances(simulation: &Simulation) -> u32 {
    simulation.world().query::<&TearLog>().iter().map(|log| log.advance_count).sum()
}

fn settings(preconditioner: Preconditioner) -> Settings {
    Settings { threads: 1, advanced: Advanced { preconditioner, ..Advanced::default() }, ..Settings::default() }
}

#[test]
fn two_hundred_steps_from_the_middle_of_a_tear() {
    // Levels of multigrid follow the edits.
    let run = goes_on_alike("fig2-tear", scene("fig2-tear", &[]), &[0, 1, 30, 100, 130], 330, |s| _ = s.step(2.0));
    assert!(advances(&run) > 10, "{} advances: it is to tear", advances(&run));
}

#[test]
fn a_capsule_with_grips_and_refinement() {
    let changes = ["bodies.0.mesh.cap.triangles=1500", "bodies.0.tearing.toughness_along_fibres=0.3"];
    let at = [10, 40, 60, 75];
    let run = goes_on_alike("capsulorhexis", scene("capsulorhexis", &changes), &at, 90, |s| _ = s.step(20.0));
    assert!(advances(&run) > 5 && run.world().query::<&Refined>().iter().any(|refined| refined.split_count > 10));
    let is_held = run.world().query::<&Grips>().iter().any(|grips| grips.pinches.iter().any(|pinch| pinch.is_closed()));
    assert!(is_held, "forceps are closed");
}

/// Rows of a factor are dissected from 8,192 triangles on, and edits take some of them to the separator.
#[test]
fn a_large_capsule_as_it_tears() {
    let changes = ["bodies.0.mesh.cap.triangles=9000", "bodies.0.tearing.toughness_along_fibres=0.3"];
    let run = goes_on_alike("large", scene("capsulorhexis", &changes), &[5, 66], 80, |s| _ = s.step(20.0));
    assert!(advances(&run) > 2 && run.world().query::<&Refined>().iter().any(|refined| refined.split_count > 10));
}

#[test]
fn every_way_to_solve() {
    let weak = || {
        let mut square = Square::new([24, 20], 60.0);
        square.tearing.strength_across_fibres *= 0.2;
        square.tearing.strength_along_fibres *= 0.2;
        square
    };
    let kinds = [
        Preconditioner::Auto,
        Preconditioner::BlockJacobi,
        Preconditioner::IncompleteCholesky,
        Preconditioner::Multigrid,
        Preconditioner::Cholesky,
    ];
    let ways = kinds.map(settings).into_iter().chain([
        Settings {
            advanced: Advanced {
                integrator: Integrator::TrBdf2,
                newton_iterations: 2,
                ..settings(Preconditioner::Auto).advanced
            },
            ..settings(Preconditioner::Auto)
        },
        Settings {
            advanced: Advanced { precision: Precision::Double, ..settings(Preconditioner::Multigrid).advanced },
            ..settings(Preconditioner::Multigrid)
        },
        Settings {
            advanced: Advanced { newton_iterations: 4, ..settings(Preconditioner::Multigrid).advanced },
            ..settings(Preconditioner::Multigrid)
        },
    ]);
    for settings in ways {
        let run = weak().spawn(settings).simulation;
        let run = goes_on_alike(&format!("{settings:?}"), run, &[3, 17, 25], 45, |s| _ = s.step(4.0));
        assert!(advances(&run) > 2);
        // A sheet that rests keeps multigrid's numbers for long.
        let mut elastic = Simulation::new(settings).unwrap();
        elastic.spawn(Square::new([24, 20], 45.0).hanging()).unwrap();
        goes_on_alike(&format!("{settings:?}, elastic"), elastic, &[2, 7, 22], 40, |s| _ = s.step(4.0));
    }
}

#[test]
fn static_solves_and_an_audit_of_energy() {
    let membrane = Square::new([16, 14], 60.0).membrane().with(EnergyAudit::default());
    let mut simulation = Simulation::new(settings(Preconditioner::Auto)).unwrap();
    let body = simulation.spawn(membrane).unwrap();
    simulation.cut(body, &common::NOTCH).unwrap();
    let run = goes_on_alike("static", simulation, &[1, 8, 12], 16, |s| {
        if s.report().step % 3 == 1 { _ = s.step(10.0) } else { _ = s.settle_and_tear(40.0, 1e-9, 3) }
    });
    assert!(advances(&run) > 2);
}

#[test]
fn bodies_that_sleep_and_obstacles_that_come_and_go() {
    let curve = Curve::new(vec![(0.0, 0.0), (100.0, 0.5), (2000.0, 0.5), (2100.0, 0.8)]).unwrap();
    let mut simulation = Simulation::new(settings(Preconditioner::Auto)).unwrap();
    let squares = [Square::new([12, 10], 60.0), Square::new([10, 8], 30.0)];
    for square in squares {
        simulation
            .spawn(square.membrane_along(curve.clone()).with(Sleeping { strain: 1e-3, ..Sleeping::default() }))
            .unwrap();
    }
    let ball = |x| Obstacle { shape: Shape::Sphere { centre: DVec3::new(x, 0.0, -50.0), radius: 1.0 } };
    let gone = simulation.spawn_obstacle(ball(0.0)).unwrap();
    simulation.spawn_obstacle(ball(1.0)).unwrap();
    simulation.despawn(gone).unwrap();
    let run = goes_on_alike("sleep", simulation, &[5, 60, 150, 205], 220, |s| _ = s.step(10.0));
    let mut run = run;
    let kinds: Vec<EventKind> = run.drain_events().map(|event| event.kind).collect();
    assert!(kinds.contains(&EventKind::FellAsleep) && kinds.iter().any(|kind| matches!(kind, EventKind::Woke { .. })));
}

#[test]
fn handles_name_what_they_named() {
    let mut simulation = Simulation::new(settings(Preconditioner::Auto)).unwrap();
    let square = Square::new([8, 6], 60.0);
    let bodies = [0, 1, 2].map(|_| square.spawn_into(&mut simulation));
    simulation.despawn(bodies[1]).unwrap();
    let own = simulation.world_mut().spawn(("mine",));
    simulation.world_mut().insert_one(bodies[2].entity(), "my body").unwrap();
    let snapshot = simulation.snapshot();
    let next = simulation.spawn(square.membrane()).unwrap();
    simulation.despawn(bodies[0]).unwrap();
    simulation.restore(&snapshot).unwrap();
    assert_eq!(simulation.bodies(), [bodies[0], bodies[2]]);
    assert!(!simulation.world().contains(next.entity()) && !simulation.world().contains(bodies[1].entity()));
    assert_eq!(*simulation.world().get::<&&str>(own).unwrap(), "mine");
    assert_eq!(*simulation.world().get::<&&str>(bodies[2].entity()).unwrap(), "my body");
    assert_eq!(simulation.spawn(square.membrane()).unwrap(), next, "the same handle as without going back");
    // Of bytes the host's own are not a part, but their handles are kept free for them.
    let mut other = Simulation::from_snapshot(&Snapshot::from_bytes(&snapshot.to_bytes().unwrap()).unwrap()).unwrap();
    assert_eq!(other.bodies(), [bodies[0], bodies[2]]);
    assert!(other.world().contains(own) && other.world().get::<&&str>(own).is_err());
    assert_eq!(other.spawn(square.membrane()).unwrap(), next);
}

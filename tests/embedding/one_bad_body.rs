//! One bad body never harms another: what fails is retried by itself, or stays where it was, and the others take their step.

use crate::common::{DT, Square, state_bits};
use glam::DVec3;
use rhexis::components::{Fibres, Material};
use rhexis::event::EventKind;
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::report::Fault;
use rhexis::settings::{Advanced, Integrator, Settings};
use rhexis::simulation::Simulation;
use rhexis::storage::{BodyId, Vertices};

/// A sheet that nothing holds, crumpled by as much as its own size: its steps are retried down to the smallest parts.
fn crumpled(simulation: &mut Simulation) -> BodyId {
    let mesh = generate::grid(10.0, 10.0, 8, 8).unwrap();
    let sheet = Membrane::new("crumpled", mesh, Material { thickness: 0.015, ..Material::allard_2009() });
    let body = simulation.spawn(sheet.fibres(Fibres::at_degrees(30.0))).unwrap();
    let mut vertices = simulation.world().get::<&mut Vertices>(body.entity()).unwrap();
    for (v, x) in vertices.position.iter_mut().enumerate() {
        let phase = v as f64;
        *x += DVec3::new((7.1 * phase).sin(), (3.3 * phase).sin(), (5.7 * phase).sin()) * 5.0;
    }
    drop(vertices);
    body
}

/// A sheet that nothing holds, one corner of which is drawn out to a spike: as it swings back a step is retried in halves.
fn spiked(simulation: &mut Simulation) -> BodyId {
    let mesh = generate::grid(10.0, 10.0, 8, 8).unwrap();
    let sheet = Membrane::new("spiked", mesh, Material { thickness: 0.015, ..Material::allard_2009() });
    let body = simulation.spawn(sheet.fibres(Fibres::at_degrees(30.0))).unwrap();
    simulation.world().get::<&mut Vertices>(body.entity()).unwrap().position[0] += DVec3::new(0.9, 0.7, 4.0);
    body
}

/// Steps a square that tears, alone or after another body, and returns its state.
fn torn(settings: Settings, steps: usize, mut other: impl FnMut(&mut Simulation) -> Option<BodyId>) -> (Vec<u64>, u32) {
    let mut simulation = Simulation::new(settings).unwrap();
    other(&mut simulation);
    let body = Square::new([12, 10], 60.0).spawn_into(&mut simulation);
    let mut retried = 0;
    for _ in 0..steps {
        let report = simulation.step(2.0 * DT).unwrap();
        let own = report.bodies.iter().find(|report| report.body == body).unwrap();
        assert!(own.fault.is_none() && !own.is_step_limited);
        retried += report.rolled_back;
    }
    assert_eq!(simulation.time(), 2.0 * DT * steps as f64);
    (state_bits(&simulation, body), retried)
}

#[test]
fn a_body_that_is_retried_leaves_the_bits_of_another_alone() {
    let newton = Settings { advanced: Advanced { newton_iterations: 2, ..Advanced::default() }, ..Settings::default() };
    for settings in [Settings::default(), Settings { threads: 1, ..newton }] {
        let (alone, none) = torn(settings, 25, |_| None);
        let (beside, retried) = torn(settings, 25, |simulation| Some(spiked(simulation)));
        assert!(alone == beside, "{settings:?}");
        assert_eq!(none, 0);
        // Newton's iterations are not judged by energy.
        assert!(retried > 0 || settings.advanced.newton_iterations > 1);
    }
}

#[test]
fn a_body_that_cannot_go_on_stays_and_the_others_do() {
    for integrator in [Integrator::BackwardEuler, Integrator::TrBdf2] {
        let settings = Settings { advanced: Advanced { integrator, ..Advanced::default() }, ..Settings::default() };
        let (alone, _) = torn(settings, 25, |_| None);
        let mut bad = None;
        let mut absurd = |simulation: &mut Simulation| {
            let body = crumpled(simulation);
            simulation.world().get::<&mut Vertices>(body.entity()).unwrap().velocity[7] = DVec3::X * 1e300;
            bad = Some(body);
            bad
        };
        let (beside, retried) = torn(settings, 25, &mut absurd);
        assert!(alone == beside, "{integrator:?}");
        // The whole step and four halvings of its first part, every time.
        assert_eq!(retried, 25 * 5);
    }
}

#[test]
fn the_report_and_an_event_say_which_body_has_failed_and_why() {
    let mut simulation = Simulation::new(Settings::default()).unwrap();
    let bad = crumpled(&mut simulation);
    let good = Square::new([12, 10], 60.0).spawn_into(&mut simulation);
    simulation.world().get::<&mut Vertices>(bad.entity()).unwrap().velocity[7] = DVec3::X * 1e300;
    let before = state_bits(&simulation, bad);
    let report = simulation.step(DT).unwrap();
    assert!(report.has_failed && report.time == DT);
    let fault = |body| report.bodies.iter().find(|report| report.body == body).unwrap().fault;
    assert!(matches!(fault(bad), Some(Fault::Unsolvable | Fault::NotFinite)) && fault(good).is_none(), "{report:?}");
    assert!(state_bits(&simulation, bad) == before);
    let failed: Vec<_> = simulation
        .drain_events()
        .filter_map(|event| match event.kind {
            EventKind::StepFailed { reason } => Some((event.body, reason)),
            _ => None,
        })
        .collect();
    assert_eq!(failed.len(), 1);
    assert!(failed[0].0 == bad && (failed[0].1.contains("finite") || failed[0].1.contains("large")), "{failed:?}");
    // The fault gone, it goes on.
    simulation.world().get::<&mut Vertices>(bad.entity()).unwrap().velocity[7] = DVec3::ZERO;
    assert!(!simulation.step(DT).unwrap().has_failed);
}

//! What the guard against created energy does is counted by body, with cause and place.

use glam::DVec3;
use rhexis::components::{Fibres, Material};
use rhexis::event::EventKind;
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::report::{GuardCause, GuardFigures, Report};
use rhexis::settings::Settings;
use rhexis::simulation::Simulation;
use rhexis::storage::Vertices;

/// A sheet at rest and one that is crumpled by as much as its own size, if it is.
fn two_sheets(threads: usize, is_crumpled: bool) -> Simulation {
    let mut simulation = Simulation::new(Settings { threads, ..Settings::default() }).unwrap();
    for name in ["at rest", "crumpled"] {
        let mesh = generate::grid(10.0, 10.0, 8, 8).unwrap();
        let sheet = Membrane::new(name, mesh, Material { thickness: 0.015, ..Material::allard_2009() });
        let body = simulation.spawn(sheet.fibres(Fibres::at_degrees(30.0))).unwrap();
        if name == "crumpled" && is_crumpled {
            let mut vertices = simulation.world().get::<&mut Vertices>(body.entity()).unwrap();
            for (v, x) in vertices.position.iter_mut().enumerate() {
                let phase = v as f64;
                *x += DVec3::new((7.1 * phase).sin(), (3.3 * phase).sin(), (5.7 * phase).sin()) * 5.0;
            }
        }
    }
    simulation
}

fn steps(simulation: &mut Simulation, count: usize) -> Vec<Report> {
    (0..count).map(|_| simulation.step(20.0).unwrap().clone()).collect()
}

#[test]
fn refusals_have_a_body_a_cause_and_a_place() {
    let mut simulation = two_sheets(1, false);
    let spiked = simulation.bodies()[1];
    simulation.world().get::<&mut Vertices>(spiked.entity()).unwrap().position[0] += DVec3::new(0.9, 0.7, 4.0);
    let (mut refused, mut changed, mut begun, mut was_acting) = (0, 0, 0, false);
    for report in steps(&mut simulation, 25) {
        let [rest, crumpled] = [0, 1].map(|body| report.bodies[body].guard);
        assert_eq!(rest, GuardFigures::default());
        // Every attempt that is undone is tried again, but for the last one of a step that fails.
        assert_eq!(crumpled.refusals(), report.rolled_back);
        assert_eq!(crumpled.limitations() > 0, report.bodies[1].any_substep_limited);
        assert_eq!(crumpled.relaxations() > 0, report.bodies[1].relaxed_vertices > 0);
        let changes = crumpled.limitations() + crumpled.relaxations();
        assert_eq!(crumpled.has_acted(), crumpled.refusals() + changes > 0);
        refused += crumpled.refusals();
        changed += changes;
        begun += usize::from(crumpled.has_acted() && !was_acting);
        was_acting = crumpled.has_acted();
        let Some(place) = crumpled.first else { continue };
        // Nothing holds the sheet, and a default step is solved well.
        assert_eq!(place.cause, GuardCause::Membrane, "{place:?}");
        assert!(place.triangle.is_some_and(|t| t < 128) && place.energy > 0.0, "{place:?}");
        // The centre of a triangle of the sheet at rest.
        assert!(place.at.cmpge(DVec3::ZERO).all() && place.at.cmple(DVec3::new(10.0, 10.0, 0.0)).all(), "{place:?}");
    }
    assert!(refused > 0 && changed > 0, "{refused} refused, {changed} limited or relaxed");
    let told: Vec<_> =
        simulation.drain_events().filter(|event| matches!(event.kind, EventKind::StepGuarded { .. })).collect();
    assert!(told.len() == begun && told.iter().all(|event| event.body == simulation.bodies()[1]), "{begun}: {told:?}");
}

#[test]
fn counts_and_places_are_the_same_for_any_thread_count() {
    let guards = [1, 2, 4].map(|threads| {
        let reports = steps(&mut two_sheets(threads, true), 10);
        reports.iter().map(|report| report.bodies[1].guard).collect::<Vec<_>>()
    });
    assert!(guards.windows(2).all(|pair| pair[0] == pair[1]), "{guards:#?}");
}

#[test]
fn what_is_not_finite_names_its_vertex() {
    let mut simulation = two_sheets(1, false);
    let body = simulation.bodies()[1];
    simulation.world().get::<&mut Vertices>(body.entity()).unwrap().velocity[17] = DVec3::X * 1e200;
    let report = simulation.step(20.0).unwrap();
    let guard = report.bodies[1].guard;
    // A system of equations with such a velocity has no finite answer, and the state it leaves is not finite.
    let counted = [GuardCause::NotFinite, GuardCause::Unsolvable].map(|cause| guard.refused[cause as usize]);
    assert!(report.has_failed && counted.iter().sum::<u32>() > 0, "{guard:?}");
    assert_eq!(guard.first.and_then(|place| place.vertex), Some(17), "{guard:?}");
}

/// Where one or two triangles create the energy, their vertices are relaxed locally in the whole step.
#[test]
fn a_spike_is_relaxed_without_a_retry() {
    let mut simulation = two_sheets(1, true);
    let reports = steps(&mut simulation, 10);
    let guards: Vec<GuardFigures> = reports.iter().map(|report| report.bodies[1].guard).collect();
    assert!(guards.iter().any(|guard| guard.relaxations() > 0), "{guards:#?}");
    assert!(guards.iter().all(|guard| guard.refusals() + guard.limitations() == 0), "{guards:#?}");
}

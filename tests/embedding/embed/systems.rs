//! Systems of the caller's own within the step.

use crate::common::{DT, Square, state_bits};
use glam::DVec3;
use rhexis::components::{ExternalStiffness, Forces, Gravity, Increment, SolveResult};
use rhexis::event::EventKind;
use rhexis::schedule::Place;
use rhexis::settings::Settings;
use rhexis::simulation::Simulation;
use rhexis::storage::Vertices;
use rhexis::systems::StepContext;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A component of the caller's.
#[derive(Clone)]
struct Wind(DVec3);

fn wind(world: &mut hecs::World, _: &StepContext) -> usize {
    let mut count = 0;
    for (vertices, wind, result, forces) in world.query_mut::<(&Vertices, &Wind, &SolveResult, &mut Forces)>() {
        if result.is_active() {
            count += 1;
            forces.nodal.iter_mut().zip(&vertices.mass).for_each(|(force, mass)| *force += wind.0 * *mass);
        }
    }
    count
}

#[test]
fn a_force_of_ones_own_is_as_good_as_the_engines() {
    let acceleration = DVec3::new(1e-3, 2e-3, 0.0);
    let square = Square::new([20, 16], 60.0);
    let mut simulation = Simulation::new(Settings::default()).unwrap();
    let mine = simulation.spawn(square.elastic().with(Wind(acceleration))).unwrap();
    let theirs = simulation.spawn(square.elastic().with(Gravity { acceleration })).unwrap();
    simulation.insert_system(Place::Before("gravity"), "wind", wind).unwrap();
    for _ in 0..10 {
        simulation.step(DT).unwrap();
    }
    assert_eq!(state_bits(&simulation, mine), state_bits(&simulation, theirs));
    simulation.settle(DT, 1e-9).unwrap();
    assert_eq!(state_bits(&simulation, mine), state_bits(&simulation, theirs), "in equilibrium too");
    let systems = &simulation.report().systems;
    let at = systems.iter().position(|system| system.name == "wind").unwrap();
    assert!(systems[at].bodies > 0 && !systems[at].time.is_zero() && systems[at + 1].name == "gravity");
    simulation.remove_system("wind").unwrap();
    simulation.step(DT).unwrap();
    assert!(simulation.report().systems.iter().all(|system| system.name != "wind"));
    assert_ne!(state_bits(&simulation, mine), state_bits(&simulation, theirs));
}

type Harm = (Place<'static>, fn(&mut hecs::World));

/// Where it can do harm, what it spoils there.
const HARM: [Harm; 4] = [
    (Place::After("contact"), |world| {
        world.query_mut::<&mut Forces>().into_iter().for_each(|forces| forces.nodal[40] = DVec3::NAN);
    }),
    (Place::Before("solve"), |world| {
        let all = world.query_mut::<&mut ExternalStiffness>().into_iter();
        all.for_each(|external| external.block[40].diagonal.x = f64::NAN);
    }),
    (Place::Before("integrate"), |world| {
        world.query_mut::<&mut Increment>().into_iter().for_each(|increment| increment.delta[40] = DVec3::INFINITY);
    }),
    (Place::After("split"), |world| {
        world.query_mut::<&mut Vertices>().into_iter().for_each(|vertices| vertices.position[40].y = f64::NAN);
    }),
];

#[test]
fn a_number_that_is_not_finite_is_undone() {
    for (place, harm) in HARM {
        let square = Square::new([20, 16], 60.0);
        let mut simulation = Simulation::new(Settings::default()).unwrap();
        let body = simulation.spawn(square.membrane().with(ExternalStiffness::default())).unwrap();
        let is_harmful = Arc::new(AtomicBool::new(false));
        let switch = Arc::clone(&is_harmful);
        let system = move |world: &mut hecs::World, _: &StepContext| {
            if switch.load(Ordering::Relaxed) {
                harm(world);
            }
            1
        };
        simulation.insert_system(place, "harm", system).unwrap();
        simulation.step(DT).unwrap();
        let (before, time) = (state_bits(&simulation, body), simulation.time());
        is_harmful.store(true, Ordering::Relaxed);
        let report = simulation.step(DT).unwrap();
        assert!(report.has_failed && report.rolled_back == 5, "{place:?}: {report:?}");
        assert!(state_bits(&simulation, body) == before && simulation.time() == time, "{place:?}");
        assert!(simulation.drain_events().any(|event| matches!(event.kind, EventKind::StepFailed { .. })));
        is_harmful.store(false, Ordering::Relaxed);
        let report = simulation.step(DT).unwrap();
        assert!(!report.has_failed && report.rolled_back == 0, "{place:?}: {report:?}");
    }
}

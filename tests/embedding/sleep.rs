//! Bodies that sleep: when they fall asleep, what that changes, and what wakes them.

use crate::common::{self, Square, state_bits};
use glam::{DVec3, dvec3};
use rhexis::components::{
    Contact, Curve, Drag, EnergyAudit, Gravity, Holds, Material, Obstacle, Path, Shape, Sleeping, TearLog, Tearing,
};
use rhexis::event::{EventKind, WokenBy};
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::settings::{Advanced, Integrator, Settings};
use rhexis::simulation::{Simulation, SimulationError, Solid};
use rhexis::storage::{BodyId, Triangles, Vertices};

/// A square that is drawn out by `u` \[mm\] at both ends within 100 ms, and then held.
fn drawn_out(u: f64, tearing: Tearing) -> Membrane {
    let ramp = Curve::ramp(100.0, u).unwrap();
    Square { tearing, ..Square::new([20, 16], 60.0) }.membrane_along(ramp)
}

fn strong() -> Tearing {
    Tearing { strength_across_fibres: 1e6, strength_along_fibres: 1e6, ..Tearing::default() }
}

fn simulation() -> Simulation {
    Simulation::new(Settings { threads: 1, ..Settings::default() }).unwrap()
}

fn is_asleep(simulation: &Simulation, body: BodyId) -> bool {
    simulation.report().bodies.iter().any(|report| report.body == body && report.is_asleep)
}

/// Steps of 10 ms until the body sleeps.
fn until_asleep(simulation: &mut Simulation, body: BodyId) -> usize {
    for step in 0..2000 {
        if is_asleep(simulation, body) {
            return step;
        }
        assert!(!simulation.step(10.0).unwrap().has_failed);
    }
    panic!("still awake: {:?}", simulation.report().bodies);
}

fn woken_by(simulation: &mut Simulation, body: BodyId) -> Option<WokenBy> {
    simulation.step(10.0).unwrap();
    simulation.drain_events().filter(|event| event.body == body).find_map(|event| match event.kind {
        EventKind::Woke { by } => Some(by),
        _ => None,
    })
}

/// Largest Σᵢ |uᵢ|·|∇Nᵢ| over the triangles, for the way u from `before` to where the vertices are now.
fn strain_since(simulation: &Simulation, body: BodyId, before: &[DVec3]) -> f64 {
    let vertices = simulation.world().get::<&Vertices>(body.entity()).unwrap();
    let triangles = simulation.world().get::<&Triangles>(body.entity()).unwrap();
    let way = |v: u32| vertices.position[v as usize].distance(before[v as usize]);
    let of_triangle = |t: usize| -> f64 {
        let gradients = triangles.rest[t].all_gradients();
        (0..3).map(|i| way(triangles.corners[t][i]) * gradients[i].length()).sum()
    };
    (0..triangles.len()).map(of_triangle).fold(0.0, f64::max)
}

#[test]
fn what_sleep_gives_up_is_within_its_bound() {
    // In thick fluid the sheet creeps to its equilibrium for seconds, each step by a hundredth of what is left.
    for strain in [1e-3, 1e-4, 1e-5] {
        let mut simulation = simulation();
        let sheet = drawn_out(0.3, strong()).with(Drag { coefficient: 0.2 });
        let body = simulation.spawn(sheet.with(Sleeping { strain, ..Sleeping::default() })).unwrap();
        let steps = until_asleep(&mut simulation, body);
        let asleep = simulation.world().get::<&Vertices>(body.entity()).unwrap().position.clone();
        simulation.settle(0.0, 1e-9).unwrap();
        let given_up = strain_since(&simulation, body, &asleep);
        println!("strain {strain:e}: asleep after {steps} steps, {given_up:e} short of equilibrium");
        // The solves before sleep are linear and good to a thousandth of their residual.
        assert!(given_up <= 1.1 * strain, "{given_up:e} of {strain:e}");
        // Nor is it kept awake for longer than the wait between two of them.
        assert!(given_up > 0.01 * strain, "{given_up:e} of {strain:e}");
    }
}

#[test]
fn a_body_that_sleeps_costs_nothing_and_stays_as_it_is() {
    let mut simulation = simulation();
    let body = simulation.spawn(drawn_out(0.3, strong()).with(Sleeping::default())).unwrap();
    until_asleep(&mut simulation, body);
    let before = state_bits(&simulation, body);
    let reactions = simulation.reactions(body).unwrap();
    for _ in 0..50 {
        simulation.step(10.0).unwrap();
        let report = simulation.report();
        let ran: Vec<_> = report.systems.iter().filter(|system| system.bodies > 0).map(|s| s.name).collect();
        assert_eq!(ran, ["sleep: wake"], "and no other system");
        assert!(report.systems.iter().all(|system| system.bodies > 0 || system.time.is_zero()));
        assert_eq!(report.bodies[0].iterations, 0);
    }
    assert!(state_bits(&simulation, body) == before);
    assert_eq!(simulation.reactions(body).unwrap(), reactions);
}

#[test]
fn whatever_acts_on_a_body_wakes_it() {
    let mut simulation = simulation();
    let curve = Curve::new(vec![(0.0, 0.0), (100.0, 0.3), (5000.0, 0.3), (5100.0, 0.4)]).unwrap();
    let sheet = Square { tearing: strong(), ..Square::new([20, 16], 60.0) }.out_of_plane(curve);
    let body = simulation
        .spawn(
            sheet
                .with(Contact { stiffness: Some(0.01), friction: 0.0, ..Contact::default() })
                .with(Sleeping::default()),
        )
        .unwrap();
    let far = DVec3::new(15.0, 15.0, 100.0);
    let ball = simulation.spawn_obstacle(Obstacle { shape: Shape::Sphere { centre: far, radius: 2.0 } }).unwrap();

    until_asleep(&mut simulation, body);
    simulation.wake(body).unwrap();
    assert_eq!(woken_by(&mut simulation, body), Some(WokenBy::Caller));
    until_asleep(&mut simulation, body);
    simulation.world_mut();
    assert_eq!(woken_by(&mut simulation, body), Some(WokenBy::Caller));
    until_asleep(&mut simulation, body);
    simulation.entity_mut::<&mut Holds>(body).unwrap();
    assert_eq!(woken_by(&mut simulation, body), Some(WokenBy::Caller));

    until_asleep(&mut simulation, body);
    let place = |simulation: &mut Simulation, centre: DVec3| {
        simulation.entity_mut::<&mut Obstacle>(ball).unwrap().shape = Shape::Sphere { centre, radius: 2.0 };
    };
    place(&mut simulation, far + DVec3::Z);
    assert_eq!(woken_by(&mut simulation, body), None, "it is out of reach before and after");
    place(&mut simulation, DVec3::new(15.0, 15.0, 1.9));
    assert_eq!(woken_by(&mut simulation, body), Some(WokenBy::Obstacle));
    until_asleep(&mut simulation, body);
    simulation.despawn(ball).unwrap();
    assert_eq!(woken_by(&mut simulation, body), Some(WokenBy::Obstacle));

    let flat = simulation.spawn(drawn_out(0.3, strong()).with(Sleeping::default())).unwrap();
    until_asleep(&mut simulation, flat);
    simulation.cut(flat, &common::NOTCH).unwrap();
    assert_eq!(woken_by(&mut simulation, flat), Some(WokenBy::Cut));
    until_asleep(&mut simulation, flat);
    simulation.settle(0.0, 1e-6).unwrap();
    assert_eq!(woken_by(&mut simulation, flat), Some(WokenBy::StaticSolve));

    until_asleep(&mut simulation, body);
    assert!(simulation.time() < 4900.0, "before the hold moves on");
    while is_asleep(&simulation, body) {
        simulation.step(10.0).unwrap();
    }
    assert_eq!(simulation.time(), 5010.0, "in the first step in which its hold moves");
    assert!(simulation.drain_events().any(|event| event.kind == EventKind::Woke { by: WokenBy::Drive }));

    assert_eq!(simulation.wake(ball.entity().into()), Err(SimulationError::NoSuchBody));
    assert_eq!(simulation.entity_mut::<&mut EnergyAudit>(body).err(), Some(SimulationError::NoSuchComponents));
}

#[test]
fn a_body_that_may_tear_or_is_audited_stays_awake() {
    // The tip of this square rests at 0.3 mm at some criterion; a strength just above it leaves a margin that is tried.
    let criterion = {
        let mut simulation = simulation();
        let body = simulation.spawn(drawn_out(0.3, strong()).with(Sleeping::default())).unwrap();
        simulation.cut(body, &common::NOTCH).unwrap();
        until_asleep(&mut simulation, body);
        simulation.world().get::<&rhexis::storage::Tips>(body.entity()).unwrap().criterion[0]
    };
    for (below, sleeps) in [(1e-2, true), (1e-7, false)] {
        let strength = 1e6 * criterion * (1.0 + below);
        let tearing =
            Tearing { strength_across_fibres: strength, strength_along_fibres: strength, ..Tearing::default() };
        let mut simulation = simulation();
        let body = simulation.spawn(drawn_out(0.3, tearing).with(Sleeping::default())).unwrap();
        simulation.cut(body, &common::NOTCH).unwrap();
        for _ in 0..100 {
            simulation.step(10.0).unwrap();
        }
        assert_eq!(simulation.world().get::<&TearLog>(body.entity()).unwrap().advance_count, 0);
        assert_eq!(is_asleep(&simulation, body), sleeps, "{below:e} below its strength");
    }
    let mut simulation = simulation();
    let audited = drawn_out(0.3, strong()).with(Sleeping::default()).with(EnergyAudit::default());
    let body = simulation.spawn(audited).unwrap();
    for _ in 0..100 {
        simulation.step(10.0).unwrap();
    }
    assert!(!is_asleep(&simulation, body));
}

#[test]
fn a_pendulum_does_not_sleep_where_it_turns() {
    // A sheet that hangs from one edge, drawn aside: it swings with a period of some 300 ms, 300 steps, and stands still for
    // many steps at every turning point, by far more quiet than the bound of its velocity.
    let mut simulation = simulation();
    let square = Square { tearing: strong(), ..Square::new([6, 5], 60.0) };
    let sheet = square.hanging().with(Gravity { acceleration: DVec3::new(0.0, -9.81e-3, 2e-4) });
    let body = simulation.spawn(sheet.with(Sleeping { strain: 1e-3, steps: 2, ..Sleeping::default() })).unwrap();
    let mut turns = 0;
    let mut last = 0.0;
    for _ in 0..900 {
        simulation.step(1.0).unwrap();
        assert!(!is_asleep(&simulation, body), "at {} ms", simulation.time());
        let vertices = simulation.world().get::<&Vertices>(body.entity()).unwrap();
        let lowest =
            (0..vertices.len()).min_by(|&a, &b| vertices.rest_position[a].y.total_cmp(&vertices.rest_position[b].y));
        let speed = vertices.velocity[lowest.unwrap()].z;
        turns += usize::from(speed * last < 0.0);
        last = speed;
    }
    assert!(turns >= 2, "{turns} turns");
}

#[test]
fn bodies_that_sleep_and_wake_have_the_same_bits_on_any_number_of_threads() {
    let run = |threads: usize| {
        let mut simulation = Simulation::new(Settings { threads, ..Settings::default() }).unwrap();
        let weak = Tearing::default();
        let bodies: Vec<BodyId> = (0..8)
            .map(|i| {
                let membrane = match i % 4 {
                    0 => Square { tearing: weak, ..Square::new([20, 16], 60.0) }.membrane(),
                    _ => drawn_out(0.1 * f64::from(i % 4), weak),
                };
                let body = simulation.spawn(membrane.with(Sleeping::default())).unwrap();
                simulation.cut(body, &common::NOTCH).unwrap();
                body
            })
            .collect();
        let mut most_asleep = 0;
        for _ in 0..60 {
            let report = simulation.step(10.0).unwrap();
            most_asleep = most_asleep.max(report.bodies.iter().filter(|body| body.is_asleep).count());
        }
        assert!(most_asleep >= 4, "{most_asleep} of 8 slept");
        bodies.into_iter().map(|body| state_bits(&simulation, body)).collect::<Vec<_>>()
    };
    let once = run(1);
    assert!(run(2) == once && run(3) == once);
}

/// A body that falls asleep in the first stage of TR-BDF2 has no second one: contact leaves it alone at the end of the step, where a ball
/// that rises by half a radius or two radii has come through it.
#[test]
fn contact_leaves_a_body_alone_that_falls_asleep_in_the_first_stage() {
    for (strain, from, rise) in [(1.0, -1.5, 2.0), (1e3, -1.1, 0.5)] {
        let settings = Settings {
            threads: 1,
            advanced: Advanced { integrator: Integrator::TrBdf2, ..Advanced::default() },
            ..Settings::default()
        };
        let mut simulation = Simulation::new(settings).unwrap();
        // So large a strain that the push of the ball does not keep the sheet awake.
        let sleeping = Sleeping { strain, steps: 1, ..Sleeping::default() };
        let sheet = Membrane::new("sheet", generate::grid(4.0, 4.0, 4, 4).unwrap(), Material::allard_2009());
        let contact = Contact { stiffness: None, friction: 0.2, ..Contact::default() };
        let body = simulation.spawn(sheet.with(contact).with(sleeping)).unwrap();
        let ball = Shape::Sphere { centre: dvec3(2.0, 2.0, from), radius: 1.0 };
        let up = Path { points: vec![(0.0, DVec3::ZERO), (4.0, DVec3::Z * rise)] };
        simulation.spawn_obstacle(Solid::new(ball).path(up)).unwrap();

        let positions =
            |simulation: &Simulation| simulation.world().get::<&Vertices>(body.entity()).unwrap().position.clone();
        let before = positions(&simulation);
        assert!(!simulation.step(4.0).unwrap().has_failed);
        assert!(is_asleep(&simulation, body), "the scene shows nothing: the body is awake");
        assert_eq!(positions(&simulation), before, "contact moved a body that slept");
    }
}

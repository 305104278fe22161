//! Solves that stop for the error of positions or because a budget is used up.

use glam::DVec3;
use rhexis::components::{Damping, Drag, Fibres, Gravity, Material};
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::report::Report;
use rhexis::settings::{LinearParams, Settings};
use rhexis::simulation::Simulation;

const DT: f64 = 1000.0 / 60.0;
const EDGE: f64 = 1.25;
const FALL: f64 = 9.81e-3;

/// A slack sheet of 20 mm that hangs by two of its corners, or falls.
fn sheet(settings: Settings, hangs: bool) -> (Simulation, hecs::Entity) {
    let mut simulation = Simulation::new(settings).unwrap();
    let mesh = generate::grid(20.0, 20.0, 16, 16).unwrap();
    let sheet = Membrane::new("cloth", mesh, Material { density: 1e-3, ..Material::figure_2() })
        .fibres(Fibres::at_degrees(20.0))
        .with(Gravity { acceleration: DVec3::new(0.0, 0.0, -FALL) })
        .with(Damping { time: 1.0 })
        .with(Drag { coefficient: 1e-6 });
    let body = simulation.spawn(sheet).unwrap();
    if hangs {
        let corners = [0, 16].map(|v| simulation.view(body).unwrap().vertex_keys[v]);
        simulation.pin(body, "corners", &corners).unwrap();
    }
    (simulation, body)
}

fn steps(simulation: &mut Simulation, count: usize) -> Vec<Report> {
    (0..count).map(|_| simulation.step(DT).unwrap().clone()).collect()
}

fn work(reports: &[Report]) -> u32 {
    reports.iter().map(|report| report.bodies[0].work).sum()
}

#[test]
fn positions_decide_when_a_solve_is_near_enough() {
    let near = Settings { budget: None, ..Settings::game() };
    let tolerance = near.linear.position_tolerance;
    let alone = |linear: LinearParams| Settings { linear, ..near };
    let (mut early, body) = sheet(near, true);
    let (mut late, other) = sheet(alone(LinearParams { position_tolerance: f64::INFINITY, ..near.linear }), true);
    let [reports, exact] = [&mut early, &mut late].map(|simulation| steps(simulation, 60));
    for report in &reports {
        let [of_body] = &report.bodies[..] else { panic!("one body") };
        // What is retried is solved in full.
        assert!(of_body.position_error <= tolerance || of_body.guard.has_acted(), "{of_body:?}");
    }
    assert!(exact.iter().all(|report| report.bodies[0].position_error == 0.0));
    assert!(reports.iter().any(|report| report.bodies[0].position_error > 0.1 * tolerance));
    assert!(work(&reports) < work(&exact), "{} iterations against {}", work(&reports), work(&exact));
    let means = [(&mut early, body), (&mut late, other)].map(|(simulation, body)| {
        let positions = simulation.view(body).unwrap().positions.to_vec();
        positions.iter().sum::<DVec3>() / positions.len() as f64
    });
    // A second of steps, each off by a fiftieth of an edge in the mean at most, that hang: errors do not add up.
    assert!(means[0].distance(means[1]) < 0.5 * EDGE, "{means:?}");
}

#[test]
fn what_moves_by_less_than_the_tolerance_moves_all_the_same() {
    let (mut simulation, body) = sheet(Settings::game(), false);
    let height = |simulation: &mut Simulation| {
        let positions = simulation.view(body).unwrap().positions.to_vec();
        positions.iter().map(|x| x.z).sum::<f64>() / positions.len() as f64
    };
    // The first steps move it by 1e-8 of an edge.
    let (dt, count) = (1e-3, 200);
    for _ in 0..count {
        simulation.step(dt).unwrap();
    }
    let fallen = 0.5 * FALL * dt * dt * f64::from(count * (count + 1));
    // Drag takes a part in a thousand.
    let height = height(&mut simulation);
    assert!((height / -fallen - 1.0).abs() < 1e-2, "{height} of {fallen}");
}

#[test]
fn a_budget_bounds_the_work_and_keeps_the_bits() {
    const BUDGET: u32 = 12;
    let bounded = |threads| Settings { budget: Some(BUDGET), threads, ..Settings::game() };
    let runs = [1, 2, 4].map(|threads| {
        let (mut simulation, _) = sheet(bounded(threads), true);
        let reports = steps(&mut simulation, 60);
        (reports.iter().map(|report| report.bodies[0].work).collect::<Vec<_>>(), simulation.hash())
    });
    assert!(runs.windows(2).all(|pair| pair[0] == pair[1]));
    // Each solve after the last iteration of the budget takes 4 more: of two halves and their last resort at the most.
    let most = runs[0].0.iter().max().unwrap();
    assert!(*most <= BUDGET + 4 * 4, "{most} iterations");
    let (mut free, _) = sheet(Settings { budget: None, ..bounded(1) }, true);
    assert!(work(&steps(&mut free, 60)) > 60 * BUDGET / 2, "nothing to bound");
}

#[test]
fn presets_have_names_and_are_valid() {
    for (name, preset) in Settings::presets() {
        assert!(Simulation::new(preset).is_ok(), "{name}");
    }
    assert_eq!(Settings::presets().map(|(name, _)| name), ["haptic", "game", "accurate", "static"]);
    let wrong = LinearParams { position_tolerance: f64::NAN, ..LinearParams::default() };
    assert!(Simulation::new(Settings { linear: wrong, ..Settings::default() }).is_err());
}

//! Solves that stop for the error of positions or because a budget is used up.

use glam::DVec3;
use rhexis::components::{
    Contact, Curve, Damping, Drag, Fibres, Gravity, Hold, Jaws, Material, Obstacle, Pose, Refined, Refinement, Shape,
    TearMode, Tearing,
};
use rhexis::event::EventKind;
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::report::Report;
use rhexis::settings::{Accuracy, Advanced, Integrator, Settings, Tangent};
use rhexis::simulation::{Grasp, Simulation};
use rhexis::storage::{Attached, BodyId};

const DT: f64 = 1000.0 / 60.0;
const EDGE: f64 = 1.25;
const FALL: f64 = 9.81e-3;

/// A slack sheet of 20 mm that hangs by two of its corners, or falls.
fn sheet(settings: Settings, hangs: bool) -> (Simulation, BodyId) {
    let mut simulation = Simulation::new(settings).unwrap();
    let mesh = generate::grid(20.0, 20.0, 16, 16).unwrap();
    let sheet = Membrane::new("cloth", mesh, Material { density: 1e-3, ..Material::allard_2009() })
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
    let near = Settings { budget: None, ..Settings::new(Accuracy::Game) };
    let tolerance = near.position_tolerance;
    let (mut early, body) = sheet(near, true);
    let (mut late, other) = sheet(Settings { position_tolerance: f64::INFINITY, ..near }, true);
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
    let (mut simulation, body) = sheet(Settings::new(Accuracy::Game), false);
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
    const BUDGET: u32 = 30;
    let bounded = |threads| Settings { budget: Some(BUDGET), threads, ..Settings::new(Accuracy::Game) };
    let runs = [1, 2, 4].map(|threads| {
        let (mut simulation, _) = sheet(bounded(threads), true);
        let reports = steps(&mut simulation, 60);
        (reports.iter().map(|report| report.bodies[0].work).collect::<Vec<_>>(), simulation.hash())
    });
    assert!(runs.windows(2).all(|pair| pair[0] == pair[1]));
    let most = runs[0].0.iter().max().unwrap();
    assert!(*most <= BUDGET, "{most} iterations");
    let (mut free, _) = sheet(Settings { budget: None, ..bounded(1) }, true);
    assert!(work(&steps(&mut free, 60)) > 60 * BUDGET / 2, "nothing to bound");
}

/// The most work of a step while a hand jerks a sheet that may tear to and fro over a ball, 120 steps; with the attempts undone, the
/// advances, the steps that went only a part of their way, those whose tear had one solve only and those whose release was not at rest.
fn most_work(settings: Settings) -> (u32, [u32; 5]) {
    let (mut simulation, body) = sheet(settings, true);
    simulation.world_mut().insert(body.entity(), (Tearing::default(), Contact::default())).unwrap();
    simulation.cut(body, &[DVec3::new(20.0, 8.0, 0.0), DVec3::new(14.0, 9.0, 0.0)]).unwrap();
    let ball = Shape::Sphere { centre: DVec3::new(10.0, 4.0, -6.0), radius: 5.0 };
    simulation.spawn_obstacle(Obstacle { shape: ball }).unwrap();
    let start = DVec3::new(10.0, 10.0, 0.0);
    let jaws = Jaws { radius: 1.5, ..Jaws::default() };
    let forceps = simulation.spawn_forceps("forceps", jaws, Pose::at(start)).unwrap();
    simulation.close_forceps(forceps, body, &Grasp::Point(start)).unwrap();
    let (mut most, mut counts) = (0, [0; 5]);
    for step in 0..120 {
        let phase = f64::from(step / 6);
        let way = DVec3::new((2.4 * phase).sin(), (3.1 * phase).sin(), (1.7 * phase).sin());
        simulation.move_forceps(forceps, Pose::at(start + way * 12.0), DT).unwrap();
        let report = &simulation.step(DT).unwrap().bodies[0];
        most = most.max(report.work);
        let (undone, in_part) = (report.guard.refusals(), u32::from(report.any_substep_limited));
        let (undecided, unsettled) = (u32::from(report.is_tear_undecided), u32::from(report.is_release_unsettled));
        let advances =
            simulation.drain_events().filter(|e| matches!(e.kind, EventKind::Advanced { .. })).count() as u32;
        counts.iter_mut().zip([undone, advances, in_part, undecided, unsettled]).for_each(|(sum, count)| *sum += count);
    }
    (most, counts)
}

#[test]
fn no_step_under_a_rough_hand_goes_above_its_budget() {
    let mut sums = [0; 5];
    for (corrections, halvings) in [(0, 1), (0, 4), (10, 4)] {
        for budget in [50, 80, 150, 400] {
            let settings = Settings {
                budget: Some(budget),
                advanced: Advanced {
                    newton_corrections: corrections,
                    max_step_halvings: halvings,
                    ..Settings::new(Accuracy::Game).advanced
                },
                ..Settings::new(Accuracy::Game)
            };
            let (most, counts) = most_work(settings);
            println!("{corrections} corrections, {halvings} halvings, a budget of {budget}: {most}, {counts:?}");
            assert!(most <= budget, "{most} of {budget} with {corrections} corrections, {halvings} halvings");
            // Fewer solves than five correctors take: the budget ends them, and that is told.
            assert!(counts[4] > 0 || !(80..=150).contains(&budget), "{counts:?} with a budget of {budget}");
            sums.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
        }
    }
    assert!(sums.iter().all(|count| *count > 0), "nothing to bound: {sums:?}");
}

#[test]
fn newtons_iterations_end_with_the_budget() {
    let game = Settings::new(Accuracy::Game);
    for integrator in [Integrator::BackwardEuler, Integrator::TrBdf2] {
        let advanced = Advanced { newton_iterations: 4, tangent: Tangent::Exact, integrator, ..game.advanced };
        let (free, _) = most_work(Settings { budget: None, advanced, ..game });
        for budget in [150, 400] {
            let (most, counts) = most_work(Settings { budget: Some(budget), advanced, ..game });
            println!("{integrator:?}, a budget of {budget}: {most} of {free}, {counts:?}");
            assert!(most <= budget && free > budget, "{most} of {budget}, {free} without");
            assert!(counts[1] > 0, "nothing torn");
        }
    }
}

/// A sheet of 1,500 triangles with two notches in its upper edge, 40 steps of being pulled apart; returns the points torn to in each step, and
/// the triangles that refinement had halved by then.
fn two_tears(mode: TearMode, budget: Option<u32>, refinement: Option<Refinement>) -> Vec<(Vec<DVec3>, u32)> {
    let mesh = generate::grid(30.0, 30.0, 30, 25).unwrap();
    let mut sheet = Membrane::new("sheet", mesh, Material::allard_2009())
        .fibres(Fibres::at_degrees(90.0))
        .planar()
        .with(Tearing { mode, ..Tearing::default() })
        .with(Damping { time: 0.1 });
    if let Some(refinement) = refinement {
        sheet = sheet.with(refinement);
    }
    for (name, x, way) in [("left", 0.0, DVec3::NEG_X), ("right", 30.0, DVec3::X)] {
        let members = Attached::new(sheet.select(|p| p.x == x).into_iter().map(|vertex| (vertex, way)));
        let curve = Curve::ramp(200.0, 3.0).unwrap();
        sheet = sheet.hold(Hold { name: name.into(), members, axes: [true; 3], curve });
    }
    let mut simulation = Simulation::new(Settings { budget, ..Settings::default() }).unwrap();
    let body = simulation.spawn(sheet).unwrap();
    for x in [10.0, 20.0] {
        simulation.cut(body, &[DVec3::new(x, 30.0, 0.0), DVec3::new(x, 27.0, 0.0)]).unwrap();
    }
    let mut step = || {
        simulation.step(10.0).unwrap();
        let torn = simulation.drain_events().filter_map(|event| match event.kind {
            EventKind::Advanced { to, .. } => Some(to),
            _ => None,
        });
        let torn = torn.collect();
        (torn, simulation.world().get::<&Refined>(body.entity()).map_or(0, |refined| refined.split_count))
    };
    (0..40).map(|_| step()).collect()
}

#[test]
fn tears_that_a_budget_does_not_cover_take_turns() {
    for mode in [TearMode::Free, TearMode::Glide] {
        let unbounded = two_tears(mode, None, None);
        assert!(unbounded.iter().any(|(torn, _)| torn.len() > 1), "nothing to bound");
        let bounded = two_tears(mode, Some(1), None);
        assert!(bounded.iter().all(|(torn, _)| torn.len() <= 1));
        let places = || bounded.iter().flat_map(|(torn, _)| torn);
        let [left, right] =
            [true, false].map(|left| places().filter(|to| (to.x < 15.0) == left).map(|to| to.y).fold(30.0, f64::min));
        // Each goes through a triangle of 1.2 mm in turn, one in a way of 2.4 mm at the most.
        assert!((left - right).abs() < 2.4, "{mode:?}: {left} and {right}");
        assert!(left < 24.0, "{mode:?}: {left}");
    }
}

#[test]
fn refinement_that_a_budget_does_not_cover_goes_on_in_the_next_steps() {
    const BUDGET: u32 = 4;
    let halved = |budget| -> Vec<u32> {
        two_tears(TearMode::Free, budget, Some(Refinement::default())).iter().map(|(_, halved)| *halved).collect()
    };
    let (free, bounded) = (halved(None), halved(Some(BUDGET)));
    assert!(free[0] > 300, "nothing to bound");
    // Half of the budget is six halvings of 500 triangles' share of an iteration, and each may ask for another one before it.
    let in_steps = bounded.windows(2).map(|pair| pair[1] - pair[0]);
    assert!(in_steps.clone().all(|halved| (6..=12).contains(&halved)), "{bounded:?}");
}

#[test]
fn presets_have_names_and_are_valid() {
    for accuracy in Accuracy::ALL {
        assert!(Simulation::new(Settings::new(accuracy)).is_ok(), "{accuracy:?}");
        assert_eq!(Accuracy::named(accuracy.name()), Some(accuracy));
    }
    assert_eq!(Accuracy::ALL.map(Accuracy::name), ["fast", "haptic", "game", "accurate", "static"]);
    assert!(Simulation::new(Settings { position_tolerance: f64::NAN, ..Settings::default() }).is_err());
}

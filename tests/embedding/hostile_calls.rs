//! Hostile calls of the library: refused or contained, never a panic, and the state stays finite.

use glam::DVec3;
use rhexis::components::{
    Body, Curve, Forces, Frames, Grips, GuardLedger, Hold, Holds, Increment, Material, Reactions, SolveResult,
    SolverScratch, TearDecisions, TearLog, Tearing,
};
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::settings::{Advanced, LinearParams, OutOfRange, Settings};
use rhexis::simulation::{CutError, MotionError, Simulation, SimulationError};
use rhexis::storage::{Attached, BodyId, Tips, Topology, Triangles, Vertices};

/// Numbers that break arithmetic which does not look.
const HOSTILE: [f64; 8] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e308, -1e308, 1e-308, -1.0, -0.0];

fn sheet() -> Membrane {
    let mut sheet = Membrane::new("sheet", generate::grid(4.0, 2.0, 8, 4).unwrap(), Material::allard_2009())
        .planar()
        .with(Tearing { radius: 0.5, ..Tearing::default() });
    for (name, x, way) in [("left", 0.0, DVec3::NEG_X), ("right", 4.0, DVec3::X)] {
        let members = Attached::new(sheet.select(|p| p.x == x).into_iter().map(|vertex| (vertex, way)));
        let curve = Curve::ramp(100.0, 0.4).unwrap();
        sheet = sheet.hold(Hold { name: name.into(), members, axes: [true; 3], curve });
    }
    sheet
}

fn spawned() -> (Simulation, BodyId) {
    let mut simulation = Simulation::new(Settings { threads: 1, ..Settings::default() }).unwrap();
    let body = simulation.spawn(sheet()).unwrap();
    (simulation, body)
}

fn positions(simulation: &Simulation, body: BodyId) -> Vec<DVec3> {
    simulation.world().get::<&Vertices>(body.entity()).unwrap().position.clone()
}

fn assert_finite(simulation: &Simulation, body: BodyId) {
    assert!(positions(simulation, body).iter().all(|x| x.is_finite()));
}

#[test]
fn a_time_step_that_is_none_changes_nothing() {
    let (mut simulation, body) = spawned();
    let before = positions(&simulation, body);
    for dt in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0, 0.0, -0.0] {
        assert!(matches!(simulation.step(dt), Err(SimulationError::TimeStep(_))), "{dt}");
    }
    for dt in [f64::NAN, f64::INFINITY, -1.0] {
        assert!(matches!(simulation.settle(dt, 1e-9), Err(SimulationError::TimeStep(_))), "{dt}");
        assert!(matches!(simulation.linear_response(dt), Err(SimulationError::TimeStep(_))), "{dt}");
    }
    assert_eq!(positions(&simulation, body), before);
    assert_eq!(simulation.time(), 0.0);
}

#[test]
fn extreme_time_steps_leave_a_finite_state() {
    for dt in [1e-320, 1e-300, 1e-12, 1e12, 1e300, f64::MAX] {
        let (mut simulation, body) = spawned();
        for _ in 0..3 {
            // Twice the largest number is no time any more.
            assert!(simulation.step(dt).is_ok() || dt == f64::MAX, "{dt}");
            assert_finite(&simulation, body);
            assert!(simulation.time().is_finite(), "{dt}");
        }
    }
}

#[test]
fn a_tolerance_out_of_range_ends_in_an_answer_or_an_error() {
    for tolerance in HOSTILE.into_iter().chain([0.0]) {
        let (mut simulation, body) = spawned();
        let outcome = simulation.settle(10.0, tolerance).map(|_| ());
        assert_finite(&simulation, body);
        if tolerance.is_nan() || tolerance < 0.0 {
            assert!(outcome.is_err(), "{tolerance}: {outcome:?}");
        }
        let _ = simulation.settle_and_tear(10.0, tolerance, 5);
        assert_finite(&simulation, body);
    }
}

#[test]
fn settings_out_of_range_leave_a_finite_state() {
    for value in HOSTILE {
        for iterations in [0, 1, 7] {
            let settings = Settings {
                threads: 1,
                advanced: Advanced {
                    linear: LinearParams::by_residual(value, iterations),
                    newton_iterations: iterations,
                    newton_tolerance: value,
                    static_iterations: iterations,
                    max_step_halvings: 1,
                    ..Advanced::default()
                },
                ..Settings::default()
            };
            let Ok(mut simulation) = Simulation::new(settings) else {
                assert!(!(value >= 0.0 && value.is_finite()), "{value}");
                continue;
            };
            let body = simulation.spawn(sheet()).unwrap();
            simulation.step(10.0).unwrap();
            let _ = simulation.settle(10.0, 1e-9);
            assert_finite(&simulation, body);
        }
    }
}

#[test]
fn a_coarse_linear_solve_goes_with_newton_iterations() {
    let linear = LinearParams::by_residual(1e-2, 2000);
    let settings = Settings {
        threads: 1,
        advanced: Advanced { linear, newton_iterations: 5, ..Advanced::default() },
        ..Settings::default()
    };
    let mut simulation = Simulation::new(settings).unwrap();
    simulation.spawn(sheet()).unwrap();
    assert!(!simulation.step(10.0).unwrap().has_failed);
}

#[test]
fn a_crowd_of_threads_is_refused() {
    let settings = Settings { threads: usize::MAX, ..Settings::default() };
    assert!(matches!(Simulation::new(settings), Err(SimulationError::OutOfRange(OutOfRange { what: "threads", .. }))));
}

#[test]
fn a_sheet_torn_through_comes_to_rest() {
    // Both halves are free of stress then: no fraction of their own forces can be reached, only rounding.
    let (mut simulation, body) = spawned();
    simulation.cut(body, &[DVec3::new(2.0, 2.0, 0.0), DVec3::new(2.0, 0.0, 0.0)]).unwrap();
    for _ in 0..3 {
        simulation.settle(30.0, 1e-9).unwrap();
    }
    let moved = positions(&simulation, body);
    assert!((moved[0].x + 0.36).abs() < 1e-12, "{}", moved[0]);
}

#[test]
fn a_cut_through_nowhere_is_refused_and_changes_nothing() {
    let (mut simulation, body) = spawned();
    let before = positions(&simulation, body);
    let inside = DVec3::new(2.0, 1.0, 0.0);
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for bad in [DVec3::splat(value), DVec3::new(value, 1.0, 0.0), DVec3::new(1.0, 1.0, value)] {
            for polyline in [vec![bad], vec![bad, inside], vec![inside, bad], vec![inside, bad, inside]] {
                assert!(simulation.cut(body, &polyline).is_err(), "{polyline:?}");
            }
        }
    }
    for polyline in [vec![], vec![inside], vec![inside; 3]] {
        assert!(simulation.cut(body, &polyline).is_err(), "{polyline:?}");
    }
    assert_eq!(positions(&simulation, body), before);
    simulation.step(10.0).unwrap();
    assert_finite(&simulation, body);
}

#[test]
fn cuts_of_every_size_keep_the_mesh_whole() {
    // A cut may be made or refused; the topology must hold either way.
    let (mut simulation, body) = spawned();
    for length in [1e308, 1e30, 1e9, 10.0, 1.0, 1e-3, 1e-9, 1e-30, 1e-308] {
        for (x, y) in [(2.0, 1.0), (0.0, 0.0), (4.0, 2.0), (1.3, 2.0), (-length, 1.0)] {
            let from = DVec3::new(x, y, 0.0);
            for way in [DVec3::X, DVec3::NEG_Y, DVec3::new(1.0, 1.0, 1.0)] {
                let _ = simulation.cut(body, &[from, from + way * length]);
            }
        }
    }
    let world = simulation.world();
    let corners = &world.get::<&Triangles>(body.entity()).unwrap().corners;
    let count = world.get::<&Vertices>(body.entity()).unwrap().position.len();
    assert!(corners.iter().flatten().all(|&v| (v as usize) < count));
    assert!(world.get::<&Vertices>(body.entity()).unwrap().rest_position.iter().all(|x| x.is_finite()));
}

#[test]
fn what_is_gone_stays_gone() {
    let (mut simulation, body) = spawned();
    simulation.step(10.0).unwrap();
    simulation.despawn(body).unwrap();
    assert_eq!(simulation.despawn(body), Err(SimulationError::NoSuchBody));
    assert_eq!(simulation.cut(body, &[DVec3::ZERO, DVec3::X]), Err(CutError::NoSuchBody));
    assert_eq!(simulation.energies(body), Err(SimulationError::NoSuchBody));
    assert_eq!(simulation.reactions(body), Err(SimulationError::NoSuchBody));
    assert_eq!(simulation.refresh(body), Err(SimulationError::NoSuchBody));
    simulation.step(10.0).unwrap();
    simulation.settle(10.0, 1e-9).unwrap();
    assert!(simulation.frame().bodies.is_empty() && simulation.bodies().is_empty());
}

/// Takes one component away and calls everything.
fn without<C: hecs::Component>(step_first: bool) {
    let (mut simulation, body) = spawned();
    let notch = [DVec3::new(2.0, 2.0, 0.0), DVec3::new(2.0, 1.4, 0.0)];
    simulation.cut(body, &notch).unwrap();
    if step_first {
        simulation.step(10.0).unwrap();
    }
    drop(simulation.world_mut().remove_one::<C>(body.entity()));
    for _ in 0..3 {
        let _ = simulation.step(10.0);
        let _ = simulation.settle_and_tear(10.0, 1e-9, 3);
        let _ = simulation.linear_response(1.0);
    }
    let _ = simulation.frame();
    let _ = simulation.energies(body);
    let _ = simulation.reactions(body);
    let _ = simulation.cut(body, &[DVec3::new(1.0, 2.0, 0.0), DVec3::new(1.0, 1.0, 0.0)]);
    let _ = simulation.drain_events().count();
    let _ = simulation.despawn(body);
}

#[test]
fn a_body_robbed_of_a_component_is_survived() {
    for step_first in [false, true] {
        without::<Body>(step_first);
        without::<Vertices>(step_first);
        without::<Triangles>(step_first);
        without::<Topology>(step_first);
        without::<Frames>(step_first);
        without::<Forces>(step_first);
        without::<Increment>(step_first);
        without::<SolverScratch>(step_first);
        without::<SolveResult>(step_first);
        without::<GuardLedger>(step_first);
        without::<Holds>(step_first);
        without::<Reactions>(step_first);
        without::<Tearing>(step_first);
        without::<Tips>(step_first);
        without::<TearDecisions>(step_first);
        without::<TearLog>(step_first);
        without::<Grips>(step_first);
    }
}

#[test]
fn derived_state_of_another_length_is_made_anew_or_survived() {
    let (mut simulation, body) = spawned();
    simulation.step(10.0).unwrap();
    for _ in 0..2 {
        let world = simulation.world_mut();
        let _ = world.insert(
            body.entity(),
            (Frames::default(), Forces::default(), Increment::default(), SolverScratch::default()),
        );
        let _ = world.insert(body.entity(), (Reactions::default(), TearDecisions::default()));
        simulation.step(10.0).unwrap();
        let world = simulation.world_mut();
        let _ = world.insert(
            body.entity(),
            (Frames::default(), Forces::default(), Increment::default(), SolverScratch::default()),
        );
        let _ = simulation.cut(body, &[DVec3::new(2.0, 2.0, 0.0), DVec3::new(2.0, 1.4, 0.0)]);
        let _ = simulation.frame();
        simulation.settle(0.0, 1e-6).unwrap();
    }
    assert_finite(&simulation, body);
}

#[test]
fn a_velocity_that_is_none_or_has_no_energy_is_refused() {
    let (mut simulation, body) = spawned();
    simulation.step(10.0).unwrap();
    let velocity = |s: &Simulation| s.world().get::<&Vertices>(body.entity()).unwrap().velocity.clone();
    let before = velocity(&simulation);
    // The square of the last overflows, its own value does not.
    for speed in [f64::NAN, f64::INFINITY, 1e200] {
        assert!(matches!(simulation.set_velocity(body, |_| DVec3::X * speed), Err(MotionError::NotFinite)), "{speed}");
        assert_eq!(velocity(&simulation), before);
    }
    simulation.set_velocity(body, |_| DVec3::X * 1e3).unwrap();
}

#[test]
fn poisoned_state_is_not_carried_on_silently() {
    for poison in [f64::NAN, f64::INFINITY] {
        let (mut simulation, body) = spawned();
        simulation.step(10.0).unwrap();
        simulation.world().get::<&mut Vertices>(body.entity()).unwrap().position[20] = DVec3::splat(poison);
        assert!(simulation.step(10.0).unwrap().has_failed);
        assert!(simulation.settle(0.0, 1e-9).is_err());
        assert!(simulation.linear_response(1.0).is_err());
    }
}

#[test]
fn a_state_whose_energy_overflows_is_not_carried_on_silently() {
    for exponent in 140..=308 {
        let (mut simulation, body) = spawned();
        simulation.step(10.0).unwrap();
        simulation.world().get::<&mut Vertices>(body.entity()).unwrap().position[20].x = 10_f64.powi(exponent);
        let has_failed = simulation.step(10.0).unwrap().has_failed;
        let energies = simulation.energies(body).unwrap();
        assert!(has_failed || (energies.elastic + energies.kinetic).is_finite(), "1e{exponent} mm: {energies:?}");
    }
}

#[test]
fn parameters_poisoned_after_spawning_are_contained() {
    for value in HOSTILE {
        let (mut simulation, body) = spawned();
        simulation.cut(body, &[DVec3::new(2.0, 2.0, 0.0), DVec3::new(2.0, 1.4, 0.0)]).unwrap();
        {
            let mut tearing = simulation.world().get::<&mut Tearing>(body.entity()).unwrap();
            *tearing = Tearing {
                strength_across_fibres: value,
                strength_along_fibres: value,
                exponent: value,
                cone: value,
                radius: value,
                may_initiate: true,
                ..*tearing
            };
        }
        for _ in 0..5 {
            simulation.step(10.0).unwrap();
            assert_finite(&simulation, body);
        }
        let _ = simulation.frame();
    }
}

/// A blade was lifted without a word, a puncture found nothing and forceps no tissue.
#[test]
fn points_that_are_no_numbers_are_refused_by_name() {
    use rhexis::components::{Grasp, Jaws, Pose};
    let (mut simulation, body) = spawned();
    let blade = simulation.spawn_blade(0.5, 0.5).unwrap();
    let forceps = simulation.spawn_forceps("jaws", Jaws { radius: 0.5, ..Jaws::default() }, Pose::default()).unwrap();
    let hash = simulation.hash();
    for bad in [DVec3::NAN, DVec3::new(1.0, f64::INFINITY, 0.0), DVec3::new(0.0, 0.0, 1e300)] {
        for (told, what) in [
            (simulation.cut(body, &[DVec3::ZERO, bad]).unwrap_err().to_string(), "a point of the cut is"),
            (simulation.draw_blade(blade, body, bad).unwrap_err().to_string(), "the edge of the blade is"),
            (simulation.puncture(body, bad, DVec3::X, 1.0).unwrap_err().to_string(), "the point of the puncture is"),
            (
                simulation.puncture(body, DVec3::X, bad, 1.0).unwrap_err().to_string(),
                "the direction of the puncture is",
            ),
        ] {
            assert!(told.starts_with("body `") && told.contains(what) && told.contains("finite"), "{told}");
        }
    }
    let ray = Grasp::Ray { origin: DVec3::ZERO, direction: DVec3::NAN, reach: 1.0 };
    for grasp in [ray, Grasp::Point(DVec3::NAN)] {
        let told = simulation.close_forceps(forceps, body, &grasp).unwrap_err().to_string();
        assert!(told.contains("forceps `jaws`: a coordinate of the grasp is NaN: it must be finite"), "{told}");
    }
    assert_eq!(simulation.hash(), hash);
}

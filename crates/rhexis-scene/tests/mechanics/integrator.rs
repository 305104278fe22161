//! TR-BDF2 and the projected tangent in whole steps: tears, threads, retries, compression; what goes with it and what does not.

use crate::common::{self, DT, Square, state_bits};
use glam::DVec3;
use rhexis::components::{Curve, EnergyAudit, Holds, Planar, Sleeping, TearLog, Tearing};
use rhexis::settings::{Accuracy, Advanced, Integrator, Precision, Preconditioner, Settings, Tangent};
use rhexis::simulation::{Simulation, SimulationError};
use rhexis::storage::Vertices;
use rhexis_scene::Document;

fn tr_bdf2() -> Settings {
    Settings { advanced: Advanced { integrator: Integrator::TrBdf2, ..Advanced::default() }, ..Settings::default() }
}

#[test]
fn a_square_tears_through_along_the_same_way() {
    let ends = [Settings::default(), tr_bdf2(), Settings::new(Accuracy::Accurate)].map(|settings| {
        let mut run = Square::new([30, 26], 60.0).spawn(settings);
        run.stretch_to(0.4);
        run.tear_through();
        run.assert_sound();
        run.end()
    });
    // Nearly in equilibrium at every step: the formula of time says when a tip advances, hardly where to. Half of an edge.
    assert!(ends[1].distance(ends[0]) < 0.6 && ends[2].distance(ends[0]) < 0.6, "{ends:?}");
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let run = |threads| {
        let mut square = Square::new([60, 50], 60.0);
        square.tearing.strength_across_fibres *= 0.2;
        square.tearing.strength_along_fibres *= 0.2;
        let mut simulation = Simulation::new(Settings { threads, ..Settings::new(Accuracy::Accurate) }).unwrap();
        let body = square.spawn_into(&mut simulation);
        for _ in 0..14 {
            simulation.step(DT).unwrap();
        }
        assert!(simulation.world().get::<&TearLog>(body.entity()).unwrap().advance_count > 0);
        state_bits(&simulation, body)
    };
    assert!(run(1) == run(2));
}

#[test]
fn a_step_that_fails_is_undone_in_both_stages() {
    for settings in [tr_bdf2(), Settings::new(Accuracy::Accurate)] {
        let mut run = Square::new([20, 16], 45.0).spawn(settings);
        run.step();
        // The grip leaves within the second of two halves, which is halved until it is out of the parts that are done.
        let away = Curve::new(vec![(0.0, 0.0), (17.0, 0.05), (17.5, 1e200)]).unwrap();
        for hold in &mut run.simulation.world().get::<&mut Holds>(run.body.entity()).unwrap().groups {
            hold.curve = away.clone();
        }
        let report = run.simulation.step(DT).unwrap();
        // Sixteenths of 10 ms: 16.875 ms is the last before the grip leaves.
        assert!(report.has_failed && report.time == 16.875, "{}", report.time);
        assert!(run.vertices().position.iter().all(|p| p.length() < 50.0));
        run.assert_sound();
    }
}

#[test]
fn prescribed_motion_leaves_the_velocity_of_its_path() {
    let mut run = Square::new([20, 16], 45.0).spawn(Settings::new(Accuracy::Accurate));
    for _ in 0..5 {
        run.step();
    }
    // The right edge moves at a constant speed from rest on; 1e-12 of it is rounding of positions of 30 mm over 0.03 mm.
    let vertices = run.vertices();
    let right = run.simulation.world().get::<&Holds>(run.body.entity()).unwrap().groups[1].members.rows().to_vec();
    for row in right {
        let off = vertices.velocity[row as usize] - DVec3::X * common::GRIP_SPEED;
        assert!(off.length() < 1e-11 * common::GRIP_SPEED, "{off}");
    }
}

#[test]
fn a_body_at_rest_falls_asleep_between_stages_and_wakes() {
    for settings in [tr_bdf2(), Settings::new(Accuracy::Accurate)] {
        let strong = Tearing { strength_across_fibres: 1e6, strength_along_fibres: 1e6, ..Tearing::default() };
        let square = Square { tearing: strong, ..Square::new([20, 16], 60.0) };
        let path = Curve::new(vec![(0.0, 0.0), (20.0, 0.3), (100.0, 0.3), (110.0, 0.4)]).unwrap();
        let mut simulation = Simulation::new(settings).unwrap();
        let body = simulation.spawn(square.membrane_along(path).with(Sleeping::default())).unwrap();
        let asleep: Vec<bool> = (0..115).map(|_| simulation.step(1.0).unwrap().bodies[0].is_asleep).collect();
        // Not while it is drawn, long before it is drawn again, and from the step on that draws it awake.
        assert!(!asleep[19] && asleep[99] && !asleep[100], "{asleep:?}");
        let moved = simulation.world().get::<&Vertices>(body.entity()).unwrap().position[20].x - common::SIDE;
        // The right end of the bottom row, held.
        assert!((moved - 0.4).abs() < 1e-12, "{moved}");
    }
}

#[test]
fn an_audit_of_another_formula_is_refused_by_name() {
    let mut run = Square::new([20, 16], 45.0).spawn(tr_bdf2());
    run.simulation.world_mut().insert_one(run.body.entity(), EnergyAudit::default()).unwrap();
    let error = run.simulation.step(DT).unwrap_err();
    assert_eq!(error, SimulationError::AuditOfAnotherIntegrator { body: "square".into() });
    assert!(error.to_string().contains("take the audit out"), "{error}");
    // Static solves are none of its business.
    run.simulation.settle(DT, 1e-8).unwrap();
}

#[test]
fn a_scene_says_how_accurate_it_is() {
    let settings = |keys: &[&str]| {
        let mut document = Document::named("fig2-tear").unwrap();
        keys.iter().for_each(|key| document.set(key).unwrap());
        document.scene().unwrap().instantiate().map(|instance| *instance.simulation.settings())
    };
    let accurate = settings(&["run.accuracy=accurate", "run.advanced.newton_iterations=3"]).unwrap();
    assert_eq!(accurate.advanced.linear, Settings::new(Accuracy::Accurate).advanced.linear);
    assert_eq!((accurate.advanced.integrator, accurate.advanced.tangent), (Integrator::TrBdf2, Tangent::Projected));
    assert_eq!(accurate.advanced.newton_iterations, 3);
    let other = settings(&["run.advanced.integrator=tr_bdf2", "run.advanced.tangent=projected"]).unwrap();
    assert_eq!((other.advanced.integrator, other.advanced.tangent), (Integrator::TrBdf2, Tangent::Projected));
    assert_eq!(other.advanced.linear, Settings::default().advanced.linear);
    let refused = settings(&["run.advanced.integrator=tr_bdf2", "output.energy=true"]).unwrap_err();
    assert!(refused.to_string().contains("backward_euler"), "{refused}");
}

/// A square pressed together by 20 % within 20 steps, free to buckle: in how many of them a solve fell back, and whether all went
/// well.
fn pressed(settings: Settings) -> (u32, bool) {
    let strong = Tearing { strength_across_fibres: 1e6, strength_along_fibres: 1e6, ..Tearing::default() };
    let mut run = Square { tearing: strong, ..Square::new([20, 16], 30.0) }.spawn(settings);
    for hold in &mut run.simulation.world().get::<&mut Holds>(run.body.entity()).unwrap().groups {
        hold.curve = Curve::ramp(20.0, -0.1 * common::SIDE).unwrap();
    }
    run.simulation.world_mut().remove_one::<Planar>(run.body.entity()).unwrap();
    for (v, velocity) in
        run.simulation.world().get::<&mut Vertices>(run.body.entity()).unwrap().velocity.iter_mut().enumerate()
    {
        velocity.z = 1e-2 * (12.9898 * v as f64).sin();
    }
    let (mut fell_back, mut is_well) = (0, true);
    for _ in 0..20 {
        let report = run.simulation.step(1.0).unwrap();
        fell_back += u32::from(report.bodies[0].fell_back);
        // Where two iterations have made energy of a step that buckles, its halves have to do.
        is_well &= !report.has_failed;
    }
    is_well &= run.vertices().position.iter().all(|x| x.is_finite());
    (fell_back, is_well)
}

#[test]
fn the_projected_tangent_never_falls_back_under_compression() {
    for precision in [Precision::Mixed, Precision::Double] {
        for preconditioner in [Preconditioner::Auto, Preconditioner::IncompleteCholesky, Preconditioner::Cholesky] {
            let twice = Settings {
                advanced: Advanced { newton_iterations: 2, precision, preconditioner, ..Advanced::default() },
                ..Settings::default()
            };
            let exact = pressed(Settings { advanced: Advanced { tangent: Tangent::Exact, ..twice.advanced }, ..twice });
            let projected =
                pressed(Settings { advanced: Advanced { tangent: Tangent::Projected, ..twice.advanced }, ..twice });
            println!("{precision:?} {preconditioner:?}: exact {exact:?}, projected {projected:?}");
            assert!(projected.0 == 0 && projected.1, "{projected:?}");
            // Else this shows nothing.
            assert!(exact.0 > 15, "{exact:?}");
        }
    }
}

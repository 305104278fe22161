//! Limits that act on tears are counted and told: the speed of waves, and decisions that energy was to take.

use crate::common::Square;
use glam::DVec3;
use rhexis::components::{EnergyCriterion, RingFault, TearMode, Tearing, Toughness};
use rhexis::event::EventKind;
use rhexis::settings::Settings;

#[test]
fn a_tear_that_is_held_back_by_the_speed_of_waves_is_counted_and_told_once() {
    // A stretched sheet that is made weak at once.
    let told = |dt: f64| {
        let square = Square::isotropic([20, 16]);
        let weak = Tearing { mode: TearMode::Glide, ..square.tearing };
        let strong = Tearing { strength_across_fibres: 10.0, strength_along_fibres: 10.0, ..weak };
        let mut run = Square { tearing: strong, ..square }.spawn(Settings { threads: 1, ..Settings::default() });
        run.stretch_to(2.4);
        run.simulation.set(run.body, weak).unwrap();
        // 0.874·√(G/ρ).
        let allowed = 0.874 * (3.0_f64 / 2.6 / 1e-3).sqrt() * dt;
        let mut events = 0;
        for _ in 0..60 {
            let before = run.log().length;
            run.simulation.step(dt).unwrap();
            let way = run.log().length - before;
            assert!(way <= allowed * (1.0 + 1e-9), "{way} of {allowed} mm");
            let is_told = |kind: &EventKind| matches!(kind, EventKind::HeldBack { criterion, .. } if *criterion > 1.0);
            events += run.simulation.drain_events().filter(|event| is_told(&event.kind)).count();
        }
        let body = &run.simulation.report().bodies[0];
        assert_eq!((body.tear_held_back, body.held_back_criterion), {
            let log = run.log();
            (log.held_back_count, log.held_back_criterion)
        });
        (events, body.tear_held_back, body.held_back_criterion)
    };
    // 0.03 mm in a step.
    let (events, steps, criterion) = told(1e-3);
    assert_eq!(events, 1);
    assert!(steps > 10 && criterion > 1.5, "{steps} steps, criterion {criterion}");
    assert_eq!(told(10.0), (0, 0, 0.0));
}

#[test]
fn decisions_by_the_material_force_are_counted_by_reason() {
    // A slit shorter than the disc of three edges, and the notch, whose disc meets the rim; and a load too small for any advance.
    let coarse = Square { tearing: Tearing { radius: 0.9, ..Tearing::default() }, ..Square::isotropic([30, 30]) };
    let mut run = coarse.spawn(Settings { threads: 1, ..Settings::default() });
    let tough = EnergyCriterion::new(Toughness { along: 1e3, across: 1e3 });
    run.simulation.world_mut().insert_one(run.body.entity(), tough).unwrap();
    run.simulation.cut(run.body, &[DVec3::new(15.0, 16.0, 0.0), DVec3::new(15.0, 14.0, 0.0)]).unwrap();
    (0..7).for_each(|_| _ = run.simulation.step(1.0).unwrap());
    let log = run.log();
    assert_eq!((log.material_force_count, log.energy_decision_count), (0, 0));
    let without = log.force_decision_counts[RingFault::NoCrack as usize];
    assert_eq!((without, log.force_decision_counts.iter().sum::<u64>()), (14, 21));
}

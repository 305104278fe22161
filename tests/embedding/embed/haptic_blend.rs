//! Models that follow each other at a device: no jumps, and no energy from them.

use glam::{DMat3, DVec3};
use rhexis::simulation::{HapticBlend, HapticModel};

fn model(time: f64, force: DVec3, stiffness: f64) -> HapticModel {
    HapticModel { time, position: DVec3::ZERO, force, stiffness: DMat3::from_diagonal(DVec3::splat(stiffness)) }
}

#[test]
fn the_force_is_continuous_when_models_come() {
    let mut blend = HapticBlend::new(10.0);
    let at = DVec3::new(0.1, -0.2, 0.3);
    assert_eq!(blend.force_at(1.0, at), None);
    blend.hand_over(&model(0.0, DVec3::X, 5.0));
    let mut last = blend.force_at(1.0, at).unwrap();
    for i in 1..200 {
        // They come faster and slower than the interval.
        if i % 7 == 0 || i % 17 == 0 {
            let next = model(f64::from(i), DVec3::new(f64::from(i % 5), f64::from(i % 3), 1.0), f64::from(i % 4));
            let before = blend.model().unwrap().force_at(at);
            blend.hand_over(&next);
            // The same sum of a few products of numbers up to ten.
            assert!(blend.model().unwrap().force_at(at).distance(before) < 1e-13);
        }
        let force = blend.force_at(1.0, at).unwrap();
        // A tenth of what lies between two models, of which none is larger than 10 N here.
        assert!(force.distance(last) < 1.0, "{i}: {last} then {force}");
        last = force;
    }
    assert_eq!(blend.force_at(f64::NAN, at), None);
    assert_eq!(blend.force_at(1.0, DVec3::NAN), None);
}

#[test]
fn the_forces_of_one_model_are_left_as_they_are() {
    let mut blend = HapticBlend::new(10.0);
    let spring = model(0.0, DVec3::ZERO, 2.0);
    blend.hand_over(&spring);
    for i in 0..1000 {
        let angle = f64::from(i) * 0.02;
        let at = DVec3::new(angle.sin(), (2.0 * angle).sin(), 1.0 - angle.cos());
        let force = blend.force_at(1.0, at).unwrap();
        // But for the last of what is stored, as much as two motions of 0.04 mm take.
        assert!(force.distance(spring.force_at(at)) < 0.2, "{i}: {force}");
    }
    assert!(blend.withheld() < 1e-2, "{}", blend.withheld());
}

/// A pull whenever the hand goes along with it, and none on its way back: such models are a motor.
#[test]
fn no_cycle_of_the_hand_gains_energy_from_changing_models() {
    for interval in [0.0, 3.0, 20.0] {
        let mut blend = HapticBlend::new(interval);
        blend.hand_over(&model(0.0, DVec3::ZERO, 1.0));
        let (mut work, mut last): (f64, Option<(DVec3, DVec3)>) = (0.0, None);
        for i in 0..10_000_u32 {
            let angle = f64::from(i) * 0.01;
            let at = DVec3::X * (1.0 - angle.cos());
            let pull = if angle.sin() > 0.0 { DVec3::NEG_X } else { DVec3::ZERO };
            if i % 10 == 0 {
                blend.hand_over(&HapticModel { position: at, ..model(f64::from(i) + 1.0, pull, 0.5) });
            }
            let force = blend.force_at(1.0, at).unwrap();
            if let Some((before, force_before)) = last {
                let way = at - before;
                work += 0.5 * (force + force_before).dot(way);
            }
            last = Some((at, force));
            // It starts from rest: its motions grow by 1e-4 mm from call to call, under one newton.
            assert!(work > -1e-4, "{i}: {work}");
        }
        assert!(blend.withheld() > 1.0, "{}", blend.withheld());
    }
}

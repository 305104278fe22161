//! Rough hands on the capsule: grasps anywhere, jerks of millimetres in a step, tears. The body goes with the hand, or an event says why not.

use glam::DVec3;
use proptest::prelude::Rng;
use proptest::test_runner::{RngAlgorithm, TestRng};
use rhexis::components::{Jaws, Pose, Slip};
use rhexis::event::EventKind;
use rhexis::report::BodyReport;
use rhexis::simulation::Grasp;
use rhexis::storage::ForcepsId;
use rhexis_scene::{Document, Instance};

/// Steps in which a body that a moving hand holds may stand still unreported.
const STILL: u32 = 5;

/// Steps of a hand.
const STEPS: u32 = 60;

struct Dice(TestRng);

impl Dice {
    fn new(hand: u64) -> Self {
        let mut seed = [7; 32];
        seed[..8].copy_from_slice(&hand.to_le_bytes());
        Self(TestRng::from_seed(RngAlgorithm::ChaCha, &seed))
    }

    /// In 0..1.
    fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn chance(&mut self, part: f64) -> bool {
        self.unit() < part
    }

    fn vector(&mut self, size: f64) -> DVec3 {
        let mut component = || size * (2.0 * self.unit() - 1.0);
        DVec3::new(component(), component(), component())
    }
}

fn capsule() -> Instance {
    let mut document = Document::named("capsulorhexis").unwrap();
    for set in ["bodies.0.mesh.cap.triangles=1500", "bodies.0.refinement.budget=3", "run.dt=10"] {
        document.set(set).unwrap();
    }
    document.scene().unwrap().instantiate().unwrap()
}

fn positions(instance: &mut Instance) -> Vec<DVec3> {
    instance.simulation.view(instance.bodies[0]).unwrap().positions.to_vec()
}

/// Whether the guard acted in a step.
fn is_guarded(report: &BodyReport) -> bool {
    report.guard.refusals() > 0 || report.is_step_limited || report.any_substep_limited || report.fault.is_some()
}

/// Plays a hand; the longest time that it moved what it held and the body stood still, in steps, and of that what no event had
/// reported.
fn play(hand: u64) -> (u32, u32) {
    let (mut dice, mut instance) = (Dice::new(hand), capsule());
    let (body, dt) = (instance.bodies[0], instance.run.dt);
    let mut held: Option<(ForcepsId, DVec3)> = None;
    let (mut still, mut untold, mut is_told, mut longest, mut longest_untold) = (0, 0, false, 0, 0);
    for step in 0..STEPS {
        let before = positions(&mut instance);
        match held {
            Some((forceps, _)) if dice.chance(0.1) => {
                instance.simulation.open_forceps(forceps).unwrap();
                instance.simulation.despawn(forceps).unwrap();
                held = None;
            }
            Some((forceps, at)) => {
                let jerk = if dice.chance(0.3) { 3.0 } else { 0.2 };
                let to = at + dice.vector(jerk);
                instance.simulation.move_forceps(forceps, Pose::at(to), dt).unwrap();
                held = Some((forceps, to));
            }
            None => {
                let at = before[(dice.unit() * before.len() as f64) as usize];
                let slip = if dice.chance(0.5) { Slip::Slide } else { Slip::LetGo };
                let jaws = Jaws { radius: 0.3, stiffness: Some(0.2), force_limit: Some(0.05), slip };
                let forceps = instance.simulation.spawn_forceps("hand", jaws, Pose::at(at)).unwrap();
                let _ = instance.simulation.close_forceps(forceps, body, &Grasp::Nearest { reach: 1.0 });
                held = Some((forceps, at));
            }
        }
        let report = instance.advance().unwrap_or_else(|error| panic!("hand {hand}, step {step}: {error}"));
        let is_guarded = report.bodies.iter().any(is_guarded);
        // The guard is reported when it begins to act, and again once a step has passed without.
        is_told &= is_guarded;
        is_told |= instance.simulation.drain_events().any(|event| {
            matches!(event.kind, EventKind::StepGuarded { .. } | EventKind::StepFailed { .. } | EventKind::FellAsleep)
        });
        let holds = held.is_some_and(|(forceps, _)| instance.simulation.forceps(forceps).unwrap().force != DVec3::ZERO);
        let now = positions(&mut instance);
        let stands = holds && before.len() == now.len() && before == now;
        still = if stands { still + 1 } else { 0 };
        untold = if stands && !is_told { untold + 1 } else { 0 };
        (longest, longest_untold) = (longest.max(still), longest_untold.max(untold));
        assert!(untold <= STILL, "hand {hand}, step {step}: the body has stood still for {untold} steps, untold");
    }
    instance.simulation.validate().unwrap();
    (longest, longest_untold)
}

#[test]
fn no_body_stands_still_untold() {
    (0..5).for_each(|hand| _ = play(hand));
}

#[test]
#[ignore = "a thousand hands take minutes: cargo test --release --test embedding hands -- --ignored --nocapture"]
fn no_body_stands_still_untold_under_a_thousand_hands() {
    let (mut longest, mut untold) = (0, 0);
    for hand in 0..1000 {
        let (still, of_that) = play(hand);
        (longest, untold) = (longest.max(still), untold.max(of_that));
    }
    println!("1000 hands, {STEPS} steps each: still for {longest} steps at the most, {untold} of them untold");
}
